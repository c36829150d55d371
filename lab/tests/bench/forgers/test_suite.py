"""A few cases filmed and judged.  Each test states what it would catch."""

from __future__ import annotations

import json

import numpy as np
import pytest

from moireid_lab.bench.forgers.cases import Shoot, cases
from moireid_lab.bench.forgers.forgers_suite import badge_of, judged


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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "verdict", "why"),
    [
        ("8 photographs, cross-faded", "inconclusive", "spacing"),
        ("one photograph in turns, plain cuts", "inconclusive", "motion"),
        ("frozen for 2 s", "reject", "residual"),
        ("frozen for 50 % of the frames, markers shifted", "reject", None),
        ("plain", "accept", None),
    ],
)
def test_an_attack_is_not_accepted_and_a_true_film_is(name, verdict, why, tmp_path):
    """Catches: an attack filmed as the truth, a true film that shows no badge, a row that JSON cannot hold."""
    row = judged((name, 1), tmp_path)
    assert row["verdict"] == verdict and (why in row["why"] if why else not row["why"])
    assert json.loads(json.dumps(row, allow_nan=False)) == row
    assert row["kind"] == name and list(row["answers"]) == ["genuine" if verdict == "accept" else "forged"]
