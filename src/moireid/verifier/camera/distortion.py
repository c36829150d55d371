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

#: Share of a point's weight.
RIDGE = 1e-9
#: Displacements that are kept: searches of other unknowns, and their slopes, ask for a few again and again.
MOST_KEPT = 6
Frames = NDArray[np.int64] | slice


class TakenIn:
    """The part of a distortion that the homographies of some points absorb, for any strength."""

    def __init__(self, points_px: Array, focal: float) -> None:
        """Parameters: points_px (T, N, 2), distorted; focal: unit of x in the convention, px."""
        self._focal, self._points = focal, points_px
        #: With the frames, so that no others can have their `id`.
        self._kept: dict[tuple[Any, ...], tuple[Frames, Array]] = {}
        local = points_px - points_px.mean(axis=1, keepdims=True)
        local /= np.maximum(np.abs(local).max(axis=(1, 2), keepdims=True), 1e-12)
        x, y = local[..., 0], local[..., 1]
        one, none = np.ones_like(x), np.zeros_like(x)
        along_x = np.stack([x, y, one, none, none, none, x * x, x * y], axis=-1)
        along_y = np.stack([none, none, none, x, y, one, x * y, y * y], axis=-1)
        table = np.concatenate([along_x, along_y], axis=1)
        # Four markers make the eight columns independent; a ridge also works for unusual boards.
        turned = table.swapaxes(-1, -2)
        self._table, self._inverse = table, np.linalg.solve(turned @ table + RIDGE * np.eye(8), turned)
        #: Those of the frames that were asked for last.
        self._chosen: tuple[Frames, Array, Array] = slice(None), self._table, self._inverse

    def absorbed(self, moved_px: Array, frames: Frames) -> Array:
        """The part of displacements (T, N, 2) px that the homographies of these frames absorb."""
        wanted = np.concatenate([moved_px[..., 0], moved_px[..., 1]], axis=1)[..., None]
        if self._chosen[0] is not frames:
            self._chosen = frames, self._table[frames], self._inverse[frames]
        _, table, inverse = self._chosen
        fitted = (table @ (inverse @ wanted))[..., 0]
        half = fitted.shape[1] // 2
        return np.stack([fitted[:, :half], fitted[:, half:]], axis=-1)

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
        """As `px`.

        A distortion refers to the undistorted place of a point, so it is found by iteration: for a strength of 0.1, the
        first step leaves an error of 3 %, and the third none.
        """
        seen = (self._points[frames] - np.array(centre)) / self._focal
        bent = np.zeros_like(seen)
        if not np.any(strengths):
            return np.asarray(bent)
        for step in range(MOST_STEPS):
            straight, before = seen - bent, bent
            square = np.minimum((straight**2).sum(axis=-1, keepdims=True), FAR**2)
            wanted = straight * square * (strengths[0] + strengths[1] * (square - MIDDLE))
            bent = self.absorbed(wanted, frames)
            if step + 1 >= STEPS and np.abs(bent - before).max() < SETTLED:
                break
        return np.asarray(self._focal * bent)
