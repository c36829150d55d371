"""Pictures of a board under a lens array.  Each test names what it would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from moireid.badge import Cell, Grating
from moireid.designer import Request, design_badge
from moireid.errors import SpecError
from moireid.simulate import Build, Scene
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.analytic.fly_eye import FlyEye
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant
from moireid.simulate.truth import shown_phase_rad

PITCH_MM, PX_PER_MM = 0.52, 4.0


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A small board with plain crossed gratings, so that each direction has one fringe pattern."""
    badge = design_badge(Request("Ada", front="array", size_mm=(80, 90), range_m=(0.5, 0.9)), bytes(8))
    plain = tuple(
        Grating(g.rect_mm, g.axis, PITCH_MM, "uniform", (Cell(g.rect_mm, PITCH_MM, g.rect_mm[k], 0.5),))
        for k, g in enumerate(badge.gratings)
    )
    return Scene(replace(badge, gratings=plain), Build())


def phases(scene: Scene, camera_mm: np.ndarray) -> np.ndarray:
    """Phase of the fringes along x and along y at the board's middle, rad."""
    picture = FlyEye(scene, PX_PER_MM).picture(camera_mm)
    found = []
    for side, grating in enumerate(scene.badge.gratings):
        rect = (np.array(grating.rect_mm) - np.tile(scene.board_centre_mm, 2)) * PX_PER_MM
        middle = np.array(picture.shape[::-1]) / 2
        x0, y0, x1, y1 = np.rint(rect + np.tile(middle, 2)).astype(int) + np.array([4, 4, -4, -4])
        profile = picture[y0:y1, x0:x1].mean(axis=side)
        place = ((x0, y0)[side] + np.arange(len(profile)) + 0.5 - middle[side]) / PX_PER_MM
        gap = 0.75 / abs(camera_mm[2])
        beat = (1 + gap) / PITCH_MM - 1 / scene.lens.pitch_mm
        window = np.hanning(len(profile))
        profile = profile - np.average(profile, weights=window)
        found.append(np.angle(np.sum(window * profile * np.exp(-2j * math.pi * beat * place))))
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("camera", [(60.0, 0.0), (-40.0, 90.0)])
def test_fringes_of_both_directions_follow_the_law(scene, camera):
    """Catches: parallaxes exchanged or of wrong sign, a sphere bent wrongly, the lens plane taken for the page's.

    Two routes: rays of each lens, and the tabulated law of the array.
    """
    here, there = np.array([0.0, 0.0, -1000.0]), np.array([*camera, -1000.0])
    moved = phases(scene, there) - phases(scene, here)
    none = np.zeros(2)
    expected = [
        shown_phase_rad(scene, g, there, there, none) - shown_phase_rad(scene, g, here, here, none)
        for g in scene.badge.gratings
    ]
    assert np.abs(np.remainder(moved - expected + math.pi, 2 * math.pi) - math.pi).max() < 0.03
    assert abs(expected[0]) > 0.3


def test_light_passes_both_gratings(scene):
    """Catches: gratings that are averaged instead of crossed: a quarter of the paper stays light, not a half."""
    picture = FlyEye(scene, PX_PER_MM).picture(np.array([0.0, 0.0, -800.0]))
    rect = (np.array(scene.badge.gratings[0].rect_mm) - np.tile(scene.board_centre_mm, 2)) * PX_PER_MM
    x0, y0, x1, y1 = np.rint(rect + np.tile(np.array(picture.shape[::-1]) / 2, 2)).astype(int)
    share = (picture[y0:y1, x0:x1].mean() - scene.ink) / (scene.paper - scene.ink)
    assert share == pytest.approx(0.25, abs=0.03)


def test_parts_with_courses_of_their_own_are_refused(scene):
    """Catches: a forged field that is silently left out, so that a film labelled as forged shows the truth."""
    camera = np.array([0.0, 0.0, -800.0])
    pose = Poses(camera[None], np.eye(3)[None])
    with pytest.raises(SpecError, match="rendered whole"):
        AnalyticRenderer(scene).render(Instant(pose, pose, camera, field=np.zeros((4, 4, 2))))
