"""What a page is wrong by whose corners a person gave: one warp, the same in all frames, told by the film itself.

A page that was set wrong by a pixel or two of a hundred looks tilted by a fifth of a radian and more.  But no rigid
page seen by one camera could look so from all sides, so the film tells four of the warp's eight parameters: how much
too wide the page is for its height, how sheared, and how its far sides are too large.  The other four are a shift, a
turn and a size within the page's plane; they change no tilt.

1. Here: least squares on what makes each homography that of a rigid page, from no warp on.  It knows of no two poses,
   so it cannot choose the wrong one, but noise pulls it.
2. In `film_wide`: the same four parameters again, on reprojection error, together with focal length, shutter and
   distortion; so the error bars of all of them are those of a page that is only known so well.

Convention: parameters in units of what a corner set wrong by `GIVEN_SD_PX` makes of them; homographies page mm -> px.
Source: self-calibration from planes (Triggs, Autocalibration from Planar Scenes, 1998): of a rigid page's homography
K [r1 r2 t] the first two columns, with K's inverse before them, are orthogonal and alike in length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from moireid.badge import Rect

Array = NDArray[np.float64]
#: Standard deviation of a corner's coordinate as people set them, px: zoomed in, a pixel; not zoomed in, two.
GIVEN_SD_PX = 2.0
#: What a page's homography errs by at its corners, px: 0.03 to 0.25 on films whose pages are known.
FOLLOWED_SD_PX = 0.2
#: A page followed by a frame's own print errs alike in neighbouring frames, so error bars that take frames for
#: independent are too small.  Gains of 11 true films, told so, lay 2.5 of their error bars from 1 (root mean square);
#: and poses whose truth is known erred by up to 1.2 times what they tell, where markers' err by 0.6 to 0.8 times.
STRETCH_UNTOLD, POSE_UNTOLD = 2.5, 1.5
#: A page set wrong lies far outside that, so it is let in by and by.
LOOSE = (100.0, 20.0, 5.0, 1.0)


@dataclass(frozen=True)
class PageWarps:
    """Four ways in which a page may be wrong still.

    homographies (T, 3, 3): with the first guess of the warp taken out; ways (4, 3, 3): page mm -> page mm, one unit
    each; prior (4,): where no warp at all would lie, in those units.
    """

    homographies: Array
    ways: Array
    prior: Array

    def points_px(self, page_mm: Array) -> Array:
        """How far the ways move points (N, 2) of the page in the picture, (4, T, N, 2) px."""
        flat = np.column_stack([page_mm, np.ones(len(page_mm))])
        moved = [_mapped(self.homographies @ way, flat) for way in self.ways]
        return np.stack(moved) - _mapped(self.homographies, flat)


def page_warps(homographies: Array, region: Rect, image_px: tuple[int, int], focal_px: float) -> PageWarps:
    """The first guess of a page's warp, and how it may be wrong still.

    Parameters: homographies (T, 3, 3); region: of the page, whose corners were given; focal_px: a guess of it.
    Source: step 1 of the module docstring.
    """
    x0, y0, x1, y1 = region
    middle, half = ((x0 + x1) / 2, (y0 + y1) / 2), max(x1 - x0, y1 - y0) / 2
    to_page = np.array([[half, 0, middle[0]], [0, half, middle[1]], [0, 0, 1.0]])
    centred = np.array([[1, 0, (1 - image_px[0]) / 2], [0, 1, (1 - image_px[1]) / 2], [0, 0, 1.0]])
    seen = centred @ homographies @ to_page
    seen = seen / seen[:, 2:, 2:]
    half_px = float(np.sqrt(np.median(np.abs(np.linalg.det(seen)))))
    # Of four corners each pattern of two signs errs half as much as one corner; width against height has two of them.
    unit = GIVEN_SD_PX / half_px * np.array([np.sqrt(0.5), np.sqrt(0.5), 0.5, 0.5])
    noise = FOLLOWED_SD_PX / half_px
    rays = np.diag([1 / focal_px, 1 / focal_px, 1.0]) @ seen

    def left_over(warp: Array, loose: float) -> Array:
        columns = rays @ _warped(warp * unit)
        first, second = columns[..., 0], columns[..., 1]
        across, down = (first**2).sum(axis=1), (second**2).sum(axis=1)
        shape = np.concatenate([2 * (first * second).sum(axis=1), across - down]) / np.tile(across + down, 2)
        # Frames that were followed wrongly count little.
        return np.concatenate([np.arctan(shape / (loose * noise)), warp])

    found = np.zeros(4)
    for loose in LOOSE:
        found = least_squares(left_over, found, args=(loose,)).x
    back = np.linalg.inv(to_page)
    straight = to_page @ _warped(found * unit) @ back
    ways = np.stack([to_page @ _warped(way * unit) @ back for way in np.eye(4)])
    # A step of the warp after the first guess is a step of the warp itself, but for products of two small ones.
    return PageWarps(homographies @ straight, ways, -found)


def _warped(warp: Array) -> Array:
    """Width against height, shear, and the two perspective parameters as a page's warp."""
    wide, sheared, along_x, along_y = warp
    return np.array([[1 + wide / 2, sheared / 2, 0], [sheared / 2, 1 - wide / 2, 0], [along_x, along_y, 1.0]])


def _mapped(homographies: Array, flat: Array) -> Array:
    mapped = np.einsum("tij,nj->tni", homographies, flat)
    return np.asarray(mapped[..., :2] / mapped[..., 2:])
