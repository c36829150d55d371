"""Settings of films: flat layers at their depths, in colour.  Next to each test: what it would catch."""

from __future__ import annotations

from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from PIL import Image

from moireid.errors import MediaError, SpecError
from moireid.simulate.analytic.traced_page import page_texture
from moireid.simulate.build import Build
from moireid.simulate.cameras import Camera
from moireid.simulate.filming import film
from moireid.simulate.motion import Poses, motion_named
from moireid.simulate.scene import Need, Scene
from moireid.simulate.settings.drawn_layers import Canvas
from moireid.simulate.settings.painting import Painter, chroma_of, light_of
from moireid.simulate.settings.places import SETTINGS, setting_named
from moireid.simulate.settings.wearing import PRINT_FILE, load_print
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


def test_a_lens_bends_layers_as_it_bends_the_badge():
    """Catches: a setting that is straight where the badge is not, so that its holder leaves it."""
    bent = Camera(width=640, height=360, focal_px=400.0, distortion=(-0.2, 0.05, 0.0, 0.0))
    ground = Canvas((-3000.0, -3000.0, 3000.0, 3000.0), 0.1, "#000000").layer(4000.0, endless=True)
    seen = middle_of(Painter([dot(0.0, "#ffffff"), ground], bent).paint(poses(-500.0), poses(-500.0)), 1)
    assert seen == pytest.approx(bent.project(np.array([500.0, 0.0, 1000.0])), abs=0.6)


def test_grey_has_no_colour_and_colours_are_those_of_a_video_file():
    """Catches: blue and red differences exchanged; a full range; light that is not that of the coded grey."""
    grey, blue, red = (np.full((4, 4, 3), colour, np.uint8) for colour in ((90, 90, 90), (255, 0, 0), (0, 0, 255)))
    assert [plane[0, 0] for plane in chroma_of(grey)] == [128, 128]
    assert chroma_of(blue)[0].min() > 230 and chroma_of(red)[1].min() > 230
    assert light_of(grey)[0, 0] == pytest.approx((90 / 255) ** 2, rel=1e-5)
    mixed = np.concatenate([blue, red], axis=1)
    assert np.array_equal(chroma_of(mixed, mirror=True)[0], chroma_of(mixed)[0][:, ::-1])


@pytest.mark.parametrize("name", SETTINGS)
def test_nothing_of_a_setting_is_before_the_badge(ada, name):
    """Catches: a lectern or microphone that covers the badge, whose light the renderer lays over it."""
    scene = Scene(ada, Build())
    half_x, half_y = scene.printed_half_mm
    for layer in setting_named(name, scene, 3):
        if layer.depth_mm >= 0:
            continue
        rows, columns = np.nonzero(layer.picture[..., 3])
        x, y = layer.corner_mm[0] + columns / layer.px_per_mm, layer.corner_mm[1] + rows / layer.px_per_mm
        outside = np.maximum(np.abs(x) - half_x, np.abs(y) - half_y)
        assert outside.min() > 60.0


def test_an_unknown_setting_lists_those_there_are(ada):
    """Catches: a name that is none, with a traceback."""
    with pytest.raises(SpecError, match="lectern"):
        setting_named("moon", Scene(ada), 1)


def test_the_print_is_that_of_the_picture_next_to_the_badge(ada, tmp_path: Path):
    """Catches: a print that is mirrored, or as bright as coded; a file that is no picture, with a traceback; a
    small file of so many pixels that they fill the memory."""
    assert load_print(tmp_path / "badge.json") is None
    picture = np.full((400, 300, 3), 250, np.uint8)
    picture[:40, :60] = (140, 80, 20)
    cv2.imwrite(str(tmp_path / PRINT_FILE), picture)
    read = load_print(tmp_path / "badge.json")
    assert read is not None and np.array_equal(read, picture)
    texture = page_texture(Scene(ada, Build.typical(0), print_picture=read))
    dark = texture[texture.shape[0] // 20, texture.shape[1] // 6]
    assert texture[texture.shape[0] // 20, -3] == pytest.approx(0.85, rel=1e-4) and dark < 0.4
    (tmp_path / PRINT_FILE).write_text("no picture", encoding="utf-8")
    with pytest.raises(MediaError, match="no picture"):
        load_print(tmp_path / "badge.json")
    Image.new("1", (10_000, 6_000)).save(tmp_path / PRINT_FILE)
    with pytest.raises(MediaError, match="no picture"):
        load_print(tmp_path / "badge.json")


def test_a_setting_that_is_left_out_is_refused(ada, tmp_path: Path):
    """Catches: a wish that is silently dropped."""
    motion = motion_named("static", distance_mm=1000.0, seed=0)
    with pytest.raises(SpecError, match="is a background"):
        film(Scene(ada, need=Need(background=False)), motion, tmp_path / "a.mp4", frames=2, fps=30.0, setting="desk")
    assert not list(tmp_path.iterdir())


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
