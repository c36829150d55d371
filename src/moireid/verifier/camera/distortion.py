"""The effect of a lens's radial distortion on a registered page.

A page is registered by a homography, as a plane in perspective.  The homography absorbs a part of the distortion, as if
the page were tilted.  The rest stays in the picture and does not enter the points.  So points are corrected only by the
part that the homography has absorbed.

Convention: x_distorted = x (1 + a r^2 + b (r^4 - MIDDLE r^2)), x in units of a focal length from the picture's centre.
So a - MIDDLE b and b are k1 and k2 of Brown's model (OpenCV's), in which a barrel is negative.
Source: the tangent space of homographies at the points' places, least squares over the points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: With this share of r^2 the two strengths are independent over lenses as sold (gyroflow's table of lenses).
MIDDLE = 0.4
#: Beyond this distance from the axis, which no lens shows, a distortion grows no further.
FAR = 1.0
#: Least and most steps of the iteration, and the change at which it has settled, in focal lengths.
STEPS, MOST_STEPS, SETTLED = 3, 12, 1e-6
#: Registration weighs all edges of a marker's print.  Four points in a marker, this share of the way from its middle to
#: its corners, stand for them: the edge of a square has 0.82, all of its area 0.58.  Fitted to films by an outside
#: tracer through barrels of 0.25 to 0.4.
EDGES_SHARE = 0.75
#: Share of a point's weight.
RIDGE = 1e-9
#: Displacements that are kept: searches of other unknowns, and their slopes, ask for a few again and again.
MOST_KEPT = 6
Frames = NDArray[np.int64] | slice


class TakenIn:
    """The part of a distortion that the homographies of some points absorb, for any strength."""

    def __init__(self, points_px: Array, focal: float) -> None:
        """Parameters: points_px (T, N, 2), distorted, four of each marker; focal: unit of x in the convention, px."""
        self._focal = focal
        #: With the frames, so that no others can have their `id`.
        self._kept: dict[tuple[Any, ...], tuple[Frames, Array]] = {}
        points = points_px.swapaxes(1, 2)
        self._middles = points.mean(axis=2, keepdims=True)
        self._sizes = np.maximum(np.abs(points - self._middles).max(axis=(1, 2), keepdims=True), 1e-12)
        self._corners = np.ascontiguousarray((points - self._middles) / self._sizes)
        self._within = _within(self._corners)
        table = _tangents(self._within)
        # Four markers make the eight columns independent; a ridge also works for unusual boards.
        turned = table.swapaxes(-1, -2)
        self._inverse: Array = np.asarray(np.linalg.solve(turned @ table + RIDGE * np.eye(8), turned), float)
        #: Those of the frames that were asked for last.
        self._chosen: tuple[Frames, Array] = slice(None), self._inverse

    def absorbed(self, moved_px: Array, frames: Frames) -> Array:
        """The part of small displacements (T, N, 2) px that the homographies of these frames absorb."""
        fitted = self._fitted(_within(moved_px.swapaxes(1, 2)), frames)
        found = _tangents(self._corners[frames]) @ fitted[..., None]
        return np.asarray(found.reshape(len(found), 2, -1).swapaxes(1, 2))

    def _fitted(self, moved: Array, frames: Frames) -> Array:
        """Coefficients (T, 8) of the homographies' tangent space that fit displacements (T, 2, N)."""
        if self._chosen[0] is not frames:
            self._chosen = frames, self._inverse[frames]
        return np.asarray((self._chosen[1] @ moved.reshape(len(moved), -1, 1))[..., 0])

    def px(self, strengths: Array, centre: tuple[float, float], frames: Frames) -> Array:
        """Displacement of the points of these frames by the distortion, (T, N, 2) px; strengths: a and b.

        Parameters: centre: of the distortion, which is where the optical axis meets the picture, px.
        Returns: an array that may be kept, and is read only.
        """
        key = (*strengths, *centre, repr(frames) if isinstance(frames, slice) else id(frames))
        if key not in self._kept:
            found = self._solved_px(strengths, centre, frames)
            found.flags.writeable = False
            self._kept[key] = frames, found
            if len(self._kept) > MOST_KEPT:
                del self._kept[next(iter(self._kept))]
        return self._kept[key][1]

    def _solved_px(self, strengths: Array, centre: tuple[float, float], frames: Frames) -> Array:
        """As `px`, by iteration, as a distortion refers to the undistorted place of a point.

        Source: registration leaves of the distorted points what is at right angles to the tangent space at the
            registered ones, and the straight points are a homography of those.  A step along that space in the place
            of the homography is wrong by up to half a pixel where a webcam bends a large page near the border.
        """
        corners, seen = self._corners[frames], self._within[frames]
        if not np.any(strengths):
            return np.zeros_like(corners).swapaxes(1, 2)
        middle = (self._middles[frames] - np.array(centre)[:, None]) / self._focal
        size = self._sizes[frames] / self._focal
        straight, whole = seen, np.eye(3)[None]
        for step in range(MOST_STEPS):
            true, before = middle + size * straight, straight
            square = np.minimum((true**2).sum(axis=1, keepdims=True), FAR**2)
            bent = true * (square * (strengths[0] + strengths[1] * (square - MIDDLE)) / size)
            whole = _homographies(self._fitted(straight + bent - seen, frames)) @ whole
            straight = _mapped(whole, seen)
            if step + 1 >= STEPS and (size * np.abs(straight - before)).max() < SETTLED:
                break
        return np.asarray((self._sizes[frames] * (corners - _mapped(whole, corners))).swapaxes(1, 2))


def _within(corners: Array) -> Array:
    """Points of the markers that stand for all edges of their print, from their corners; (T, 2, N)."""
    markers = corners.reshape(len(corners), 2, -1, 4)
    middles = markers.mean(axis=3, keepdims=True)
    return np.asarray((middles + EDGES_SHARE * (markers - middles)).reshape(corners.shape))


def _tangents(points: Array) -> Array:
    """How points (T, 2, N) move as their homography changes, (T, 2 N, 8)."""
    x, y = points[:, 0], points[:, 1]
    one, none = np.ones_like(x), np.zeros_like(x)
    along_x = np.stack([x, y, one, none, none, none, x * x, x * y], axis=-1)
    along_y = np.stack([none, none, none, x, y, one, x * y, y * y], axis=-1)
    return np.concatenate([along_x, along_y], axis=1)


def _homographies(coefficients: Array) -> Array:
    """Homographies (T, 3, 3) that take away changes (T, 8) along `_tangents`."""
    less = np.concatenate([-coefficients[:, :6], coefficients[:, 6:], np.zeros((len(coefficients), 1))], axis=1)
    return np.asarray(np.eye(3) + less.reshape(-1, 3, 3))


def _mapped(homographies: Array, points: Array) -> Array:
    """Points (T, 2, N) as the homographies (T, 3, 3) show them."""
    moved = homographies[:, :, :2] @ points + homographies[:, :, 2:]
    return np.asarray(moved[:, :2] / moved[:, 2:])
