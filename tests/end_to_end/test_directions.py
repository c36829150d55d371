"""Vertical motion, filmed: a badge of one direction leaves it open, one of three does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from moireid.designer import Order, design_badge
from moireid.simulate import Build, Scene, camera_named, film
from moireid.simulate.motion import Poses, linear
from moireid.verifier import Question, verify

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")


def vertical(times_s: np.ndarray) -> Poses:
    """The motion `linear`, up and down."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    found = linear(1200.0, 3)(times_s)
    return Poses(found.camera_mm @ turn.T, turn @ found.rotation @ turn.T)


@pytest.mark.slow
def test_three_directions_judge_a_vertical_motion_that_one_leaves_open(tmp_path: Path) -> None:
    """Catches: a direction that is lost between page and verdict."""
    verdicts = {}
    for axes in ("x", "hex"):
        badge = design_badge(Order("Ada", lens="50lpi", axes=axes, range_m=(0.8, 2.0)), PAYLOAD)
        build = Build(print_scale=1.002, print_aspect=1.001, lens_scale=0.9995)
        video = tmp_path / f"{axes}.mp4"
        film(Scene(badge, build, camera_named("phone")), vertical, video, frames=150, fps=30, seed=3)
        report = verify(video, Question(badge, badge.id))
        verdicts[axes] = report.verdict
    assert verdicts == {"x": "inconclusive", "hex": "accept"}
    level, *turned = report.to_json()["invariant"]["gratings"]
    assert [one["axis"] for one in (level, *turned)] == ["x", 60.0, 120.0]
    assert level["excitation_rad"] < 0.1 < turned[0]["excitation_rad"]
    assert [one["gain_ratio"] for one in turned] == pytest.approx([1.0, 1.0], abs=0.03)
    assert report.identity.verdict == "match"
