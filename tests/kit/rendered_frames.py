"""Frames of a still camera by either renderer, and the phase of the fringes in them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Cell
from moireid.lenticule import view_law
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer, BoardRadiance
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]


Crop = tuple[int, int, int, int]


#: Rays of the analytic reference, across and along: enough that its own error is small next to Mitsuba's noise.
REFERENCE_RAYS = (64, 8)


def seen_from(camera_mm: tuple[float, float, float], turns_deg: tuple[float, float, float] = (0, 0, 0)) -> Instant:
    """A still camera; turns about y, x and z, board to camera."""
    rotation = Rotation.from_euler("yxz", turns_deg, degrees=True).as_matrix()
    pose = Poses(np.array([camera_mm], float), rotation[None])
    return Instant(pose, pose, np.array(camera_mm, float))


def pixels_of(scene: Scene, instant: Instant, rect_mm: tuple[float, float, float, float]) -> Crop:
    """The box of pixels around a rectangle of the page."""
    middle = scene.board_centre_mm
    corners = np.array([[rect_mm[i] - middle[0], rect_mm[j] - middle[1], 0.0] for i in (0, 2) for j in (1, 3)])
    local = (corners - instant.first.camera_mm[0]) @ instant.first.rotation[0].T
    places = (local / local[:, 2:] @ scene.camera.matrix.T)[:, :2]
    (left, top), (right, bottom) = np.floor(places.min(axis=0)).astype(int), np.ceil(places.max(axis=0)).astype(int)
    return int(left), int(top), int(right) + 1, int(bottom) + 1


def cut(picture: BoardRadiance, crop: Crop) -> Array:
    """The radiance of those pixels of a whole board's picture."""
    rows = slice(crop[1] - picture.top, crop[3] - picture.top)
    return picture.radiance[rows, crop[0] - picture.left : crop[2] - picture.left].astype(float)


def analytic_frame(scene: Scene, instant: Instant, rays: tuple[int, int] = REFERENCE_RAYS) -> BoardRadiance:
    frame = AnalyticRenderer(scene, rays=rays).render(instant)
    assert frame is not None
    return frame


def beyond_law_rad(picture: BoardRadiance, scene: Scene, instant: Instant, cell: Cell) -> float:
    """Phase of a band's fringes less the phase that `ViewLaw` says, up to the badge's own constant.

    Cosines and sines of the law's phase and of its harmonics are fitted to the pixels well inside the band.
    """
    camera, lens, eye = scene.camera, scene.badge.lens, instant.first.camera_mm[0]
    rows, columns = np.indices(picture.radiance.shape)
    u = (columns + picture.left - camera.matrix[0, 2]) / camera.focal_px
    v = (rows + picture.top - camera.matrix[1, 2]) / camera.focal_px
    sight = np.stack([u, v, np.ones_like(u)], axis=-1) @ instant.first.rotation[0]
    tan_x, tan_y = sight[..., 0] / sight[..., 2], sight[..., 1] / sight[..., 2]
    page_x, page_y = (eye[k] - eye[2] * tan + scene.board_centre_mm[k] for k, tan in enumerate((tan_x, tan_y)))
    x0, y0, x1, y1 = cell.rect_mm
    inside = (page_x > x0 + 2) & (page_x < x1 - 2) & (page_y > y0 + 1) & (page_y < y1 - 1)
    lens_x = eye[0] - (eye[2] + lens.thickness_mm) * tan_x
    beat = 1 / cell.pitch_mm - 1 / lens.pitch_mm
    phase = (2 * math.pi * beat * lens_x + view_law(lens, cell.pitch_mm).phase_rad(tan_x, tan_y))[inside]
    waves = [wave(order * phase) for order in (1, 2, 3) for wave in (np.cos, np.sin)]
    fit, *_ = np.linalg.lstsq(np.stack([np.ones_like(phase), *waves], axis=1), picture.radiance[inside], rcond=None)
    return math.atan2(-fit[2], fit[1])


def turn_rad(after: float, before: float) -> float:
    """after - before, within half a turn."""
    return (after - before + math.pi) % (2 * math.pi) - math.pi
