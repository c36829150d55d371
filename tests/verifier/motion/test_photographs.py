"""Could a film be a table of photographs?  Beside each test: what it would catch."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.fringes.beyond_phase import BeyondPhase
from moireid.verifier.fringes.depth_law import DepthLaw
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import GAIN_TOLERANCE_SHARE, MAX_RIPPLE_CONTRASTS, RESTING_STILLS, SPACING_FLOOR_RAD
from moireid.verifier.motion.judge import judge_signals
from moireid.verifier.motion.photographs import (
    MOST_PHOTOGRAPHS,
    Course,
    Spacing,
    cross_faded,
    no_photographs,
    rests,
    seen_most,
    spacing_of,
    waveform_of,
)
from moireid.verifier.reasons import Reason
from moireid.verifier.session.claim import with_photographs

FRAMES = 300
TIMES = np.arange(FRAMES) / 30.0
#: A hand's course: 5 rad of fringe phase from end to end.
LAW = 1.9 * np.sin(2 * np.pi * 0.31 * TIMES) + 0.8 * np.sin(2 * np.pi * 0.83 * TIMES + 1.0)
NEAR = 1e-3 * (1 + 0.03 * np.sin(2 * np.pi * 0.23 * TIMES + 0.4))
#: The third harmonic of a badge, in contrasts.
TYPICAL = 0.08 * np.exp(0.7j)
#: Change of phase along a strip for which evidence is made, rad.
CHANGE_RAD = 0.004


def depth_of(
    gain: float, *, noise: float = 0.0, seed: int = 0, information: float = 1.0, change_rad: float = CHANGE_RAD
) -> DepthLaw:
    """Evidence of a spacing gain; noise: of a frame's gain, where its information is 1."""
    rng = np.random.default_rng(seed)
    known = information * rng.random(FRAMES)
    score = known * (gain - 1) + noise * np.sqrt(known) * rng.standard_normal(FRAMES)
    return DepthLaw(score, known, known * change_rad**2)


def signal(
    overtone: np.ndarray | None = None,
    *,
    law: np.ndarray = LAW,
    depth: DepthLaw | None = None,
    near: np.ndarray | None = NEAR,
    measured: np.ndarray | None = None,
) -> GratingSignal:
    """A badge's signal, whose place in the picture tells nothing."""
    rng = np.random.default_rng(5)
    beyond = BeyondPhase(
        law,
        depth or depth_of(1.0),
        np.full(FRAMES, TYPICAL) if overtone is None else overtone,
        rng.standard_normal((FRAMES, 2)),
    )
    course = law - law.mean()
    return GratingSignal(
        course + 0.01 * rng.standard_normal(FRAMES) if measured is None else measured,
        course,
        np.full(FRAMES, 0.01),
        0.01,
        np.array([0.005, 0.01]),
        TIMES,
        np.array([0.02, 0.02]),
        covariates=None if near is None else np.column_stack([np.zeros(FRAMES), near]),
        beyond=beyond,
    )


def as_the_law(forged: GratingSignal) -> bool:
    """Stands for the judge: a signal passes if it is near the prediction, its gain within the tolerance."""
    power = float(forged.predicted_rad @ forged.predicted_rad)
    gain = float(forged.predicted_rad @ forged.measured_rad) / power
    left = forged.measured_rad - gain * forged.predicted_rad
    return abs(gain - 1) <= GAIN_TOLERANCE_SHARE and float(left.std()) < 0.1


def faded(count: int, law: np.ndarray = LAW) -> np.ndarray:
    """The overtone that so many cross-faded photographs of a badge show, turned to the fundamental."""
    first, third = cross_faded(law, np.linspace(law.min(), law.max(), count))
    return TYPICAL * third * np.exp(-3j * np.angle(first)) / np.abs(first)


def noise_of(size: float, seed: int, lasting: float = 0.0) -> np.ndarray:
    """Complex noise of standard deviation `size` in each part, which correlates by `lasting` from frame to frame."""
    rng = np.random.default_rng(seed)
    drawn = rng.standard_normal((FRAMES, 2)) @ [1, 1j]
    noise = drawn.copy()
    for k in range(1, FRAMES):
        noise[k] = lasting * noise[k - 1] + math.sqrt(1 - lasting**2) * drawn[k]
    return size * noise


def found_in(*signals: GratingSignal) -> dict[str, Reason]:
    return {reason.code: reason for reason in no_photographs(signals, signals, as_the_law)}


# Spacing.


@pytest.mark.parametrize("sd", [0.0, 0.02, 0.1, 0.3, 0.36, 0.6, 3.0])
def test_where_the_spacing_is_tested_a_table_of_photographs_is_wrong_and_nowhere_else(sd):
    """Catches: a film called tested whose error bar lets a table pass; a table called wrong by a vague figure."""
    table, badge = Spacing(0.0, sd), Spacing(1.0, sd)
    assert table.tested == table.wrong == (sd <= 0.3)
    assert not badge.wrong and badge.tested == table.tested


@pytest.mark.parametrize(("gain", "sd", "wrong"), [(0.8, 0.02, False), (1.2, 0.02, False), (0.2, 0.02, True)])
def test_a_small_error_of_the_law_is_forgiven_and_a_reversed_one_is_not(gain, sd, wrong):
    """Catches: a limit that is the error bar's alone, where a sheet 20 % thicker than said would be left open."""
    assert Spacing(gain, sd).wrong == wrong
    assert Spacing(2 - gain, sd).wrong == wrong and Spacing(-gain, sd).wrong


@pytest.mark.parametrize(("gain", "frames", "wrong"), [(1.9, 66, False), (1.9, FRAMES, True), (0.0, 66, True)])
def test_few_times_leave_doubt_where_no_photograph_would_be(gain, frames, wrong):
    """Catches: an honest film of two seconds left open for a spacing that changes too much by chance, as happened with
    1.86 ± 0.25; and a doubt that lets a photograph pass.
    """
    slow = np.tile(np.repeat([1.0, -1.0], 15), FRAMES)[:FRAMES]
    clear = depth_of(gain, change_rad=0.02)
    depth = replace(clear, score=clear.score + 0.5 * clear.information * slow).part(slice(frames))
    one = signal(depth=depth)
    found = spacing_of([replace(one, times_s=one.times_s[:frames])])
    assert found is not None and found.wrong == wrong and found.tested


def test_the_gain_is_of_all_gratings_together():
    """Catches: a mean of gains, in which a grating without evidence counts as much as one with."""
    clear, vague = signal(depth=depth_of(1.0, information=20.0)), signal(depth=depth_of(0.0, seed=1))
    both = spacing_of([clear, vague])
    assert both is not None and both.gain == pytest.approx(20 / 21, abs=0.01)
    alone = spacing_of([clear])
    assert alone is not None and alone.gain == pytest.approx(1.0)
    assert spacing_of([replace(clear, beyond=None)]) is None
    nothing = DepthLaw(*np.zeros((3, FRAMES)))
    assert spacing_of([signal(depth=nothing)]) is None


def test_the_error_bar_is_honest_where_errors_last():
    """Catches: frames counted as independent where the errors of a hand's poses last for a second."""
    off, bars = [], []
    for seed in range(60):
        slow = np.repeat(np.random.default_rng(seed).standard_normal(FRAMES // 15), 15)
        clear = depth_of(1.0, seed=seed)
        known = replace(clear, score=clear.score + 0.5 * clear.information * slow)
        found = spacing_of([signal(depth=known)])
        assert found is not None
        off.append(found.gain - 1)
        bars.append(math.sqrt(max(found.sd**2 - (SPACING_FLOOR_RAD / CHANGE_RAD) ** 2, 0.0)))
    # 20 pieces of half a second: their mean is known to 0.5 / sqrt(20), the bar by 60 films to 10 %.
    assert np.std(off) == pytest.approx(0.5 / math.sqrt(20), rel=0.35)
    assert 0.7 < np.std(off) / np.sqrt(np.mean(np.square(bars))) < 1.4


def test_a_long_pause_takes_no_memory_and_tells_nothing():
    """Catches: sums over each half second of a thousand years, which took all memory or a minute."""
    told = signal(depth=depth_of(1.0, noise=0.3))
    late = np.where(np.arange(FRAMES) < FRAMES // 2, 0.0, 1.0)
    near, far = (spacing_of([replace(told, times_s=TIMES + pause_s * late)]) for pause_s in (100.0, 3e10))
    assert near is not None and far is not None
    assert (far.gain, far.sd, far.pieces) == pytest.approx((near.gain, near.sd, near.pieces), rel=1e-6)


@pytest.mark.parametrize(("change_rad", "tested"), [(0.0003, False), (0.02, True)])
def test_a_distance_that_hardly_changes_tests_nothing(change_rad, tested):
    """Catches: an error bar of numbers without end, as if no error lasted all film long."""
    found = spacing_of([signal(depth=depth_of(1.0, change_rad=change_rad))])
    assert found is not None and found.tested == tested
    forged = spacing_of([signal(depth=depth_of(0.0, change_rad=change_rad))])
    assert forged is not None and forged.wrong == tested and forged.sd == pytest.approx(found.sd)


# Cross-fading.


@pytest.mark.parametrize("count", [2, 3, 7, 30])
def test_cross_faded_is_the_sum_of_two_waves_of_real_cosines(count):
    """Catches: shares exchanged, neighbours by parallax taken in time, a harmonic that turns as the first."""
    first, third = cross_faded(LAW, np.linspace(LAW.min(), LAW.max(), count))
    turn = 2 * np.pi * np.arange(64) / 64
    nodes = LAW.min() + np.arange(count) * np.ptp(LAW) / (count - 1)
    for k in range(0, FRAMES, 7):
        shares = np.maximum(0, 1 - np.abs(LAW[k] - nodes) * (count - 1) / np.ptp(LAW))
        assert shares.sum() == pytest.approx(1) and (shares > 0).sum() <= 2
        # Each photograph shows its own wave of harmonics 1 and 3, of contrast 2 and 0.5.
        seen = sum(
            s * (2 * np.cos(turn + at) + 0.5 * np.cos(3 * turn + 3 * at)) for s, at in zip(shares, nodes, strict=True)
        )
        for h, size, told in ((1, 2.0, first[k]), (3, 0.5, third[k])):
            cosine, sine = (seen * np.cos(h * turn)).mean() * 2, (seen * np.sin(h * turn)).mean() * 2
            assert (cosine / size, -sine / size) == pytest.approx((told.real, told.imag), abs=1e-9)


def test_at_a_photograph_s_own_place_it_is_shown_alone():
    """Catches: a cross-fade that never is one photograph; ends of the course beyond the last one."""
    law = np.linspace(-2, 2, 9)
    first, third = cross_faded(law, np.linspace(law.min(), law.max(), 9))
    assert first == pytest.approx(np.exp(1j * law)) and third == pytest.approx(np.exp(3j * law))
    between, dipped = cross_faded(law, np.linspace(law.min(), law.max(), 5))
    assert np.abs(between[1]) == pytest.approx(math.cos(0.5)) and np.abs(dipped[1]) == pytest.approx(abs(math.cos(1.5)))


# Waveform.


def ripple_of(overtone: np.ndarray, **how) -> tuple[float, float]:
    """Ripple and limit."""
    found = waveform_of(signal(overtone, **how), lambda forged: False)
    assert found is not None
    return found.ripple, found.limit


@pytest.mark.parametrize("count", [8, 10, 12, 14])
def test_the_ripple_of_cross_faded_photographs_is_found_and_of_its_size(count):
    """Catches: a ripple that the slow part takes up, one part of the complex number alone."""
    # Evenly over the course, so that the shares of a cross-fade are all as frequent: the closed form of its dip.
    law = np.linspace(-4, 4, FRAMES)[np.random.default_rng(2).permutation(FRAMES)]
    share, step = np.linspace(0, 1, 1001), 8 / (count - 1)
    first, third = ((1 - share) + share * np.exp(1j * h * step) for h in (1, 3))
    own = third * np.exp(-3j * np.angle(first)) / np.abs(first)
    expected = abs(TYPICAL) * math.sqrt(np.mean(np.abs(own - own.mean()) ** 2))
    found, limit = ripple_of(faded(count, law), law=law)
    assert found == pytest.approx(expected, rel=0.1)
    assert ripple_of(faded(count, law) + noise_of(0.01, 3), law=law)[0] == pytest.approx(expected, rel=0.3)
    assert found > limit


@pytest.mark.parametrize("lasting", [0.0, 0.6, 0.8])
@pytest.mark.parametrize("size", [0.003, 0.03])
def test_noise_is_no_ripple(size, lasting):
    """Catches: the fine regression's share of any noise taken for ripple, and of noise that lasts even more."""
    found = [ripple_of(TYPICAL + noise_of(size, seed, lasting)) for seed in range(50)]
    assert sum(ripple > limit for ripple, limit in found) <= 1
    # A limit that grows with the noise alone would find nothing: in little noise it is that of a still waveform.
    assert size > 0.01 or np.median([limit for _, limit in found]) < 1.5 * MAX_RIPPLE_CONTRASTS


@pytest.mark.parametrize("share", [0.5, 0.8])
def test_rests_thin_no_ripple_out(share):
    """Catches: a mean over frames, so that photographs held for long hide what lies between them."""
    moving = LAW[:: round(1 / (1 - share))]
    law = np.r_[moving, np.full(FRAMES - len(moving), LAW.max())]
    alone = waveform_of(signal(faded(8)).part(slice(0, FRAMES, round(1 / (1 - share)))), as_the_law)
    held = waveform_of(signal(faded(8, law), law=law), as_the_law)
    assert held.ripple > held.limit and held.ripple == pytest.approx(alone.ripple, rel=0.25)


@pytest.mark.parametrize("share", [0.5, 0.8])
@pytest.mark.parametrize("lasting", [0.0, 0.8])
def test_noise_is_no_ripple_where_a_badge_rests(share, lasting):
    """Catches: weights without the noise that they change: few views of many frames each, many of one."""
    moving = LAW[:: round(1 / (1 - share))]
    law = np.r_[moving, np.full(FRAMES - len(moving), LAW.max())]
    found = [ripple_of(TYPICAL + noise_of(0.01, seed, lasting), law=law) for seed in range(50)]
    assert sum(ripple > limit for ripple, limit in found) <= 2


SWEEP = np.linspace(-3, 3, FRAMES)
#: One sweep that halts five times, and one on which the camera comes nearer again and again: there time and distance
#: change within a little way of parallax.
HALTING = SWEEP - 0.19 * np.sin(np.pi * TIMES)
WAVING = 1e-3 * (1 + 0.03 * np.sin(2 * np.pi * 0.9 * TIMES))


@pytest.mark.parametrize(
    ("law", "near", "change"),
    [
        (LAW, NEAR, lambda place, near, time: place**4 / 4 - place**3 / 2 + place),
        (SWEEP, WAVING, lambda place, near, time: near),
        (SWEEP, WAVING, lambda place, near, time: near**2),
        (SWEEP, WAVING, lambda place, near, time: near * place),
        (HALTING, NEAR, lambda place, near, time: time - time**3 / 2),
    ],
    ids=["parallax", "distance", "its square", "distance by parallax", "time"],
)
def test_a_waveform_that_changes_slowly_is_no_ripple(law, near, change):
    """Catches: a lens out of focus at an angle, a camera that comes nearer, a light that is dimmed, called forged."""
    slow = change(*((series - series.mean()) / series.std() for series in (law, near, TIMES)))
    found, limit = ripple_of(TYPICAL * (1 + 0.3 * slow) + noise_of(0.001, 1), law=law, near=near)
    assert found < 0.5 * MAX_RIPPLE_CONTRASTS < limit


def test_ripple_is_by_place_and_not_by_time():
    """Catches: a shadow's flicker taken for photographs, though it has no place."""
    flicker = 0.02 * np.sign(np.sin(2 * np.pi * 3.7 * TIMES))
    found, limit = ripple_of(TYPICAL + flicker)
    assert found < limit


def test_a_short_film_is_told_by_what_it_has():
    """Catches: a grid too fine for the frames, so that a few seconds are never held against a badge's waveform."""
    short = signal(faded(8) + noise_of(0.002, 1)).part(slice(0, 120))
    found = waveform_of(short, as_the_law)
    assert found is not None and found.ripple > found.limit


def test_a_film_of_few_frames_tells_no_waveform():
    """Catches: a regression with more unknowns than frames, which leaves no noise to compare with."""
    short = signal().part(slice(0, 12))
    assert waveform_of(short, as_the_law) is None
    blank = replace(signal(), phase_sd_rad=np.full(FRAMES, np.inf))
    assert waveform_of(blank, as_the_law) is None
    assert waveform_of(replace(signal(), beyond=None), as_the_law) is None
    found = found_in(short)
    assert "waveform" not in found and "photographs" not in found and "spacing" in found


def test_a_course_leaves_out_frames_that_cannot_be_read():
    """Catches: the noise of unread frames in the waveform."""
    overtone = np.full(FRAMES, TYPICAL)
    overtone[100:130] = noise_of(5.0, 1)[:30]
    sd = np.full(FRAMES, 0.01)
    sd[100:130] = np.inf
    unread = replace(signal(overtone), phase_sd_rad=sd)
    found = waveform_of(unread, as_the_law)
    assert found is not None and found.ripple < MAX_RIPPLE_CONTRASTS
    assert Course(unread).used.sum() == FRAMES - 30


# How many photographs?


def test_more_photographs_are_needed_for_a_wider_course():
    """Catches: a count of the design, and none of the film: it grows as the range of parallax."""
    overtone = TYPICAL + noise_of(0.003, 4)
    counts = [waveform_of(signal(overtone, law=wide * LAW), as_the_law).photographs for wide in (0.5, 1.0, 2.0)]
    assert counts[0] < counts[1] < counts[2] < MOST_PHOTOGRAPHS
    # The dip goes with the square of the step, so steps are alike and their number goes with the range.
    assert counts[2] - 1 == pytest.approx(2 * (counts[1] - 1), rel=0.25)


def test_the_count_is_borne_out_by_the_film_s_own_test():
    """Catches: a count that promises more than a film shows: coding takes away a part of what so many would show."""
    count = waveform_of(signal(TYPICAL + noise_of(0.003, 4)), as_the_law).photographs
    uncoded = {n: waveform_of(signal(faded(n) + noise_of(0.003, 4)), as_the_law) for n in (count, 3 * count)}
    assert uncoded[count].ripple > uncoded[count].limit
    assert uncoded[3 * count].ripple <= uncoded[3 * count].limit


def test_a_sharp_judge_of_the_phase_asks_for_more():
    """Catches: photographs counted by the waveform alone where the phase between them would give them away."""
    faint = signal(1e-4 * (TYPICAL + noise_of(0.003, 4)))

    def sharp(forged: GratingSignal) -> bool:
        return float((forged.measured_rad - forged.predicted_rad).std()) < 0.005

    assert waveform_of(faint, lambda forged: False).photographs == 2 < waveform_of(faint, sharp).photographs


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


def test_a_course_that_asks_for_too_many_to_count_says_more_than():
    """Catches: a count of the last number tried, given as exact."""
    found = found_in(signal(law=40 * LAW))["photographs"]
    assert found.measured >= MOST_PHOTOGRAPHS
    assert f"more than {MOST_PHOTOGRAPHS} " in found.text and "at least" not in found.text


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
        found = waveform_of(held, as_the_law)
        assert found.photographs == found.stills == 2 and found.rests


@pytest.mark.parametrize("held", [(50, 50), (90, 10), (97, 3)])
def test_where_a_film_is_seen_most_is_found_however_long_it_rests_there(held):
    """Catches: places by even shares of the frames alone, so that one long rest and one short one count as many."""
    place = np.concatenate([np.full(k * 10, at) for k, at in zip(held, (-0.4, 0.7), strict=True)])
    assert seen_most(2, place) == pytest.approx([-0.4, 0.7], abs=1e-3)


def turned(places: tuple[float, ...], rest: int, between: int) -> np.ndarray:
    """Law of a badge that is turned to these places in turn, rests there, and passes what lies between, (FRAMES,)."""
    legs = [
        np.r_[np.full(rest, here), np.linspace(here, there, between + 2)[1:-1]]
        for here, there in zip(places, places[1:] + places[:1], strict=True)
    ]
    return np.resize(np.concatenate(legs), FRAMES)


def test_three_pictures_over_and_over_are_open_and_a_badge_that_rests_is_not():
    """Catches: photographs held for long taken for a film; a holder who rests at three places taken for photographs."""
    stills = turned((-0.8, -0.3, 0.5), 24, 1)
    shown = found_in(signal(law=stills))["photographs"]
    assert (shown.level, shown.measured, shown.limit) == ("undecided", 3.0, RESTING_STILLS)
    assert "3 pictures" in shown.text and "Keep" in shown.text
    assert judge_signals([signal(law=stills)]).verdict == "inconclusive"
    holder = turned((-2.0, 0.0, 2.0), 48, 15)
    assert rests(holder) and found_in(signal(law=holder))["photographs"].level == "note"


def test_a_film_that_rests_nowhere_may_need_three():
    """Catches: a calm film, of which three photographs would make as much as of noise, left open."""
    calm = found_in(signal(law=0.12 * LAW))["photographs"]
    assert not rests(0.12 * LAW) and calm.level == "note"


@pytest.mark.parametrize("least", [1, 12])
def test_a_count_that_is_asked_for_lifts_no_film_that_rests(least):
    """Catches: `--photographs 1` as a way around the finding."""
    found = found_in(signal(law=turned((-0.4, 0.4), 24, 1)))["photographs"]
    assert with_photographs((found,), least) == (found,) and found.level == "undecided"


# Findings.

OPEN = {"spacing": signal(depth=depth_of(0.0, change_rad=0.02)), "waveform": signal(faded(8) + noise_of(0.002, 1))}


def test_a_badge_passes_and_its_texts_hold_no_word_of_photographs_found():
    """Catches: a passing film whose findings read as an accusation, or whose figures are the wrong way round."""
    found = found_in(signal(TYPICAL + noise_of(0.003, 4), depth=depth_of(0.97, change_rad=0.02)))
    levels = {code: reason.level for code, reason in found.items()}
    assert levels == {"spacing": "pass", "waveform": "pass", "photographs": "note"}
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


@pytest.mark.parametrize("gain", [-1e3, 0.0, 1e3])
@pytest.mark.parametrize("size", [0.1, 1e3])
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
    zoomed = signal(depth=depth_of(0.0, change_rad=0.02), measured=gain * course)
    assert judge_signals([zoomed]).verdict == verdict
    assert judge_signals([signal(measured=gain * course)]).verdict == "reject"
