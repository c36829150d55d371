"""A badge's corners as a film would give them: a hand's course, a pinhole, a rolling shutter, and registration's noise.

Nothing of the verifier enters.
"""

from __future__ import annotations

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

SIZE = (1920, 1080)
CENTRE = np.array([959.5, 539.5])
#: Sixteen corners of four markers on a board of 146 x 160 mm that lies anywhere on its page.
PAGE_MM = np.array(
    [
        [x + a, y + b]
        for x, y in ((50.0, 86.5), (160.0, 86.5), (160.0, 210.5), (50.0, 210.5))
        for a, b in ((-13.0, -13.0), (13.0, -13.0), (13.0, 13.0), (-13.0, 13.0))
    ]
)
MIDDLE = PAGE_MM.mean(axis=0)
FPS = 30.0


class Course:
    """A hand's motion as sums of sines: camera centre (page mm, z negative) and orientation at any time."""

    def __init__(self, rng: np.random.Generator, distance_mm: float, *, tilt_deg=9.0, sway_mm=150.0) -> None:
        self._hz = rng.uniform(0.15, 0.9, (6, 3))
        self._phase = rng.uniform(0, 2 * np.pi, (6, 3))
        size = np.array([sway_mm, 0.4 * sway_mm, 40.0, tilt_deg, tilt_deg, 3.0])
        self._size, self._distance = size, distance_mm

    def _wave(self, times: np.ndarray) -> np.ndarray:
        turns = 2 * np.pi * self._hz * times[:, None, None] + self._phase
        return self._size * np.sin(turns).sum(axis=2) / np.sqrt(1.5)

    def pose(self, times: np.ndarray) -> tuple[np.ndarray, Rotation]:
        """Centres (T, 3) and rotations page -> camera; the camera aims at the page but for its own tilt."""
        wave = self._wave(times)
        camera = np.column_stack([MIDDLE[0] + wave[:, 0], MIDDLE[1] + wave[:, 1], wave[:, 2] - self._distance])
        ahead = np.column_stack([MIDDLE[0] - camera[:, 0], MIDDLE[1] - camera[:, 1], -camera[:, 2]])
        yaw, pitch = np.arctan2(ahead[:, 0], ahead[:, 2]), -np.arctan2(ahead[:, 1], ahead[:, 2])
        aim = Rotation.from_euler("yx", np.column_stack([yaw, pitch])).inv()
        return camera, Rotation.from_euler("xyz", np.radians(0.3 * wave[:, 3:])) * aim


def project(camera: np.ndarray, turn: Rotation, focal: float, places: np.ndarray = PAGE_MM) -> np.ndarray:
    """Pictures (T, N, 2) of page places (N, 2), or (N, 3) of a page that is not flat, z into it."""
    flat = np.column_stack([places, np.zeros((len(places), 3 - places.shape[1]))])
    local = np.einsum("tij,tnj->tni", turn.as_matrix(), flat[None] - camera[:, None])
    return focal * local[..., :2] / local[..., 2:] + CENTRE


def rolled(
    course: Course, times: np.ndarray, focal: float, shutter_s: float, places: np.ndarray = PAGE_MM
) -> np.ndarray:
    """Pictures under a rolling shutter: each corner at the moment when its own row is read, found by iteration.

    The frame's time is that of the picture's middle row.
    """
    seen = project(*course.pose(times), focal, places)
    for _ in range(4):
        late = shutter_s * (seen[..., 1] - CENTRE[1]) / SIZE[1]
        for k in range(places.shape[0]):
            seen[:, k] = project(*course.pose(times + late[:, k]), focal, places[k : k + 1])[:, 0]
    return seen


def registered(points: np.ndarray, rng: np.random.Generator, noise_px: float) -> np.ndarray:
    """The corners as registration hands them on: noisy ones, put on the homography that fits them best."""
    noisy = points + noise_px * rng.standard_normal(points.shape)
    homographies = [cv2.findHomography(PAGE_MM, frame)[0] for frame in noisy]
    return np.array([cv2.perspectiveTransform(PAGE_MM[:, None], h)[:, 0] for h in homographies])


def tangents(camera_mm: np.ndarray) -> np.ndarray:
    """Parallax coordinates at the page's middle, (T, 2)."""
    return (camera_mm[:, :2] - MIDDLE) / np.abs(camera_mm[:, 2:])
