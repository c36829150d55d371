"""How a badge is built by chance, and where its page then lies.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Camera, Scene
from moireid.simulate.shots import page_homographies

#: Offset, twist and both scales of the third typical build before prints had an aspect.
TYPICAL_3 = (-0.20717541642818782, -0.004460476937451646, 1.0008361976934517, 0.9994322303938721)


def test_a_typical_build_keeps_its_older_draws():
    """Catches: a draw that comes before others, by which every seeded film would show another badge."""
    built = Build.typical(3)
    found = (built.lens_offset_mm, built.twist_rad, built.print_scale, built.lens_scale)
    assert found == pytest.approx(TYPICAL_3, abs=1e-12)


def test_typical_prints_are_a_tenth_of_a_percent_too_high_or_too_low():
    """Catches: a spread in percent; an aspect that is cut at one side; one bound to the scale."""
    builds = [Build.typical(seed) for seed in range(600)]
    aspects = np.array([built.print_aspect for built in builds]) - 1
    assert aspects.std() == pytest.approx(0.001, rel=0.1) and abs(aspects.mean()) < 0.0002
    assert 0.002 < np.abs(aspects).max() < 0.003 + 1e-12
    assert abs(np.corrcoef(aspects, [built.print_scale for built in builds])[0, 1]) < 0.15


def test_the_page_s_homography_has_the_print_s_two_scales(ada):
    """Catches: one scale for both; a scale about the page's corner; scales exchanged.  The corner moves by 0.5 px."""
    camera = Camera()
    scene = Scene(ada, Build(print_scale=1.002, print_aspect=1.003, twist_rad=0.01), camera)
    place = np.array([40.0, -30.0, -900.0])
    page = np.array([[10.0, 20.0], [110.0, 35.0], [60.0, 120.0]])
    seen = np.column_stack([page, np.ones(3)]) @ page_homographies(scene, Poses(place[None], np.eye(3)[None]))[0].T
    printed = (page - scene.board_centre_mm) * (1.002, 1.002 * 1.003)
    wanted = (printed - place[:2]) / 900.0 * camera.focal_px + ((camera.width - 1) / 2, (camera.height - 1) / 2)
    assert seen[:, :2] / seen[:, 2:] == pytest.approx(wanted, abs=1e-9)
    assert scene.printed_half_mm == pytest.approx(np.array(scene.board_half_mm) * (1.002, 1.002 * 1.003))
