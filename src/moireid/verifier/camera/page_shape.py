"""A page that is not flat: what its twist does to registered points, and what remains unknown of the gain.

A page that is worn or was printed on thin card bends.  Its twist shows in a film, as it lifts two corners of four: no
pose explains that.  Its bows along x and y hardly show, because they look like another focal length.  Card does not
stretch, so that the product of its bows is the square of its twist: of a page that is bent about an unknown axis, each
is about as large as the twist, of unknown sign.

A page is registered by a homography, which absorbs a part of what the shape does; points are corrected by that part
(`distortion.TakenIn`).

Convention: a twist t, 1/m, lifts the page at (x, y), mm from the middle of its markers, by t x y / 1000 mm away from
    the camera; bows a and b by (a x^2 + b y^2) / 2000 mm.  A page that is bent to a radius R about an axis at an angle
    c from y has t = sin(2 c) / (2 R).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.frames import own_rect
from moireid.optics import beat_frequency_per_mm
from moireid.verifier.camera.distortion import TakenIn
from moireid.verifier.camera.plane_pose import PlanePoses

Array = NDArray[np.float64]


def lifted_px(
    plane: Array, poses: PlanePoses, focal: float, absorbed: TakenIn, frames: NDArray[np.int64] | slice
) -> Array:
    """By how much a twist of 1/m moves the points, as far as homographies absorb it, (T, N, 2) px.

    Parameters: plane (N, 3): the points, mm; poses: of these frames; focal: px; absorbed: of all frames' points.
    Source: derivative of the perspective by the height, at the better pose.
    """
    every, better = np.arange(len(poses.error_px)), poses.error_px.argmin(axis=1)
    turn = poses.rotation[every, better]
    local = plane @ turn.swapaxes(-1, -2) + poses.translation[every, better][:, None]
    seen, normal = local[..., :2] / local[..., 2:], turn[:, None, :, 2]
    by_height = focal * (normal[..., :2] - seen * normal[..., 2:]) / local[..., 2:]
    return absorbed.absorbed(by_height * plane[:, :1] * plane[:, 1:2] / 1000.0, frames)


def gain_sd_share(badge: Badge, grating: Grating, page_mm: Array, twist_per_m: float) -> float:
    """Error of the gain from the unknown bows of a page with this twist, as a share.

    Parameters: page_mm (N, 2): the markers' corners; twist_per_m: 0 for a flat page.
    Source: fringes in a plane that is d farther away than the markers' plane move by f_b d turns more for each unit of
        parallax, of g / (n p_r) turns; d is that of a bow, over the grating, less that over the markers.
    """
    markers = page_mm - page_mm.mean(axis=0)
    low, top, high, bottom = own_rect(grating.axis, grating.rect_mm)
    corners = badge.frame_of(grating).on_page(np.array([[low, top], [high, bottom]])) - page_mm.mean(axis=0)
    # The mean square over a span from p to q is (p^2 + p q + q^2) / 3.
    inside = (corners[0] ** 2 + corners[0] * corners[1] + corners[1] ** 2) / 3
    apart_mm = math.hypot(*(twist_per_m * ((markers**2).mean(axis=0) - inside) / 2000.0))
    beat = abs(beat_frequency_per_mm(grating.pitch_mm, badge.lens.pitch_mm))
    return apart_mm * float(beat) * grating.pitch_mm * badge.lens.refractive_index / badge.lens.thickness_mm
