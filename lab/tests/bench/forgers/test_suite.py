"""A few cases filmed and judged.  Each test states what it would catch."""

from __future__ import annotations

import json

import numpy as np
import pytest

from moireid.verifier.video import Film
from moireid_lab.bench.forgers.cases import Filming, ForgeryCase, Shoot, cases
from moireid_lab.bench.forgers.forgers_suite import badge_of, film_case, run_case
from moireid_lab.bench.forgers.motions import one_way


@pytest.mark.slow
def test_every_case_can_be_filmed():
    """Catches: a case that breaks on a badge of its axes, or on a seed, after an hour of the others."""
    for axes in ("x", "xy"):
        badge = badge_of(axes)
        assert {grating.axis for grating in badge.gratings} == set(axes)
        for seed, case in enumerate(case for case in cases() if case.axes == axes):
            filming = case.make(Shoot(badge, 1000.0, seed, 240))
            camera = filming.motion(np.arange(8) / 30).camera_mm
            assert camera.shape == (8, 3) and (camera[:, 2] < -500).all(), case.name


def test_a_film_has_the_frames_and_the_edit_of_its_case():
    """Catches: a film longer by its own factor; an edit or a show that never reaches the film."""
    badge, seen = badge_of("x"), []

    def make(shoot: Shoot) -> Filming:
        def edit(frame: int, luma: np.ndarray, homography: np.ndarray) -> np.ndarray:
            seen.append((frame, luma.shape, homography.shape))
            return np.full_like(luma, 40 + 20 * frame)

        return Filming(one_way(shoot.distance_mm, shoot.seed, length_s=shoot.length_s), edit=edit, seconds_times=1.5)

    with film_case(ForgeryCase("made up", True, make), Shoot(badge, 1000.0, 1, 4)) as video:
        frames = list(Film(video).frames())
    assert seen == [(k, (720, 1280), (3, 3)) for k in range(6)] and len(frames) == 6
    assert [float(frame.luma.mean()) for frame in frames] == pytest.approx([40 + 20 * k for k in range(6)], abs=3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "verdict", "why"),
    [
        ("8 photographs, cross-faded", "inconclusive", "spacing"),
        ("one photograph in turns, plain cuts", "inconclusive", "motion"),
        ("frozen for 2 s", "reject", "residual"),
        ("plain", "accept", None),
    ],
)
def test_an_attack_is_not_accepted_and_a_true_film_is(name, verdict, why):
    """Catches: an attack filmed as the truth, a true film that shows no badge, a row that JSON cannot hold."""
    row = run_case((name, 1, 240))
    assert row["verdict"] == verdict and (why in row["why"] if why else not row["why"])
    assert json.loads(json.dumps(row, allow_nan=False)) == row
    assert row["case"] == name and row["genuine"] == (verdict == "accept") and row["seconds"] > 0
