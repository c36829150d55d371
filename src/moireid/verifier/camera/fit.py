"""Where the camera was relative to the badge: focal length, rolling shutter, distortion, and one pose per frame.

The tilt of a plane shows only in small second differences of its corners, so the pose is the weakest part of the
method.  Three things make it good enough: registered corners; focal length, shutter time and distortion estimated over
the whole film; and smoothing at the end.

Convention: page millimetres, x right, y down, z into the page; the camera's z is negative.  The parallax coordinate
of the page is u = Cx / |Cz| with Cx counted from the point looked at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.plane_pose import PlanePoses, tangent_error
from moireid.verifier.camera.self_calibration import FilmWide
from moireid.verifier.limits import FOCAL_RANGE_RATIO

Array = NDArray[np.float64]
#: Change of the focal length's logarithm, and of the distortion, to measure their effect on the poses.
PROBE = 0.003
#: A focal length this near to the border of its search, as a share, is at it.
AT_LIMIT_SHARE = 0.01


@dataclass(frozen=True)
class CameraFit:
    """Camera centres (T, 3) page mm, and the parameters estimated over the film.

    reprojection_px: root mean square over corners, (T,); focal_sd_px: standard deviation, 0 where the focal length
    was given; shutter_s: time from first to last row; tangent_sd: error of the spread of the parallax coordinates along
    x and y from focal length and distortion, as a share; tangent_error: standard deviation of one frame's parallax
    coordinates along x and y, from the reprojection error; bend_k1, bend_sd: radial distortion;
    focal_at_limit: whether the search for the focal length ended at its border, so that it is no solution;
    axis_px: where the optical axis meets the picture, from its middle; aspect: width of a pixel over its height; axis
    and focal length are in px of the height; lasting_px: error that one camera leaves over many frames (`one_camera`);
    cuts (T,): frames before which the picture jumps.
    """

    camera_mm: Array
    reprojection_px: Array
    focal_px: float
    focal_sd_px: float
    focal_given: bool
    shutter_s: float
    tangent_sd: tuple[float, float]
    tangent_error: tuple[float, float]
    bend_k1: float = 0.0
    bend_sd: float = 0.0
    focal_at_limit: bool = False
    axis_px: tuple[float, float] = (0.0, 0.0)
    aspect: float = 1.0
    lasting_px: float = 0.0
    cuts: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))


def fit_camera(
    points_px: Array,
    page_mm: Array,
    times_s: Array,
    image_px: tuple[int, int],
    *,
    focal_px: float | None = None,
) -> CameraFit:
    """Poses of all frames, with focal length (unless given), rolling shutter and distortion estimated over the film.

    Parameters: points_px (T, N, 2) pictures of page_mm (N, 2); image_px: width, height; times_s (T,), rising.
    Convention: module docstring.
    Returns: CameraFit with T frames.
    Source: maximum a posteriori over reprojection error; the plane's two poses by `plane_pose`.
    """
    film = FilmWide(points_px, page_mm, times_s, image_px, focal_px).solve()
    final = film.all_poses()
    camera, errors = _choose(final)
    # Errors of focal length and distortion are correlated: one mostly cancels the other.
    probes = PROBE * np.eye(6)
    stretch = np.column_stack(
        [np.array(_stretch(camera, _choose(film.moved(final, off))[0])) / off.sum() for off in probes]
    )
    tangent_sd = np.sqrt(np.maximum(np.diag(stretch @ film.covariance @ stretch.T), 0))
    camera[:, :2] += page_mm.mean(axis=0)
    return CameraFit(
        camera,
        errors,
        film.focal,
        film.focal_sd,
        focal_px is not None,
        film.shutter_s,
        (float(tangent_sd[0]), float(tangent_sd[1])),
        tangent_error(final, film.plane, film.focal),
        film.bend_k1,
        film.bend_k1_sd,
        focal_px is None and _at_limit(film.focal / max(image_px)),
        (float(film.axis[0]) * max(image_px), float(film.axis[1]) * max(image_px)),
        math.exp(film.stretch),
        film.lasting_error_px(final),
        film.cuts,
    )


def _at_limit(ratio: float) -> bool:
    least, most = FOCAL_RANGE_RATIO
    return not least * (1 + AT_LIMIT_SHARE) < ratio < most * (1 - AT_LIMIT_SHARE)


def _choose(poses: PlanePoses) -> tuple[Array, Array]:
    """Camera centres (T, 3) and errors (T,); if both poses fit alike, the one nearer to its neighbours."""
    centres, frames = poses.camera, np.arange(len(poses.error_px))
    better = poses.error_px.argmin(axis=1)
    best, other = poses.error_px[frames, better], poses.error_px[frames, 1 - better]
    # For two redundant residuals, twice the error is five standard deviations away, which excludes chance.
    doubtful = other < 2.0 * best
    sure = np.flatnonzero(~doubtful)
    if len(sure):
        kept = centres[sure, better[sure]]
        for frame in np.flatnonzero(doubtful):
            expected = [np.interp(frame, sure, kept[:, k] / kept[:, 2]) for k in (0, 1)]
            tangents = centres[frame, :, :2] / centres[frame, :, 2:]
            better[frame] = int(np.argmin(np.hypot(*(tangents - expected).T)))
    return centres[frames, better], poses.error_px[frames, better]


def _stretch(camera: Array, other: Array) -> tuple[float, float]:
    """Relative change of the spread of tangents from this path to the other, along x and y; signed."""
    shares = []
    for axis in (0, 1):
        here, there = (c[:, axis] / c[:, 2] - np.mean(c[:, axis] / c[:, 2]) for c in (camera, other))
        power = float(here @ here)
        shares.append(float(here @ (there - here)) / power if power > 0 else 0.0)
    return shares[0], shares[1]
