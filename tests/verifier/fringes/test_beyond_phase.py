"""What a film shows beside the phase, cut and joined.  Beside each test: what it would catch."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from moireid.verifier.fringes.beyond_phase import mean_overtone
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw, GratingSignal, joined_beyond
from moireid.verifier.fringes.strip_phase import StripPhase

FRAMES = 60
TIMES = np.arange(FRAMES) / 30.0


@pytest.fixture
def beyond(rng: np.random.Generator) -> BeyondPhase:
    """Of random numbers, no two alike."""
    depth = DepthLaw(rng.standard_normal(FRAMES), rng.random(FRAMES), rng.random(FRAMES))
    overtone = rng.standard_normal(FRAMES) + 1j * rng.standard_normal(FRAMES)
    return BeyondPhase(rng.standard_normal(FRAMES), depth, overtone, rng.standard_normal((FRAMES, 2)), 1j * overtone)


def series_of(beyond: BeyondPhase) -> list[np.ndarray]:
    """Every series of it, those of the depth law too."""
    own = [getattr(beyond, field.name) for field in fields(beyond) if field.name != "depth"]
    return [*own, *beyond.depth]


def signal(beyond: BeyondPhase | None) -> GratingSignal:
    course = np.sin(TIMES)
    return GratingSignal(course, course, np.full(FRAMES, 0.01), 0.01, np.zeros(2), TIMES, beyond=beyond)


def test_parts_joined_again_are_the_whole(beyond: BeyondPhase):
    """Catches: a series that is forgotten, cut elsewhere, or joined in another order."""
    middle = np.arange(20, 45)
    whole = joined_beyond([beyond.part(slice(0, 20)), beyond.part(middle), beyond.part(slice(45, None))])
    assert whole is not None
    for joined, own in zip(series_of(whole), series_of(beyond), strict=True):
        assert joined.shape == own.shape and np.array_equal(joined, own)
    assert beyond.part(middle).depth.score.sum() == pytest.approx(beyond.depth.score[20:45].sum())


def test_a_part_of_a_signal_has_its_own_frames(beyond: BeyondPhase):
    """Catches: a signal cut to some frames that keeps all evidence of the film."""
    some = np.arange(10, 30)
    part = signal(beyond).part(some)
    assert part.beyond is not None
    for cut, own in zip(series_of(part.beyond), series_of(beyond), strict=True):
        assert np.array_equal(cut, own[some])
    assert signal(None).part(some).beyond is None


def strip(overtone: np.ndarray) -> StripPhase:
    blank = np.zeros(FRAMES)
    return StripPhase(blank, blank, blank, blank, 1.0, 0.0, overtone=overtone)


def test_overtones_are_weighted_by_how_little_they_tremble(rng: np.random.Generator):
    """Catches: a covered strip whose noise drowns the others; a mean of sizes, in which directions are lost."""
    course = 0.05 * np.exp(1j * TIMES)
    noise = rng.standard_normal((2, FRAMES)) + 1j * rng.standard_normal((2, FRAMES))
    clear, vague = course + 0.001 * noise[0], course + 0.1 * noise[1]
    assert np.abs(mean_overtone([strip(clear), strip(vague)]) - course).std() < 0.0015
    alike = mean_overtone([strip(course + 0.01 * noise[0]), strip(course + 0.01 * noise[1])])
    # Two strips of one noise have half of its variance.
    assert np.abs(alike - course).std() < 0.85 * np.abs(0.01 * noise[0]).std()
