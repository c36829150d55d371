"""Cameras of the simulator: lens, shutter, light, and what software does.  Each test names what it would catch."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from moireid.simulate.analytic.accuracy import compare
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer, BoardRadiance
from moireid.simulate.cameras import Camera, undistorted
from moireid.simulate.motion import Poses
from moireid.simulate.recording.sensor import Sensor, opened
from moireid.simulate.scene import Build, Instant, Scene

BENT = (-0.25, 0.08, 0.003, -0.002)
WIDE = Camera(width=640, height=360, focal_px=360.0, shutter_s=0.0, distortion=BENT)
#: A place and a turn that are symmetric in nothing.
PLACE = np.array([60.0, -45.0, -330.0])
TURN = cv2.Rodrigues(np.array([0.1, -0.15, 0.3]))[0]


def grey(value: float, size: tuple[int, int], left: int = 0, top: int = 0) -> BoardRadiance:
    return BoardRadiance(np.full(size, value, np.float32), np.ones(size, np.float32), left, top)


# The lens.


def test_points_fall_where_opencv_s_lens_puts_them(rng):
    """Catches: k1 and p1 exchanged, tangential terms the wrong way round, distortion of pixels instead of slopes."""
    points = rng.uniform(-200, 200, (40, 3)) + np.array([0.0, 0.0, 700.0])
    camera = replace(WIDE, principal_px=(300.0, 190.0))
    wanted, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, np.array(BENT))
    assert np.allclose(camera.project(points), wanted[:, 0], atol=1e-9)


def test_a_ray_comes_back_from_where_it_went(rng):
    """Catches: a fixed point that has not settled; an inverse of the radial part alone."""
    slopes = rng.uniform(-0.7, 0.7, (200, 2)) * [1.0, 0.6]
    bent = (WIDE.project(np.column_stack([slopes, np.ones(200)])) - WIDE.matrix[:2, 2]) / WIDE.focal_px
    back = np.array([undistorted(x, y, np.array(BENT)) for x, y in bent])
    assert np.abs(back - slopes).max() < 1e-8


def test_the_film_shows_the_board_s_corners_where_the_lens_puts_them(prototype):
    """Catches: a lens undone the wrong way (35 px here); a box around the board that cuts its bulging edges."""
    scene = Scene(prototype, Build(), WIDE)
    pose = Poses(PLACE[None], TURN[None])
    board = AnalyticRenderer(scene, rays=(8, 8)).render(Instant(pose, pose, PLACE))
    assert board is not None
    half = np.array(scene.board_half_mm)
    outline = np.array([[x, y] for x, y in zip(*rim(), strict=True)]) * half
    points = np.column_stack([outline, np.zeros(len(outline))])
    wanted, _ = cv2.projectPoints(points, cv2.Rodrigues(TURN)[0], -TURN @ PLACE, WIDE.matrix, np.array(BENT))
    wanted = wanted[:, 0]
    # A polygon through many points of the outline has the picture's area and its centre.
    x, y = wanted.T
    x1, y1 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y1 - x1 * y
    area = cross.sum() / 2
    centre = np.array([((x + x1) * cross).sum(), ((y + y1) * cross).sum()]) / (6 * area)
    rows, columns = np.indices(board.coverage.shape)
    weight = board.coverage.astype(float)
    found = np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum() + [board.left, board.top]
    assert weight.sum() == pytest.approx(abs(area), rel=1e-3)
    assert found == pytest.approx(centre, abs=0.05)


def rim() -> tuple[np.ndarray, np.ndarray]:
    """The outline of a square of half width 1, 400 points in turn."""
    way = np.linspace(-1, 1, 100, endpoint=False)
    one = np.ones(100)
    return np.concatenate([way, one, -way, -one]), np.concatenate([-one, way, one, -way])


# The shutter.


def test_a_moving_board_is_smeared_as_far_as_it_moves(prototype):
    """Catches: an exposure that ends at the frame's time; one that is twice as long; half the steps."""

    def going_left(times_s: np.ndarray) -> Poses:
        x = -600.0 * (np.atleast_1d(times_s) - 0.1)
        return Poses(np.column_stack([x, 0 * x, 0 * x - 600.0]), np.tile(np.eye(3), (len(x), 1, 1)))

    camera = Camera(width=640, height=360, focal_px=500.0, shutter_s=0.0, exposure_s=0.02)
    scene = Scene(prototype, Build(), camera)
    middle, (first, row, last) = opened(going_left, camera, scene.board_half_mm, 0.1, 30.0)
    assert middle.camera_mm[0] == pytest.approx([0.0, 0.0, -600.0])
    # 600 mm/s for 20 ms at 500/600 px to the millimetre is 10 px.
    assert len(row.camera_mm) == 10
    board = AnalyticRenderer(scene).render(Instant(first, last, row.camera_mm))
    assert board is not None
    row = board.coverage[board.coverage.shape[0] // 2]
    edge = 319.5 - 73 * 500 / 600 - board.left
    climb = np.interp([0.05, 0.5, 0.95], row[: len(row) // 2], np.arange(len(row) // 2))
    assert climb[1] == pytest.approx(edge, abs=0.6) and climb[2] - climb[0] == pytest.approx(9.0, abs=0.8)


@pytest.mark.claim("An exposure gathers what each of its instants shows")
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_an_exposure_is_the_mean_of_its_instants(prototype, precision):
    """Catches: rays all at one time; a motion at constant speed; tangents, rim or forged fringes held still."""

    def swung(times_s: np.ndarray) -> Poses:
        x, turn = 40.0 * np.sin(30 * times_s), 0.02 * np.sin(40 * times_s + 1)
        turns = [cv2.Rodrigues(np.array([0.5 * one, one, one]))[0] for one in turn]
        return Poses(np.column_stack([x, 0.3 * x, 20.0 * np.cos(20 * times_s) - 600.0]), np.array(turns))

    camera = Camera(width=480, height=360, focal_px=500.0, shutter_s=0.01, exposure_s=0.02)
    scene = Scene(prototype, Build(), camera)
    _, (first, row, last) = opened(swung, camera, scene.board_half_mm, 0.1, 30.0)
    shown = row.camera_mm + np.array([30.0, 0.0, 0.0])
    exposed = Instant(first, last, shown)
    board = AnalyticRenderer(scene, precision=precision).render(exposed)
    assert board is not None and len(shown) > 15
    instants = [Instant(first.one(k), last.one(k), shown[k]) for k in range(len(shown))]
    box = (board.left, board.top, board.left + board.radiance.shape[1], board.top + board.radiance.shape[0])
    seen = [AnalyticRenderer(scene).render(one, crop=box) for one in instants]
    cover = np.mean([one.coverage for one in seen], axis=0)
    light = np.mean([one.coverage * one.radiance for one in seen], axis=0)
    parts = BoardRadiance(light / np.maximum(cover, 1e-9), cover, board.left, board.top)
    found = compare(scene, instants[len(shown) // 2], board, parts)
    assert found.strips >= 1 and found.phase_rad < 0.02 and found.image < 0.06
    both = [np.zeros((360, 480)) for _ in range(2)]
    for picture, one in zip(both, (board, parts), strict=True):
        rows, columns = one.radiance.shape
        picture[one.top : one.top + rows, one.left : one.left + columns] = one.radiance * one.coverage
    apart = cv2.GaussianBlur(both[0] - both[1], (0, 0), 2.0)
    assert np.sqrt(np.mean(apart**2)) < 0.01 and np.abs(apart).max() < 0.06


# Light and software.


def edge() -> BoardRadiance:
    """A board that fills the picture: coded 0.4 on the left, 0.8 on the right."""
    return BoardRadiance(
        np.tile(np.repeat(np.float32([0.16, 0.64]), 64), (96, 1)), np.ones((96, 128), np.float32), 0, 0
    )


CALM = Camera(width=128, height=96, focal_px=100.0, noise_counts=0.0, exposure_drift=0.0)


def exposed(camera: Camera, board: BoardRadiance | None, time_s: float = 0.0) -> np.ndarray:
    return Sensor(camera, 5).expose(board, np.eye(3), time_s).astype(int)


def test_light_is_coded_by_a_square_root_and_clips():
    """Catches: an exposure after the transfer curve; clipping before it; counts that wrap round."""
    board = grey(0.36, (96, 128))
    assert exposed(CALM, board)[48, 64] == round(255 * 0.6)
    assert exposed(replace(CALM, exposure=0.25), board)[48, 64] == pytest.approx(255 * 0.3, abs=0.51)
    assert exposed(replace(CALM, exposure=4.0), board)[48, 64] == 255
    assert exposed(replace(CALM, exposure=0.0), board).max() == 0


def test_the_mirror_turns_left_to_right_and_nothing_else():
    """Catches: upside down; a mirrored board before a background that is not; noise drawn anew."""
    board = grey(0.9, (30, 20), 10, 5)
    camera = replace(CALM, noise_counts=3.0)
    assert np.array_equal(exposed(replace(camera, mirror=True), board), exposed(camera, board)[:, ::-1])


# What is refused.


def test_the_background_turns_with_the_camera():
    """Catches: a background that stays still in the picture, goes the wrong way, or is shifted by its coarse scale.

    A camera of 900 px that turns by 2 degrees moves it by 31 px in the middle.
    """
    camera = Camera(width=640, height=480, focal_px=900.0, noise_counts=0.0, exposure_drift=0.0)
    sensor = Sensor(camera, 5)
    straight = sensor.expose(None, np.eye(3), 0.0).astype(np.float32)
    turn = cv2.Rodrigues(np.array([0.0, np.radians(2.0), 0.0]))[0]
    turned = sensor.expose(None, turn, 0.0).astype(np.float32)
    # A point straight ahead at infinity, R (0, 0, 1), moves to the right by f tan 2 degrees.
    middle = np.s_[200:280, 280:360]
    shift, _ = cv2.phaseCorrelate(straight[middle] * 1.0, turned[200:280, 311:391] * 1.0)
    assert shift[0] == pytest.approx(900 * np.tan(np.radians(2.0)) - 31, abs=0.5)
    assert shift[1] == pytest.approx(0.0, abs=0.5)
    assert np.ptp(straight) > 20
