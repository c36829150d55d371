"""Settings of films: flat layers at their depths, in colour.  Next to each test: what it would catch."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest

from moireid.errors import SpecError
from moireid.simulate.build import Build
from moireid.simulate.cameras import Camera
from moireid.simulate.filming import film
from moireid.simulate.motion import Poses, motion_named
from moireid.simulate.scene import Scene
from moireid.simulate.settings.drawn_layers import Canvas
from moireid.simulate.settings.painting import Painter
from moireid.simulate.settings.places import SETTINGS, setting_named
from moireid.verifier import Question, verify

CAMERA = Camera(width=640, height=360, focal_px=500.0)


def poses(x: float, y: float = 0.0, z: float = -1000.0) -> Poses:
    return Poses(np.array([[x, y, z]]), np.eye(3)[None])


def dot(depth_mm: float, colour: str):
    """A disc 30 mm about the axis, at a depth."""
    canvas = Canvas((-60.0, -60.0, 60.0, 60.0), 2.0)
    canvas.ellipse((0.0, 0.0), (30.0, 30.0), colour)
    return canvas.layer(depth_mm)


def middle_of(picture: np.ndarray, channel: int) -> np.ndarray:
    rows, columns = np.nonzero(picture[..., channel] > 127)
    return np.array([columns.mean(), rows.mean()])


@pytest.mark.parametrize("depth_mm", [0.0, 1000.0])
def test_a_layer_moves_by_its_own_parallax(depth_mm):
    """Catches: layers that move alike; a depth of the wrong sign; x and y exchanged; half a pixel (centres)."""
    ground = Canvas((-3000.0, -3000.0, 3000.0, 3000.0), 0.1, "#000000").layer(4000.0, endless=True)
    painter = Painter([dot(depth_mm, "#ffffff"), ground], CAMERA)
    for x, y in ((0.0, 0.0), (60.0, -20.0)):
        seen = middle_of(painter.paint(poses(x, y), poses(x, y)), 1)
        wanted = np.array([639 / 2, 359 / 2]) - 500.0 * np.array([x, y]) / (1000.0 + depth_mm)
        assert seen == pytest.approx(wanted, abs=0.3)


def test_near_layers_cover_far_ones_and_rows_have_their_own_pose():
    """Catches: layers painted in the order given; transparent parts that cover; one pose for a rolling shutter."""
    ground = Canvas((-3000.0, -3000.0, 3000.0, 3000.0), 0.1, "#000000").layer(4000.0, endless=True)
    painter = Painter([dot(0.0, "#ff0000"), ground, dot(800.0, "#00ff00")], CAMERA)
    still = painter.paint(poses(0.0), poses(0.0)).copy()
    assert still[180, 320].tolist() == [0, 0, 255] and still[180, 350].tolist() == [0, 0, 0]
    red = still[..., 2] > 127
    rolled = painter.paint(poses(-40.0), poses(40.0))
    rows = [np.flatnonzero(rolled[row, :, 2] > 127).mean() for row in (172, 188)]
    assert rows[0] - rows[1] == pytest.approx(500.0 / 1000.0 * 80.0 * 16 / 360, abs=0.6)
    assert red.sum() == pytest.approx(np.pi * 15.0**2, rel=0.03)


def test_an_unknown_setting_lists_those_there_are(ada):
    """Catches: a name that is none, with a traceback."""
    with pytest.raises(SpecError, match="lectern"):
        setting_named("moon", Scene(ada), 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", SETTINGS)
def test_a_badge_is_accepted_in_every_setting(ada, tmp_path: Path, name):
    """Catches: a setting that hides the badge, or is taken for one; colours that are lost on the way to the file."""
    path, motion = tmp_path / "film.mp4", motion_named("sway", distance_mm=800.0, seed=3)
    film(Scene(ada, Build.typical(3)), motion, path, frames=120, fps=30.0, setting=name, seed=3)
    with av.open(str(path)) as container:
        planes = next(container.decode(video=0)).to_ndarray(format="yuv420p")
    assert planes[1080:].std() > 3
    report = verify(path, Question(ada, ada.id))
    assert (report.verdict, report.identity.verdict) == ("accept", "match")
    assert report.frames["tracked"] == report.frames["read"]
