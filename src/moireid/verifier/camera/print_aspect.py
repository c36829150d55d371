"""The effect of a print whose two directions differ in scale, on a registered page.

A printer feeds paper a little too far or too short, by one or some thousandths, and paper grows more across its fibres
than along them.  A page that is a thousandth too high looks like one that is tilted by 2.5 degrees.  That tilt is a
parallax which is not there: on a calm film it makes the fringes' gain 10 % wrong.  Over a film with tilts of its own it
is told apart, to a ten-thousandth.

Convention: aspect is the logarithm of the page's height over that of its design, at one width, about the page's middle.
Source: derivative of each frame's homography along the page's y; an aspect is so small that its square does not matter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def lengthened_px(points_px: Array, plane_mm: Array) -> Array:
    """How points of a page move in the picture as the page's aspect grows, (T, N, 2) px per unit.

    Parameters: points_px (T, N, 2): pictures of plane_mm (N, 2), of mean 0, by one homography in each frame.
    Source: the homography by least squares (direct linear transformation), in coordinates of unit size.
    """
    size = float(np.abs(plane_mm).max())
    x, y = plane_mm.T / size
    middle = points_px.mean(axis=1, keepdims=True)
    reach = np.maximum(np.abs(points_px - middle).max(axis=(1, 2), keepdims=True), 1e-12)
    u, v = np.moveaxis((points_px - middle) / reach, 2, 0)
    one, none = np.ones_like(u), np.zeros_like(u)
    of_u = np.stack([x * one, y * one, one, none, none, none, -x * u, -y * u], axis=-1)
    of_v = np.stack([none, none, none, x * one, y * one, one, -x * v, -y * v], axis=-1)
    table, seen = np.concatenate([of_u, of_v], axis=1), np.concatenate([u, v], axis=1)
    mapped = (np.linalg.pinv(table) @ seen[..., None])[..., 0]
    depth = mapped[:, 6, None] * x + mapped[:, 7, None] * y + 1
    along = np.stack(
        [mapped[:, row, None] - picture * mapped[:, 7, None] for row, picture in ((1, u), (4, v))], axis=-1
    )
    return np.asarray(reach * along * (y / depth)[..., None])
