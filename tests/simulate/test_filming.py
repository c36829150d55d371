"""Whole films: file, truth, and what happens when it goes wrong.  Each test names what it would catch."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.lenticule import view_law
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.filming import TRUTH_COLUMNS, film, truth_path
from moireid.simulate.motion import Poses, motion_named
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Camera, Instant, Scene

SMALL = Camera(width=480, height=272, focal_px=363.0, shutter_s=0.012)
FPS = 25.0


def shoot(badge, path: Path, *, frames: int = 6, seed: int = 3, camera: Camera = SMALL, motion="linear", **options):
    scene = Scene(badge, Build(), camera)
    course = motion_named(motion, distance_mm=600.0, seed=seed) if isinstance(motion, str) else motion
    return film(scene, course, path, frames=frames, fps=FPS, seed=seed, **options)


def truth_of(path: Path) -> dict[str, np.ndarray]:
    with truth_path(path).open(encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    assert tuple(rows[0]) == TRUTH_COLUMNS
    columns = dict(zip(rows[0], zip(*rows[1:], strict=True), strict=True))
    label = np.array(columns.pop("label"))
    return {name: np.array(values, float) for name, values in columns.items()} | {"label": label}


def pictures(path: Path) -> np.ndarray:
    with av.open(str(path)) as container:
        return np.stack([frame.to_ndarray(format="gray") for frame in container.decode(video=0)])


# The file and its truth.


def test_the_film_is_what_was_asked_for(prototype, tmp_path):
    """Catches: width and height exchanged; a lost last frame; times from 1/fps on; another codec."""
    path = tmp_path / "a.mp4"
    document = []
    report = shoot(prototype, path, frames=7, progress=lambda done, of: document.append((done, of)))
    assert (report.video, report.truth, report.frames, report.label) == (path, truth_path(path), 7, "genuine")
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264" and stream.average_rate == 25
        assert (stream.width, stream.height) == (480, 272)
        times = [float(frame.time) for frame in container.decode(stream)]
    assert times == pytest.approx(np.arange(7) / FPS, abs=1e-4)
    assert document == [(k + 1, 7) for k in range(7)]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mp4", "a.mp4.truth.csv"]


def test_the_truth_is_the_motion(prototype, tmp_path):
    """Catches: camera -> board rotations; rotations column by column; times of the first row; parallax of -Cx/|Cz|."""
    path = tmp_path / "a.mp4"
    shoot(prototype, path, motion="sway")
    truth = truth_of(path)
    assert truth["frame"] == pytest.approx(np.arange(6)) and truth["time_s"] == pytest.approx(np.arange(6) / FPS)
    poses = motion_named("sway", distance_mm=600.0, seed=3)(truth["time_s"])
    camera = np.column_stack([truth[f"camera_{axis}_mm"] for axis in "xyz"])
    assert np.allclose(camera, poses.camera_mm, atol=1e-6)
    turns = np.array([[[truth[f"r{i}{j}"][k] for j in (1, 2, 3)] for i in (1, 2, 3)] for k in range(6)])
    assert np.allclose(turns, poses.rotation, atol=1e-6)
    for axis, column in enumerate("xy"):
        assert np.allclose(truth[f"parallax_{column}"], camera[:, axis] / -camera[:, 2], atol=1e-6)
    assert set(truth["label"]) == {"genuine"}


def test_the_true_phase_follows_the_law_of_the_page_s_plane(prototype, tmp_path):
    """Catches: a phase that rises with u; the lens plane's slope (3.7 % less); degrees.  Two routes: table, slope."""
    path = tmp_path / "a.mp4"
    shoot(prototype, path, frames=40, camera=Camera(width=160, height=96, focal_px=100.0, shutter_s=0.0))
    truth = truth_of(path)
    near = np.abs(truth["parallax_x"]) < 0.15
    assert near.sum() >= 8
    slope = np.polyfit(truth["parallax_x"][near], truth["phase_rad"][near], 1)[0]
    pitch = prototype.gratings[0].pitch_mm
    gap = view_law(prototype.lens, pitch).effective_gap_mm(pitch)
    # The law bends by half a percent over these tangents; the two planes are 3.7 % apart.
    lens = prototype.lens
    wanted = 2 * math.pi * (gap / pitch + lens.thickness_mm * (1 / lens.pitch_mm - 1 / pitch))
    assert slope == pytest.approx(-wanted, rel=0.01)


def test_the_picture_shows_the_pose_that_the_truth_tells(prototype, tmp_path):
    """Catches: poses of the first row; a truth one frame late (11 px here); a first frame without a shutter's run."""
    path = tmp_path / "a.mp4"
    camera = Camera(width=960, height=540, focal_px=725.0, shutter_s=0.016, noise_counts=0.0)
    # The badge begins at 0.23 m/s, which is 11 px a frame here.
    shoot(prototype, path, frames=4, camera=camera, motion="sway")
    truth = truth_of(path)
    detector = cv2.aruco.ArucoDetector(
        cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, prototype.markers.dictionary))
    )
    for k, picture in enumerate(pictures(path)):
        corners, ids, _ = detector.detectMarkers(picture)
        assert sorted(np.ravel(ids)) == sorted(prototype.markers.ids), k
        turn = np.array([[truth[f"r{i}{j}"][k] for j in (1, 2, 3)] for i in (1, 2, 3)])
        place = np.array([truth[f"camera_{axis}_mm"][k] for axis in "xyz"])
        for quad, identity in zip(corners, np.ravel(ids), strict=True):
            centre = np.array([*prototype.markers.centers_mm[prototype.markers.ids.index(identity)], 0.0])
            local = turn @ (centre - [73.0, 73.0, 0.0] - place)
            wanted = camera.matrix @ (local / local[2])
            # The truth is that of the middle row; a marker 90 px from it is seen 90/540 of 16 ms away: 0.8 px.
            assert np.abs(quad[0].mean(axis=0) - wanted[:2]).max() < 1.2, (k, identity)


# Chance.


@pytest.mark.claim("One seed makes one film")
def test_one_seed_makes_one_film(prototype, tmp_path):
    """Catches: a global random state; noise that is the same in every film; a seed without effect."""
    one, again, other = (tmp_path / name for name in ("a.mp4", "b.mp4", "c.mp4"))
    # Of pictures under about 500 px, x264 (core 165, by its macroblock tree) makes another file each time.
    camera = Camera(width=1280, height=720, focal_px=967.0)
    for path, seed in ((one, 3), (again, 3), (other, 4)):
        shoot(prototype, path, motion="handheld", seed=seed, camera=camera)
    assert np.array_equal(pictures(one), pictures(again))
    assert truth_path(one).read_bytes() == truth_path(again).read_bytes()
    assert truth_path(one).read_bytes() == truth_path(other).read_bytes()
    assert np.abs(pictures(one).astype(int) - pictures(other)).max() > 5


def test_brightness_survives_the_file(prototype, tmp_path):
    """Catches: full-range luma in a file that players and our own reader take for limited range: black and white
    clip, and all contrast grows by 255/219.
    """
    camera = Camera(width=320, height=192, focal_px=242.0, noise_counts=0.0)
    path = tmp_path / "a.mp4"
    still = motion_named("static", distance_mm=600.0, seed=0)
    shoot(prototype, path, frames=2, camera=camera, motion=still, crf=1)
    scene = Scene(prototype, Build(), camera)
    pose = still(np.zeros(1))
    board = AnalyticRenderer(scene).render(Instant(pose, pose, pose.camera_mm[0]))
    exposed = Sensor(camera, 3).expose(board, pose.rotation[0], 0.0)
    back = pictures(path)[0].astype(float)
    slope, level = np.polyfit(exposed.ravel().astype(float), back.ravel(), 1)
    assert slope == pytest.approx(1.0, abs=0.02) and abs(level) < 3.0


@pytest.mark.slow
def test_the_command_films_with_camera_codec_and_recipe(prototype, tmp_path):
    """Catches: an option that is taken and not passed on; JSON that describes another film than the file holds."""
    (tmp_path / "badge.json").write_text(prototype.to_json(), encoding="utf-8")
    video = tmp_path / "a.mp4"
    options = ["--camera", "webcam", "--effect", "hlg", "--recipe", "call"]
    asked = ["simulate", str(tmp_path / "badge.json"), "--out", str(video), "--frames", "20", "--fps", "30", *options]
    done = CliRunner().invoke(moireid, [*asked, "--motion", "circle", "--forge", "patchy", "--json"])
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert document["label"] == "forged:patchy" and document["size"] == [640, 360]
    assert document["camera"]["width"] == 1280 and document["camera"]["distortion"][0] < 0
    with av.open(str(video)) as container:
        assert container.streams.video[0].codec_context.name == "hevc"
    assert len(pictures(video)) == document["frames"] == len(truth_of(video)["frame"]) < 20
    again = CliRunner().invoke(moireid, [*asked, "--motion", "circle", "--overwrite", "--explain"])
    assert again.exit_code == 0 and "render" in again.stdout and "encode" in again.stdout


# What is refused, and what is left behind.


@pytest.mark.parametrize("there", ["a.mp4", "a.mp4.truth.csv"])
def test_nothing_is_overwritten_unasked(prototype, tmp_path, there):
    """Catches: a check of the film alone; a check after the work is done."""
    (tmp_path / there).write_text("mine")
    document = []
    with pytest.raises(SpecError, match="overwrite=True"):
        shoot(prototype, tmp_path / "a.mp4", progress=lambda done, of: document.append(done))
    assert (tmp_path / there).read_text() == "mine" and document == [] and len(list(tmp_path.iterdir())) == 1
    shoot(prototype, tmp_path / "a.mp4", overwrite=True)
    assert len(pictures(tmp_path / "a.mp4")) == 6


def test_a_camera_behind_the_badge_is_refused(prototype, tmp_path):
    """Catches: a truth that gives a camera behind the badge as one before it, and nan as it passes through."""

    def through(times_s: np.ndarray) -> Poses:
        camera = np.column_stack([0 * times_s, 0 * times_s, 2000.0 * times_s - 200.0])
        return Poses(camera, np.tile(np.eye(3), (len(times_s), 1, 1)))

    with pytest.raises(SpecError, match="behind"):
        shoot(prototype, tmp_path / "a.mp4", motion=through)
    assert list(tmp_path.iterdir()) == []
