"""The lens sheet's front, and one renderer for many frames.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np

from kit.payloads import payload_for_name
from moireid.designer import Order, design_badge
from moireid.simulate.cameras import Camera
from moireid.simulate.mitsuba.mitsuba_renderer import MitsubaRenderer
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant, Scene


def seen_from(x: float, y: float, z: float) -> Instant:
    pose = Poses(np.array([[x, y, z]]), np.eye(3)[None])
    return Instant(pose, pose, pose.camera_mm[0])


def test_a_badge_of_two_axes_is_rendered() -> None:
    """Catches: one lamp for two gratings, which Mitsuba refuses."""
    badge = design_badge(Order("Two axes", lens="50lpi", axes="xy"), payload_for_name("Two axes"))
    scene = Scene(badge, camera=Camera(width=160, height=120, focal_px=150.0))
    rendered = MitsubaRenderer(scene, samples=4, segments=2).render(seen_from(0.0, 0.0, -400.0))
    assert rendered is not None and np.ptp(rendered.radiance[rendered.coverage == 1]) > 0.5
