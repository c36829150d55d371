"""What a lens's radial distortion does to a registered page.

A page is registered as a plane seen in perspective, by a homography.  Of the distortion of its picture a homography
takes in the most of what it can, as if the page were tilted; the rest stays in the picture, unseen.  So not the points
are bent back by the whole distortion, but by the part that the homography has taken in.

Convention: x_distorted = x (1 + k1 r^2), x in units of the focal length from the picture's centre (Brown; OpenCV's k1);
negative for a barrel.
Source: the tangent space of homographies at the points' places, least squares over the points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def taken_in_px(points_px: Array, focal: float, centre: tuple[float, float]) -> Array:
    """Displacement (T, N, 2) px of the points for k1 = 1, as far as a homography of the N points takes it in."""
    place = (points_px - np.array(centre)) / focal
    bent = place * (place**2).sum(axis=-1, keepdims=True)
    local = place - place.mean(axis=1, keepdims=True)
    local /= np.maximum(np.abs(local).max(axis=(1, 2), keepdims=True), 1e-12)
    x, y = local[..., 0], local[..., 1]
    one, none = np.ones_like(x), np.zeros_like(x)
    along_x = np.stack([x, y, one, none, none, none, x * x, x * y], axis=-1)
    along_y = np.stack([none, none, none, x, y, one, x * y, y * y], axis=-1)
    table = np.concatenate([along_x, along_y], axis=1)
    wanted = np.concatenate([bent[..., 0], bent[..., 1]], axis=1)[..., None]
    # Four markers make the table's eight columns independent; a pseudo-inverse keeps odd boards from failing.
    fitted = (table @ (np.linalg.pinv(table) @ wanted))[..., 0]
    half = points_px.shape[1]
    return np.asarray(focal * np.stack([fitted[:, :half], fitted[:, half:]], axis=-1))
