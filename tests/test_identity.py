"""From cell readings to an identity, on made-up measurements.  Beside each test: the wrong implementation it catches."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.verifier.camera import CameraFit
from moireid.verifier.fringe import StripPhase
from moireid.verifier.identity import Identity, judge_identity
from moireid.verifier.measure import Measurement
from moireid.verifier.strips import ProfileReader
from moireid.verifier.track import Track

FRAMES = 70


def film_of(
    badge: Badge, *, nuisance_per_mm: float = 0.0, sd: float = 4e-5, change: dict[int, float] | None = None,
    vague: tuple[int, ...] = (), seen: Badge | None = None,
) -> tuple[Track, Measurement]:  # fmt: skip
    """What a film of `badge` would tell of its cells, cut into the strips of `seen`.

    nuisance_per_mm: what lens pitch and print scale add to every beat; change: steps added to a cell's beat;
    vague: cells that could not be read.
    """
    strips = tuple(ProfileReader(seen or badge).strips)
    phases = []
    for strip in strips:
        grating = badge.gratings[strip.grating]
        beat = 1 / grating.cells[strip.cell].pitch_mm - 1 / badge.lens.pitch_mm + nuisance_per_mm
        if grating.code:
            beat += (change or {}).get(strip.cell, 0.0) * grating.code.frequency_step_per_mm
        bar = math.inf if strip.cell in vague else sd
        phases.append(StripPhase(np.zeros(FRAMES), np.full(FRAMES, 0.01), np.full(FRAMES, 30.0), beat, bar))
    camera = CameraFit(np.zeros((FRAMES, 3)), np.zeros(FRAMES), 1450.0, 0.0, False, 0.01, (0.0, 0.0))
    times = np.arange(FRAMES) / 30.0
    track = Track(
        FRAMES, np.arange(FRAMES), times, np.zeros((FRAMES, 3, 3)), np.ones(FRAMES),
        np.zeros((FRAMES, len(strips), 4), np.float32), strips, (1920, 1080),
    )  # fmt: skip
    return track, Measurement(camera, np.zeros((FRAMES, 3)), times, tuple(phases), ())


def judged(badge: Badge, *, seen: Badge | None = None, claimed_id: str | None = None, **film: object) -> Identity:
    """`badge` is what the film shows, `seen` the one that is claimed and whose layout is used."""
    track, measurement = film_of(badge, seen=seen, **film)  # type: ignore[arg-type]
    return judge_identity(track, measurement, seen or badge, claimed_id=claimed_id)


@pytest.fixture(scope="module")
def other() -> Badge:
    """Somebody else's badge of the same layout."""
    return design_badge(Request("Grace Hopper"), payload_from_hex("0f5ac3"))


# The four verdicts.


def test_the_claimed_badge_matches(ada):
    """Catches: bands read from the bottom; the reference taken for a symbol; a sign of the step."""
    outcome = judged(ada, claimed_id=ada.id)
    assert (outcome.verdict, outcome.decoded_id, outcome.claimed_id) == ("match", ada.id, ada.id)
    assert outcome.symbol_errors_corrected == 0 and outcome.built == "not_known"
    assert outcome.score == pytest.approx(1.0, abs=1e-6)
    assert [reason.level for reason in outcome.reasons] == ["pass"]


def test_another_badge_is_a_mismatch_that_names_it(ada, other):
    """Catches: a decoder that looks at the claimed badge's pitches, and so finds what it is told to find."""
    outcome = judged(other, seen=ada, claimed_id=ada.id)
    assert (outcome.verdict, outcome.decoded_id, outcome.claimed_id) == ("mismatch", other.id, ada.id)
    assert outcome.score == pytest.approx(-1.0, abs=1e-6)
    assert [reason.level for reason in outcome.reasons] == ["fail"]


def test_too_many_vague_bands_are_unreadable(ada):
    """Catches: a guess where three symbols are missing; a rejection of whom nobody could read."""
    reference = ada.gratings[0].code.reference_cell
    lost = tuple(k for k in range(11) if k != reference)[2:5]
    outcome = judged(ada, claimed_id=ada.id, vague=lost)
    assert (outcome.verdict, outcome.decoded_id, outcome.score) == ("unreadable", None, 0.0)
    assert [reason.level for reason in outcome.reasons] == ["undecided"]
    assert outcome.reasons[0].measured == 3


def test_without_a_reference_band_nothing_can_be_read(ada):
    """Catches: absolute beats, which print scale and lens pitch move by symbols."""
    outcome = judged(ada, claimed_id=ada.id, vague=(ada.gratings[0].code.reference_cell,))
    assert outcome.verdict == "unreadable" and outcome.decoded_id is None


def test_without_a_claim_the_reading_is_only_noted(ada):
    """Catches: a match with nobody; a decoding that is left out where nothing is claimed."""
    outcome = judged(ada)
    assert (outcome.verdict, outcome.decoded_id, outcome.claimed_id) == ("not_claimed", ada.id, None)
    assert [reason.level for reason in outcome.reasons] == ["note"]


def test_a_board_without_a_code_claims_nothing(prototype):
    """Catches: a code asked of the published prototype; a claim that a codeless board could fulfil."""
    outcome = judged(prototype)
    assert (outcome.verdict, outcome.decoded_id, outcome.score) == ("not_claimed", None, None)
    assert outcome.beat_period_mm == pytest.approx(0.508 * 0.52 / 0.012)
    assert outcome.expected_beat_period_mm == pytest.approx(22.013, abs=1e-3)


# Nuisances and errors.


@pytest.mark.parametrize("scale", [-0.008, 0.008])
def test_print_scale_and_lens_pitch_drop_out(ada, scale):
    """Catches: absolute beats.  The largest scale that is allowed for moves every beat by four steps."""
    shift = scale / ada.lens.pitch_mm
    assert abs(shift / ada.gratings[0].code.frequency_step_per_mm) > 3
    outcome = judged(ada, claimed_id=ada.id, nuisance_per_mm=shift)
    assert outcome.verdict == "match" and outcome.score == pytest.approx(1.0, abs=1e-6)
    design = 1 / outcome.expected_beat_period_mm
    assert 1 / outcome.beat_period_mm == pytest.approx(design - shift, rel=1e-6)


def test_one_wrong_symbol_is_corrected_and_counted(ada):
    """Catches: a count of erasures; errors corrected in silence."""
    outcome = judged(ada, claimed_id=ada.id, change={7: 3.0 if can_rise(ada, 7, 3) else -3.0})
    assert (outcome.verdict, outcome.symbol_errors_corrected) == ("match", 1)


def can_rise(badge: Badge, cell: int, steps: int) -> bool:
    """Whether a cell's symbol may rise by so many steps and still be a symbol."""
    code = badge.gratings[0].code
    beat = 1 / badge.gratings[0].cells[cell].pitch_mm - 1 / badge.lens.pitch_mm - code.base_frequency_per_mm
    return round(beat / code.frequency_step_per_mm) - code.first_level + steps < code.levels


def test_two_lost_bands_are_filled_in(ada):
    """Catches: erasures treated as errors, of which only one can be mended."""
    outcome = judged(ada, claimed_id=ada.id, vague=(0, 9))
    assert outcome.verdict == "match" and outcome.decoded_id == ada.id


def test_one_wrong_symbol_of_another_badge_is_no_bridge_to_the_claim(ada, other):
    """Catches: correction towards the claim instead of towards the nearest word."""
    outcome = judged(other, seen=ada, claimed_id=ada.id, change={2: 2.0 if can_rise(other, 2, 2) else -2.0})
    assert outcome.decoded_id in (other.id, None) and outcome.verdict in ("mismatch", "unreadable")


def test_the_score_is_the_distance_from_confusion(ada):
    """Catches: a mean in place of the worst band; the distance unscaled; the sign of the offset."""
    for off in (0.2, -0.1):
        assert judged(ada, claimed_id=ada.id, change={3: off}).score == pytest.approx(1 - 2 * abs(off), abs=1e-6)
    off = judged(ada, claimed_id=ada.id, change={ada.gratings[0].code.reference_cell: 0.3})
    assert off.score == pytest.approx(0.4, abs=1e-6) and off.verdict == "match"


def test_only_the_layout_of_the_claimed_badge_is_looked_at(ada):
    """Catches: any look at the claimed badge's own pitches or edges while decoding."""
    grating = ada.gratings[0]
    blank = replace(grating, cells=tuple(replace(c, pitch_mm=0.5, edge_mm=0.0) for c in grating.cells))
    outcome = judged(ada, seen=replace(ada, gratings=(blank,), id="ffffff"), claimed_id="ffffff")
    assert (outcome.verdict, outcome.decoded_id) == ("mismatch", ada.id)


def test_strips_of_a_cell_are_weighed_by_their_bars(ada):
    """Catches: a plain mean over a cell's strips, in which one bad strip spoils a good one."""
    wide = replace(ada, gratings=(widened(ada),))
    track, measurement = film_of(wide)
    counts = [sum(strip.cell == cell for strip in track.strips) for cell in range(11)]
    assert counts == [2] * 11
    phases = list(measurement.strips)
    step = ada.gratings[0].code.frequency_step_per_mm
    second = next(k for k, strip in enumerate(track.strips) if strip.cell == 4) + 1
    phases[second] = replace(phases[second], frequency_per_mm=phases[second].frequency_per_mm + step, frequency_sd=1e-3)
    outcome = judge_identity(track, replace(measurement, strips=tuple(phases)), wide, claimed_id=ada.id)
    assert outcome.verdict == "match" and outcome.symbol_errors_corrected == 0
    assert outcome.score == pytest.approx(1 - 2 / (1 + (1e-3 / 4e-5) ** 2), abs=1e-4)


def widened(badge: Badge):
    """The grating with bands so high that each is read in two strips."""
    grating = badge.gratings[0]
    x0, y0, x1, _ = grating.rect_mm
    cells = tuple(replace(c, rect_mm=(x0, y0 + 16.0 * k, x1, y0 + 16.0 * (k + 1))) for k, c in enumerate(grating.cells))
    return replace(grating, rect_mm=(x0, y0, x1, y0 + 16.0 * 11), cells=cells)


def test_json_is_strict_and_complete(ada, prototype):
    """Catches: NaN in the JSON; a missing key of the contract."""
    for outcome in (judged(ada, claimed_id=ada.id), judged(prototype), judged(ada, claimed_id=ada.id, vague=(0, 1, 2))):
        document = json.loads(json.dumps(outcome.to_json(), allow_nan=False))
        assert document.keys() >= {
            "verdict", "decoded_id", "claimed_id", "beat_period_mm", "expected_beat_period_mm",
            "symbol_errors_corrected", "built", "score",
        }  # fmt: skip
