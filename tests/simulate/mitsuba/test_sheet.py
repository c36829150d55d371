"""The lens sheet's front, and one renderer for many frames.  Each test names what it would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.payloads import payload_for_name
from moireid.badge import Badge, Lens
from moireid.designer import Order, design_badge
from moireid.simulate.cameras import Camera
from moireid.simulate.mitsuba.mitsuba_renderer import MitsubaRenderer
from moireid.simulate.mitsuba.sheet import front_strips
from moireid.simulate.mitsuba.view import film_box
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


def test_the_front_has_the_circles_own_normals() -> None:
    """Catches: normals of the chords, or normals shared by two lenses where they meet."""
    front = front_strips(SHEET, Build(), ROOM, 8)
    assert front.normals is not None
    np.testing.assert_allclose(np.linalg.norm(front.normals, axis=-1), 1.0, atol=1e-12)
    middle = np.round(front.across.mean(axis=1, keepdims=True) / SHEET.pitch_mm) * SHEET.pitch_mm
    np.testing.assert_allclose(front.normals[..., 0] * (SHEET.radius_mm or 0), front.across - middle, atol=1e-9)
    assert np.all(front.normals[..., 2] < 0)


def test_the_film_keeps_its_size_while_the_board_fits() -> None:
    """Catches: a new size, and so a new kernel, for every frame; a film that stays far too large."""
    first = film_box((100, 50, 336, 266), None)
    assert first[0] >= 236 and first[1] >= 216
    assert film_box((400, 20, 640, 230), first) == first
    assert film_box((0, 0, first[0] + 1, 10), first) != first
    assert film_box((0, 0, 50, 50), first) < first


def test_one_renderer_shows_each_frame_as_a_new_one_would(prototype: Badge) -> None:
    """Catches: a camera or a principal point left over from the frame before, and seeds that do not move on."""
    scene = Scene(prototype)
    courses = [seen_from(0, 0, -2000), seen_from(150, -80, -2200)]
    kept = MitsubaRenderer(scene, samples=16, segments=4, variant="scalar_rgb")
    frames = [kept.render(instant) for instant in (*courses, courses[1])]
    fresh = MitsubaRenderer(scene, samples=16, segments=4, variant="scalar_rgb", seed=5).render(courses[1])
    assert fresh is not None and all(frame is not None for frame in frames)
    _, moved, again = (frame.radiance for frame in frames if frame is not None)
    assert moved.shape == fresh.radiance.shape
    noise = np.std(moved - again)
    assert 0 < noise < 0.1
    assert np.std(moved - fresh.radiance) < 1.2 * noise


def test_a_badge_of_two_axes_is_rendered() -> None:
    """Catches: one lamp for two gratings, which Mitsuba refuses."""
    badge = design_badge(Order("Two axes", lens="50lpi", axes="xy"), payload_for_name("Two axes"))
    scene = Scene(badge, camera=Camera(width=160, height=120, focal_px=150.0))
    rendered = MitsubaRenderer(scene, samples=4, segments=2).render(seen_from(0.0, 0.0, -400.0))
    assert rendered is not None and np.ptp(rendered.radiance[rendered.coverage == 1]) > 0.5
