"""Rows that wobble, and shutters of either direction.  Each test names what it would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.takes import SIZE, a_take
from moireid.simulate.cameras import Camera
from moireid.simulate.effects.table import KINDS, STRENGTHS, effect_named
from moireid.simulate.motion import motion_named
from moireid.simulate.recording.sensor import opened
from moireid.simulate.scene import Build, Scene


@pytest.mark.parametrize("strength", STRENGTHS)
def test_rows_shift_against_each_other_by_the_skew_and_change_over_time(strength):
    """Catches: a whole picture that shifts; a skew of degrees taken for radians; the same skew in all frames."""
    take = a_take(120)
    begin = effect_named(f"jello:{strength}").begin
    assert begin is not None
    step, after = begin(take)
    assert after is take
    ramp = np.tile(np.clip(6.0 * (np.arange(SIZE[0]) - 299), 0, 255), (SIZE[1], 1)).astype(np.uint8)
    skews, means = [], []
    for number in range(120):
        shift = (step(number, ramp).astype(float) - ramp)[:, 315:326].mean(axis=1) / 6.0
        skews.append((shift[-10:].mean() - shift[:10].mean()) / SIZE[1])
        means.append(shift.mean())
    most = math.radians(KINDS["jello"].figures[STRENGTHS.index(strength)])
    assert np.abs(skews).max() == pytest.approx(most, rel=0.1) and np.abs(means).max() < 0.3
    assert min(skews) < -0.3 * most and max(skews) > 0.3 * most


@pytest.mark.parametrize(("name", "sign"), [("shutter", 1), ("shutter-up", -1)])
def test_a_shutter_reads_in_its_direction(prototype, name, sign):
    """Catches: a readout of ms taken for s; a bottom row that is never read before the top one."""
    change = effect_named(name).scene
    assert change is not None
    scene = change(Scene(prototype, Build(), Camera(640, 360, 480.0)))
    assert scene.camera.shutter_s == pytest.approx(sign * 0.0145)
    motion = motion_named("linear", distance_mm=1000.0, seed=1)
    (poses,) = opened(motion, scene.camera, scene.board_half_mm, 1.0, 30.0)[1]
    # The path goes right by 250 mm a second.
    assert poses.camera_mm[2, 0] - poses.camera_mm[0, 0] == pytest.approx(sign * 250 * 0.0145, rel=1e-6)
