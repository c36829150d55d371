"""A grating as the fast renderer shows it from straight in front, and the phase of its fringes.

Frames are noise-free, so that each pixel's place on the lens plane is known without a pose.  A fringe's phase is then
read off by demodulating the picture with the law itself: what is left is the error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from moireid.badge import Badge
from moireid.lenticule import view_law
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer, BoardRadiance
from moireid.simulate.build import Build
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Camera, Instant, Scene

CAMERA = Camera()
#: Rays across and along a pixel in these tests; the default of (8, 2) has an error of its own, tested apart.
FINE = (32, 2)


def instant(camera_mm, last_mm=None, shown_mm=None) -> Instant:
    """A camera that looks straight along the board's normal."""
    first = np.array([camera_mm], float)
    last = first if last_mm is None else np.array([last_mm], float)
    shown = (first[0] + last[0]) / 2 if shown_mm is None else np.asarray(shown_mm, float)
    eye = np.eye(3)[None]
    return Instant(Poses(first, eye), Poses(last, eye), shown)


def render(badge: Badge, at: Instant, build: Build | None = None, rays=FINE, camera=CAMERA) -> BoardRadiance:
    shot = AnalyticRenderer(Scene(badge, build or Build(), camera), rays=rays).render(at)
    assert shot is not None
    return shot


@dataclass(frozen=True)
class View:
    """The grating in a frame: brightness (rows, columns), and the places x, y of its pixels on the lens plane."""

    brightness: np.ndarray
    x_mm: np.ndarray
    y_mm: np.ndarray


def view(badge: Badge, camera_mm, build: Build | None = None, rays=FINE, shown_mm=None) -> View:
    """The inner grating of a frame taken from straight in front, 3 mm clear of its border."""
    shot = render(badge, instant(camera_mm, shown_mm=shown_mm), build, rays)
    depth = -camera_mm[2] - Scene(badge, build or Build()).height_mm
    columns = shot.left + np.arange(shot.radiance.shape[1])
    rows = shot.top + np.arange(shot.radiance.shape[0])
    x = (columns - (CAMERA.width - 1) / 2) / CAMERA.focal_px * depth + camera_mm[0]
    y = (rows - (CAMERA.height - 1) / 2) / CAMERA.focal_px * depth + camera_mm[1]
    x0, y0, x1, y1 = np.array(badge.gratings[0].rect_mm) - np.tile(middle(badge), 2)
    across, down = (x > x0 + 3) & (x < x1 - 3), (y > y0 + 3) & (y < y1 - 3)
    return View(shot.radiance[np.ix_(down, across)].astype(float), x[across], y[down])


def middle(badge: Badge) -> np.ndarray:
    x0, y0, x1, y1 = badge.outline_mm
    return np.array([(x0 + x1) / 2, (y0 + y1) / 2])


def line_phase(badge: Badge) -> float:
    """Phase of the page's lines at the board's centre: 0 would be a dark line's middle there."""
    cell = badge.gratings[0].cells[0]
    return -2 * math.pi * (cell.edge_mm - middle(badge)[0] + cell.duty * cell.pitch_mm / 2) / cell.pitch_mm


def law_phase(badge: Badge, seen: View, camera_mm) -> np.ndarray:
    """psi(x) = 2 pi x (1/p_r - 1/p_f) + view, with the constant that the lines' edges give; (rows, columns)."""
    depth = -camera_mm[2] - badge.lens.thickness_mm
    pitch = badge.gratings[0].cells[0].pitch_mm
    tan_x = (seen.x_mm[None, :] - camera_mm[0]) / depth
    tan_y = (seen.y_mm[:, None] - camera_mm[1]) / depth
    beat = 2 * math.pi * seen.x_mm * (1 / pitch - 1 / badge.lens.pitch_mm)
    return beat[None, :] + view_law(badge.lens, pitch).phase_rad(tan_x, tan_y) + line_phase(badge)


def left_over(seen: View, phase: np.ndarray) -> float:
    """Mean phase of the fringes beyond `phase`, rad; dark where a dark line is shown, hence the sign."""
    level = seen.brightness - seen.brightness.mean(axis=1, keepdims=True)
    taper = np.hanning(level.shape[1])
    return float(np.angle(-(taper * level * np.exp(-1j * phase)).sum()))


def steepness(seen: View, phase: np.ndarray, axis: int) -> float:
    """Slope of the phase left over along y (axis 0) or x (axis 1), rad/mm."""
    level = seen.brightness - seen.brightness.mean(axis=1, keepdims=True)
    turned = -level * np.exp(-1j * phase)
    if axis == 0:
        rows = (turned * np.hanning(turned.shape[1])).sum(axis=1)
        return float(np.polyfit(seen.y_mm, np.unwrap(np.angle(rows)), 1)[0])
    half = turned.shape[1] // 2
    sums = [(part * np.hanning(half)).sum() for part in (turned[:, :half], turned[:, -half:])]
    gap_mm = seen.x_mm[-half] - seen.x_mm[0]
    return float(np.angle(sums[1] / sums[0]) / gap_mm)
