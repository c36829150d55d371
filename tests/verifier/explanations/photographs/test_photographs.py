"""Could a film be a table of photographs?  Beside each test: what it would catch."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from kit.photographed import (
    FRAMES,
    LAW,
    TYPICAL,
    depth_of,
    faded,
    found_in,
    noise_of,
    signal,
)
from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.decision import judge
from moireid.verifier.decision.judge import judge_signals
from moireid.verifier.decision.sheet_gain import SheetGain
from moireid.verifier.explanations.photographs import waveform
from moireid.verifier.explanations.photographs.waveform import MOST_PHOTOGRAPHS, waveform_of

# How many photographs?


def test_more_photographs_are_needed_for_a_wider_course():
    """Catches: a count of the design, and none of the film: it grows as the range of parallax."""
    overtone = TYPICAL + noise_of(0.003, 4)
    counts = [waveform_of(signal(overtone, law=wide * LAW)).photographs for wide in (0.5, 1.0, 2.0)]
    assert counts[0] < counts[1] < counts[2] < MOST_PHOTOGRAPHS
    # The dip goes with the square of the step, so steps are alike and their number goes with the range.
    assert counts[2] - 1 == pytest.approx(2 * (counts[1] - 1), rel=0.25)


def test_the_count_is_borne_out_by_the_film_s_own_test():
    """Catches: a count that promises more than a film shows: coding takes away a part of what so many would show."""
    least = waveform_of(signal(TYPICAL + noise_of(0.003, 4))).photographs
    uncoded = {n: waveform_of(signal(faded(n) + noise_of(0.003, 4))) for n in (least, 3 * least)}
    assert uncoded[least].ripple > uncoded[least].limit
    assert uncoded[3 * least].ripple <= uncoded[3 * least].limit


def test_a_clear_phase_asks_for_more():
    """Catches: photographs counted by the waveform alone where the phase between them would give them away."""
    faint = signal(1e-4 * (TYPICAL + noise_of(0.003, 4)))
    clear, vague = (replace(faint, phase_sd_rad=np.full(FRAMES, sd)) for sd in (0.01, 0.4))
    assert waveform_of(vague).photographs == 2 < waveform_of(clear).photographs


def test_a_tested_spacing_asks_for_another_distance_and_adds_nothing():
    """Catches: a count doubled for one photograph from another distance; a count that is not that of the text."""
    overtone = TYPICAL + noise_of(0.003, 4)
    level = found_in(signal(overtone, depth=depth_of(1.0, change_rad=0.0003)))
    tested = found_in(signal(overtone, depth=depth_of(1.0, change_rad=0.02)))
    assert tested["photographs"].measured == level["photographs"].measured
    assert "another distance" in tested["photographs"].text and "distance" not in level["photographs"].text
    for found in (level, tested):
        (told,) = re.findall(r"at least (\d+) along", found["photographs"].text)
        assert int(told) == level["photographs"].measured


def test_a_trajectory_that_asks_for_too_many_to_count_reports_more_than(monkeypatch):
    """Catches: a count of the last number tried, given as exact."""
    for module in (waveform, judge):
        monkeypatch.setattr(module, "MOST_PHOTOGRAPHS", 12)
    found = found_in(signal(law=2 * LAW))["photographs"]
    assert found.measured == 12
    assert "more than 12 " in found.text and "at least" not in found.text


def rested(shift_rad: float) -> tuple[np.ndarray, np.ndarray]:
    """Law and picture of two photographs, held for long, one frame of each turn mixed, and held once more elsewhere."""
    law = np.concatenate([np.tile(np.r_[np.full(14, -0.4), 0.2, np.full(14, 0.4), -0.1], 9), np.full(30, 0.4)])
    place = law.copy()
    law[-30:] += shift_rad
    return law, place


def test_two_photographs_that_rest_for_long_are_two():
    """Catches: photographs counted at even distances alone, where a forger takes them where his film rests; a picture
    that is moved after a cut counted as another photograph, as the law's phase is elsewhere there.
    """
    for shift_rad in (0.0, 6.0, 2 * np.pi):
        law, place = rested(shift_rad)
        stretch = np.r_[np.zeros(len(law) - 30, np.int64), np.ones(30, np.int64)]
        held = replace(
            signal(law=law),
            measured_rad=within_stretches(place, stretch),
            predicted_rad=within_stretches(law, stretch),
            phase_rad=place + np.where(stretch == 1, 2 * np.pi * round(shift_rad / 2 / np.pi), 0.0),
            stretch=stretch,
        )
        assert waveform_of(held).photographs == 2


# Findings.

OPEN = {"spacing": signal(depth=depth_of(0.0, change_rad=0.02)), "waveform": signal(faded(8) + noise_of(0.002, 1))}


def test_a_badge_passes_and_its_texts_hold_no_word_of_photographs_found():
    """Catches: a passing film whose findings read as an accusation, or whose figures are the wrong way round."""
    found = found_in(signal(TYPICAL + noise_of(0.003, 4), depth=depth_of(0.97, change_rad=0.02)))
    levels = {code: reason.level for code, reason in found.items()}
    held = ("spacing", "waveform", "cross_fade", "third_harmonic")
    assert levels == dict.fromkeys(held, "pass") | {"photographs": "note"}
    for reason in found.values():
        assert not re.search(r"as on photographs|cross-faded|[Ff]ilm (without|in)|Film again", reason.text), reason.text
    assert found["spacing"].measured == pytest.approx(0.97, abs=0.05) and "follows" in found["spacing"].text
    assert found["waveform"].measured <= found["waveform"].limit and "keep their shape" in found["waveform"].text


def test_a_level_course_is_told_of_as_untested_and_without_a_figure():
    """Catches: the gain of noise shown to a holder whose film simply had one distance."""
    vague = found_in(signal(depth=depth_of(-0.6, noise=3.0, change_rad=0.0005)))["spacing"]
    assert vague.level == "note" and vague.measured is None and not re.search(r"\d", vague.text)


@pytest.mark.parametrize("code", ["spacing", "waveform"])
def test_photographs_leave_a_film_open_and_say_what_to_do(code):
    """Catches: a finding that is not acted upon, one that names the other cause, a text without a next step."""
    found = found_in(OPEN[code])
    levels = {name: reason.level for name, reason in found.items() if name != "photographs"}
    assert levels.pop(code) == "undecided" and set(levels.values()) <= {"pass", "note"}
    assert "photographs" in found[code].text and re.search(r"Film (without|in) ", found[code].text)
    outcome = judge_signals([OPEN[code]])
    assert outcome.verdict == "inconclusive"
    assert [reason.code for reason in outcome.reasons if reason.level == "undecided"] == [code]


@pytest.mark.parametrize(("gain", "size"), [(-1e3, 0.1), (0.0, 1e3), (1e3, 0.1), (1e3, 1e3)])
def test_neither_ever_rejects_a_film(gain, size):
    """Catches: a zoom, or a shadow that moves, called a forgery."""
    wild = signal(size * faded(5), depth=depth_of(gain, change_rad=0.02))
    found = found_in(wild)
    assert {found["spacing"].level, found["waveform"].level} == {"undecided"} and found["photographs"].level == "note"
    assert judge_signals([wild]).verdict == "inconclusive"


def test_the_worst_waveform_is_told_and_the_best_count():
    """Catches: a good grating that hides a bad one; a badge of two axes counted by its weaker one."""
    good, bad = signal(TYPICAL + noise_of(0.003, 4)), signal(faded(8), law=0.6 * LAW)
    both = found_in(good, bad)
    assert both["waveform"].level == "undecided"
    assert both["waveform"].measured == found_in(bad)["waveform"].measured
    assert both["photographs"].measured == max(found_in(one)["photographs"].measured for one in (good, bad))


@pytest.mark.parametrize(("gain", "verdict"), [(0.7, "inconclusive"), (0.4, "reject"), (-0.8, "reject")])
def test_fringes_that_tell_of_a_zoom_excuse_a_gain_that_a_zoom_makes(gain, verdict):
    """Catches: a film that was zoomed slowly called a forgery; photographs that stand or turn round excused by it."""
    course = LAW - LAW.mean()
    zoomed, built = signal(depth=depth_of(0.0, change_rad=0.02), measured=gain * course), SheetGain(built=True)
    assert judge_signals([zoomed], built).verdict == verdict
    assert judge_signals([signal(measured=gain * course)], built).verdict == "reject"
