"""The lens sheet's front, and one renderer for many frames.  Each test names what it would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.payloads import payload_for_name
from moireid.badge import Lens
from moireid.designer import Order, design_badge
from moireid.simulate.cameras import Camera
from moireid.simulate.mitsuba.mitsuba_renderer import MitsubaRenderer
from moireid.simulate.mitsuba.sheet import front_strips
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Instant, Scene

SHEET = Lens("lenticular", 0.508, 1.0, 1.56)
ROOM = (-5.0, 7.0, -3.0, 4.0)


def seen_from(x: float, y: float, z: float) -> Instant:
    pose = Poses(np.array([[x, y, z]]), np.eye(3)[None])
    return Instant(pose, pose, pose.camera_mm[0])


@pytest.mark.parametrize("build", [Build(), Build(0.13, math.radians(0.4), 1.0, 0.998)], ids=["true", "askew"])
def test_the_sheet_s_front_is_one_closed_surface(build: Build) -> None:
    """Catches: a face turned over, a gap between two lenses, a sheet of the wrong thickness or with lenses inside out.

    The volume above the page is that of the slab less what is cut away above the circles, by whole lenses.
    """
    front = front_strips(SHEET, build, ROOM, 64)
    corners = np.stack([front.across, front.along, front.depth], axis=-1)
    # The far side of each strip, both ends, is the near side of the next.
    assert np.array_equal(corners[:-1, [3, 2]], corners[1:, [0, 1]])
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(facing[:, 2] < 0)
    radius, pitch = SHEET.radius_mm or 0.0, SHEET.pitch_mm * build.lens_scale
    half = pitch / 2 / radius
    mean_rise = radius / (2 * half) * (half * math.sqrt(1 - half**2) + math.asin(half))
    height = SHEET.thickness_mm - radius + mean_rise
    width = corners[-1, 3, 0] - corners[0, 0, 0]
    area = 7.0 * np.diff(front.across[:, [0, 3]])[:, 0]
    assert area.sum() == pytest.approx(7.0 * width)
    assert -(area * front.depth.mean(axis=1)).sum() == pytest.approx(7.0 * width * height, rel=0.005)
    assert front.depth.min() == pytest.approx(-SHEET.thickness_mm, abs=1e-3)
    assert front.along.min() == ROOM[2] and front.along.max() == ROOM[3]


def test_a_badge_of_two_axes_is_rendered() -> None:
    """Catches: one lamp for two gratings, which Mitsuba refuses."""
    badge = design_badge(Order("Two axes", lens="50lpi", axes="xy"), payload_for_name("Two axes"))
    scene = Scene(badge, camera=Camera(width=160, height=120, focal_px=150.0))
    rendered = MitsubaRenderer(scene, samples=4, segments=2).render(seen_from(0.0, 0.0, -400.0))
    assert rendered is not None and np.ptp(rendered.radiance[rendered.coverage == 1]) > 0.5
