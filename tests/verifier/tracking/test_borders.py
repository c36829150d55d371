"""Two markers and the gratings' borders: a page whose place is known, under fingers."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from moireid.badge import Badge
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.cameras import Camera
from moireid.simulate.motion import Poses
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Instant, Scene
from moireid.verifier.camera.smoothing import smooth_camera
from moireid.verifier.fringes.signals import measure
from moireid.verifier.tracking.borders import borders_of
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import PageRegistrar
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.video import Film

CAMERA = Camera(width=640, height=480, focal_px=1450.0, shutter_s=0.0)


def seen(badge: Badge, camera_x_mm: float, build: Build) -> tuple[np.ndarray, np.ndarray]:
    """A picture of the badge from 1 m, the camera aside, and the true homography."""
    scene = Scene(badge, build, CAMERA)
    place = np.array([camera_x_mm, 40.0, -1000.0])
    forward = -place / np.linalg.norm(place)
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right)
    turn = np.stack([right, np.cross(forward, right), forward])
    pose = Poses(place[None], turn[None])
    picture = Sensor(CAMERA, 3).expose(AnalyticRenderer(scene).render(Instant(pose, pose, place)), turn, 0.0)
    to_board = np.array([[1, 0, -scene.board_centre_mm[0]], [0, 1, -scene.board_centre_mm[1]], [0, 0, 1.0]])
    warp = CAMERA.matrix @ np.column_stack([turn[:, 0], turn[:, 1], -turn @ place]) @ to_board
    return picture, warp / warp[2, 2]


def covered(picture: np.ndarray, homography: np.ndarray, badge: Badge, which: tuple[int, ...]) -> np.ndarray:
    """The picture with markers hidden under grey that looks like no marker's outline."""
    hidden = picture.copy()
    for index in which:
        middle = cv2.perspectiveTransform(np.array([[badge.markers.centers_mm[index]]]), homography).ravel()
        cv2.circle(hidden, tuple(int(v) for v in np.round(middle)), 31, 150, -1)
    return hidden


def apart_px(one: np.ndarray, other: np.ndarray, badge: Badge) -> float:
    points = marker_corners_mm(badge.markers).reshape(-1, 1, 2)
    away = cv2.perspectiveTransform(points, one) - cv2.perspectiveTransform(points, other)
    return float(np.sqrt(np.mean(np.sum(away**2, axis=-1))))


@pytest.mark.parametrize("which", [(0, 1), (0, 3), (0, 2)])
@pytest.mark.parametrize("camera_x_mm", [-150.0, 120.0])
def test_two_markers_and_the_borders_hold_the_page(prototype, which, camera_x_mm):
    """Catches: a page from two markers alone (refused without borders); x for y; a border pulled inward by its fringes;
    a shift of the wrong sign, or none for what lies under a sheet.
    """
    picture, truth = seen(prototype, camera_x_mm, Build(twist_rad=0.002))
    picture = covered(picture, truth, prototype, which)
    start = np.array([[1, 0, 0.6], [0, 1, -0.5], [0, 0, 1.0]]) @ truth
    assert PageRegistrar(prototype.markers).register(picture, start) is None
    found = PageRegistrar(prototype.markers, borders_of(prototype)).register(picture, start)
    assert found is not None
    assert apart_px(found.homography, truth, prototype) < 0.8
    # Markers one above the other determine the tilt along x less well than markers side by side.
    assert min(found.vague) >= 1.0 and max(found.vague) > 3.0
    assert (found.vague[0] > found.vague[1]) == (which == (0, 3)) or which == (0, 2)


def test_one_marker_or_hidden_borders_are_refused(prototype):
    """Catches: a pose from one marker; one from a single border."""
    picture, truth = seen(prototype, 60.0, Build())
    registrar = PageRegistrar(prototype.markers, borders_of(prototype))
    assert registrar.register(covered(picture, truth, prototype, (0, 1, 2)), truth) is None
    hidden = covered(picture, truth, prototype, (0, 1))
    x0, y0, x1, _ = prototype.gratings[0].rect_mm
    strip = cv2.perspectiveTransform(np.array([[[x0, y0 - 4], [x1, y0 - 4], [x1, y0 + 8], [x0, y0 + 8]]]), truth)
    cv2.fillConvexPoly(hidden, np.round(strip[0]).astype(int), 150.0)
    assert registrar.register(hidden, truth) is None


def test_a_square_of_grey_is_no_marker(prototype):
    """Catches: a patch that looks like a marker's outline taken for a seen marker, and the page turned by it."""
    picture, truth = seen(prototype, 60.0, Build())
    for index in (0, 1):
        x, y = prototype.markers.centers_mm[index]
        corners = np.array([[[x - 14, y - 14], [x + 14, y - 14], [x + 14, y + 14], [x - 14, y + 14]]], float)
        cv2.fillConvexPoly(picture, np.round(cv2.perspectiveTransform(corners, truth)[0]).astype(int), 60.0)
    found = PageRegistrar(prototype.markers, borders_of(prototype)).register(picture, truth)
    assert found is None or max(found.vague) > 3.0


def test_vague_frames_weigh_less_and_say_so(films, prototype):
    """Catches: an error bar that forgets how a pose was come by; smoothing that follows a vague frame."""
    view = SceneTracker(prototype)
    for frame, _ in zip(Film(films / "genuine_1.0m.mp4").frames(), range(90), strict=False):
        view.push(frame)
    track = view.trackers[0].take()
    assert track.vague is None
    vague = np.ones((90, 2))
    vague[40:50, 0] = 8.0
    even, marked = measure(track).gratings[0], measure(replace(track, vague=vague)).gratings[0]
    grown = marked.phase_sd_rad / even.phase_sd_rad
    assert grown[:40] == pytest.approx(1.0, abs=0.1) and np.all(grown[40:50] > 1.5)
    camera = np.tile([0.0, 0.0, -1000.0], (90, 1))
    camera[45, 0] = 50.0
    times, error = np.arange(90) / 30, (0.0, 0.0)
    spread = np.ones((90, 2))
    spread[45] = 20.0
    followed, held = smooth_camera(camera, times, error), smooth_camera(camera, times, error, spread)
    assert abs(held[45, 0]) < 1.0 < 5.0 < abs(followed[45, 0])
