"""Where the simulated camera is.  Each test names the wrong implementation that it would catch."""

from __future__ import annotations

import csv
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from moireid.errors import MediaError
from moireid.simulate.motion import COLUMNS, MEASURED_RUN, Poses, motion_named

NAMES = ("handheld", "walk", "linear", "sway", "static", "roll", "tumble", "circle", "board", "both", "alike")
TIMES = np.arange(90) / 30.0 + 0.013


def motion_file(path: Path, rows: list[tuple[float, ...]], header: tuple[str, ...] = COLUMNS) -> Path:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        writer.writerows(rows)
    return path


def turned(axis: str, degrees: float) -> tuple[float, ...]:
    """Quaternion x, y, z, w of a camera turned about a world axis."""
    return tuple(Rotation.from_euler(axis, degrees, degrees=True).as_quat())


def forward(poses: Poses) -> np.ndarray:
    """The camera's own z axis in the board frame."""
    return np.swapaxes(poses.rotation, 1, 2) @ np.array([0.0, 0.0, 1.0])


# What holds of every motion.


@pytest.mark.parametrize("name", NAMES)
def test_camera_stands_before_the_board_and_looks_at_it(name):
    """Catches: the sign of z; rotations that are camera -> board instead of board -> camera."""
    poses = motion_named(name, distance_mm=900.0, seed=4)(TIMES)
    assert np.all(poses.camera_mm[:, 2] < -600)
    centre_seen = np.einsum("tij,tj->ti", poses.rotation, -poses.camera_mm)
    assert np.all(centre_seen[:, 2] > 600)


@pytest.mark.parametrize(
    "name", ["walk", "linear", "sway", "roll", "oblique", "tumble", "circle", "board", "both", "alike"]
)
def test_the_seed_decides_what_is_random(name):
    """Catches: a global random state; a seed that is not used."""
    one, again, other = (motion_named(name, distance_mm=900.0, seed=seed)(TIMES) for seed in (5, 5, 6))
    assert np.array_equal(one.rotation, again.rotation) and np.array_equal(one.camera_mm, again.camera_mm)
    assert np.abs(one.rotation - other.rotation).max() > 1e-3


@pytest.mark.parametrize("name", [*NAMES, "oblique"])
def test_poses_depend_on_time_alone(name):
    """Catches: a motion drawn anew at each call, which a rolling shutter's two calls a frame would tear apart."""
    motion = motion_named(name, distance_mm=900.0, seed=5)
    whole, part = motion(TIMES), motion(TIMES[40:41])
    assert np.allclose(whole.camera_mm[40], part.camera_mm[0], atol=1e-9)
    assert np.allclose(whole.rotation[40], part.rotation[0], atol=1e-12)


# The named motions.


def test_linear_goes_half_a_metre_in_two_seconds():
    """Catches: a sine instead of a straight even course; 0.25 m; a course that does not turn back."""
    times = np.linspace(0.0, 2.0, 41)
    motion = motion_named("linear", distance_mm=1000.0, seed=2)
    camera = motion(times).camera_mm
    assert camera[-1, 0] - camera[0, 0] == pytest.approx(500.0)
    assert np.allclose(np.diff(camera[:, 0]), 12.5)
    assert np.allclose(camera[:, 1:], [0.0, -1000.0])
    assert np.allclose(motion(4.0 - times).camera_mm[:, 0], camera[:, 0])


@pytest.mark.parametrize(("name", "reach"), [("board", 250.0), ("both", 250.0), ("alike", 0.0)])
def test_who_moves_decides_the_parallax(name, reach):
    """Catches: both going the same way where they should part; alike with a parallax; a camera that turns with a board.

    The tremor of half a degree about the board's middle moves a camera 1 m away by 9 mm root mean square.
    """
    times = np.linspace(0.0, 2.0, 81)
    poses = motion_named(name, distance_mm=1000.0, seed=2)(times)
    line = np.linspace(-reach, reach, 81) * (-1 if name != "alike" else 0)
    off = poses.camera_mm[:, 0] - line
    assert np.abs(off).max() < (45.0 if name != "alike" else 1e-9)
    seen = -np.einsum("tij,tj->ti", poses.rotation, poses.camera_mm)
    across = seen[:, 0] / seen[:, 2]
    # A camera on a stand sees the board go by; one that looks at the middle between sees half of that.
    wanted = {"board": 0.25, "both": 0.125, "alike": 0.0}[name]
    assert across[-1] - across[0] == pytest.approx(2 * wanted, abs=0.05)


# Motion files: the conventions, each by a case that is not symmetric.


def test_a_camera_that_moves_to_its_right_has_positive_parallax(tmp_path):
    """Catches: x mirrored; world axes taken for the board's.  The camera looks along world +x, right is world -z."""
    facing = turned("y", 90)
    rows = [(0.1 * k, 0.0, 0.0, -10.0 * k, *facing) for k in range(5)]
    poses = motion_named(str(motion_file(tmp_path / "m.csv", rows)), distance_mm=800.0, seed=0)(np.array([0.0, 0.4]))
    assert poses.camera_mm == pytest.approx(np.array([[-20.0, 0, -800], [20.0, 0, -800]]), abs=1e-6)


def test_a_camera_that_rises_has_negative_y_and_one_that_nears_a_smaller_distance(tmp_path):
    """Catches: y up; z counted away from the board.  World y is down, world z forward, as the file's columns say."""
    still = turned("y", 0)
    rows = [(0.1 * k, 0.0, -3.0 * k, 7.0 * k, *still) for k in range(5)]
    poses = motion_named(str(motion_file(tmp_path / "m.csv", rows)), distance_mm=800.0, seed=0)(np.array([0.0, 0.4]))
    assert poses.camera_mm == pytest.approx(np.array([[0.0, 6, -814], [0.0, -6, -786]]), abs=1e-6)


def test_a_camera_turned_to_its_right_sees_the_board_on_its_left(tmp_path):
    """Catches: the quaternion taken for world -> camera; its parts read as w first."""
    rows = [(0.1 * k, 0.0, 0.0, 0.0, *turned("y", 5.0 * (k - 2))) for k in range(5)]
    poses = motion_named(str(motion_file(tmp_path / "m.csv", rows)), distance_mm=800.0, seed=0)(np.array([0.4]))
    assert forward(poses)[0] == pytest.approx([np.sin(np.radians(10)), 0, np.cos(np.radians(10))], abs=1e-6)
    board_seen = poses.rotation[0] @ -poses.camera_mm[0]
    assert board_seen[0] == pytest.approx(-800 * np.sin(np.radians(10)), abs=1e-3)


def test_turning_the_whole_world_changes_nothing(tmp_path, rng):
    """Catches: the world's up used anywhere; positions and orientations turned by different rotations."""
    world = Rotation.from_euler("xyz", [40, -70, 130], degrees=True)
    turns = Rotation.from_rotvec(0.1 * rng.standard_normal((12, 3)))
    places, clock = 30.0 * rng.standard_normal((12, 3)), np.arange(12) * 0.1
    here = [(t, *p, *q) for t, p, q in zip(clock, places, turns.as_quat(), strict=True)]
    moved = world.apply(places) + np.array([500.0, -70.0, 9.0])
    there = [(t + 3.0, *p, *q) for t, p, q in zip(clock, moved, (world * turns).as_quat(), strict=True)]
    times = np.linspace(0, 1.1, 23)
    one, two = (
        motion_named(str(motion_file(tmp_path / name, rows)), distance_mm=800.0, seed=0)(times)
        for name, rows in (("a.csv", here), ("b.csv", there))
    )
    assert np.allclose(one.camera_mm, two.camera_mm, atol=1e-6)
    assert np.allclose(one.rotation, two.rotation, atol=1e-9)


# What is refused, in one sentence that says what to do.

GOOD = [(0.1 * k, 1.0 * k, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0) for k in range(5)]


@pytest.mark.parametrize(
    ("rows", "header", "word"),
    [
        (GOOD, ("t_s", "x", "y", "z", "qx", "qy", "qz", "qw"), "columns"),
        (GOOD[:3], COLUMNS, "3 rows"),
        ([*GOOD[:4], (0.4, "east", *GOOD[4][2:])], COLUMNS, "no number"),
        ([*GOOD[:4], (0.4, float("nan"), *GOOD[4][2:])], COLUMNS, "finite"),
        ([*GOOD[:4], (0.3, *GOOD[4][1:])], COLUMNS, "rising"),
        ([*GOOD[:4], (0.4, 0, 0, 0, 0, 0, 0, 0)], COLUMNS, "quaternion"),
        ([*GOOD[:4], (0.4, 1.0)], COLUMNS, "no number"),
        ([], COLUMNS, "0 rows"),
    ],
    ids=["columns", "short", "word", "nan", "times", "quaternion", "torn", "empty"],
)
def test_bad_motion_files_are_refused(tmp_path, rows, header, word):
    """Catches: NaN that spreads through the spline; a torn last line read as zeros."""
    path = motion_file(tmp_path / "m.csv", rows, header)
    with pytest.raises(MediaError, match=word):
        motion_named(str(path), distance_mm=800.0, seed=0)


def run_times() -> np.ndarray:
    """The measured run's own times, from its first row."""
    text = resources.files("moireid.simulate").joinpath(MEASURED_RUN).read_text(encoding="utf-8")
    clock = np.array([float(row["t_s"]) for row in csv.DictReader(text.splitlines())])
    return clock - clock[0]


@pytest.mark.parametrize("distance_mm", [700.0, 2300.0])
def test_the_mean_view_of_the_measured_run_is_straight(distance_mm):
    """Catches: the first view taken for the mean one; the world turned the wrong way round; a distance not set."""
    poses = motion_named("handheld", distance_mm=distance_mm, seed=0)(run_times())
    assert poses.camera_mm.mean(axis=0) == pytest.approx([0.0, 0.0, -distance_mm], abs=1e-6)
    mean = Rotation.from_matrix(poses.rotation).mean()
    assert mean.magnitude() == pytest.approx(0.0, abs=1e-6)


def test_columns_are_found_by_name(tmp_path):
    """Catches: columns read by their order."""
    rows = [(0.1 * k, 4.0 * k, 0.0, 0.0, *turned("y", 0)) for k in range(5)]
    shuffled = [(*row[4:], row[1], row[0], row[2], row[3], "note") for row in rows]
    header = (*COLUMNS[4:], "x_mm", "t_s", "y_mm", "z_mm", "remark")
    motion = motion_named(str(motion_file(tmp_path / "m.CSV", shuffled, header)), distance_mm=800.0, seed=0)
    assert motion(np.array([0.0, 0.4])).camera_mm[:, 0] == pytest.approx([-8.0, 8.0])
