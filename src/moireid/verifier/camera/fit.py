"""Where the camera was relative to the badge: focal length, shutter, distortion, the print, and one pose per frame.

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

from moireid.question import KnownCamera
from moireid.verifier.camera.fast_poses import lasting_error_px, slow_to_fast
from moireid.verifier.camera.map_search import unzoomed, zoom_path
from moireid.verifier.camera.plane_pose import PlanePoses
from moireid.verifier.camera.self_calibration import FilmWide
from moireid.verifier.limits import MAX_LASTING_PX
from moireid.verifier.measuring import FOCAL_RANGE_RATIO, LENS_MODEL_SD_SHARE

Array = NDArray[np.float64]
#: Change of the film's unknowns, in standard deviations, to measure their effect on the poses.
PROBE_SDS = 0.1
#: A zoom must take away so much of the error that lasts; a path that fits repeated pictures leaves it.  Set by hand.
TAKEN_SHARE = 0.5
#: The first path of a zoom is found with the camera of the whole film, each other one with that of the path before.
ROUNDS = 3
#: A focal length this near to the border of its search, as a share, is at it.
AT_LIMIT_SHARE = 0.01


@dataclass(frozen=True)
class CameraFit:
    """Camera centres (T, 3) page mm, and the parameters estimated over the film.

    reprojection_px: root mean square over corners, (T,); focal_sd_px: standard deviation, 0 where the focal length
    was given; shutter_s: time from first to last row; tangent_sd: error of the spread of the parallax coordinates along
    x and y from focal length and distortion, as a share; tangent_shape: what else these move the coordinates by, root
    mean square, which is no scale and lasts all film long; tangent_error: standard deviation of one frame's parallax
    coordinates along x and y, from the reprojection error; bend_k1, bend_sd: radial distortion;
    focal_at_limit: whether the search for the focal length ended at its border, so that it is no solution;
    axis_px: where the optical axis meets the picture, from its middle; aspect: width of a pixel over its height; axis
    and focal length are in px of the height; print_aspect: height over width of the print, over those of the design;
    lasting_px: error that one camera leaves over many frames (`fast_poses`); slow_to_fast: as there; log_zoom (T,):
    logarithm of the zoom within the film, over its mean; twist_per_m: of the page (`page_shape`); cuts (T,): frames
    before which the picture jumps; focal_span_px, shown: as in `FilmCamera`; parallel: whether the film does not
    exclude the longest lens, whose rays are next to parallel: a plane's tilts of either sign look alike to it.
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
    print_aspect: float = 1.0
    lasting_px: float = 0.0
    log_zoom: Array = field(default_factory=lambda: np.zeros(0))
    cuts: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    slow_to_fast: float = 0.0
    twist_per_m: float = 0.0
    tangent_shape: tuple[float, float] = (0.0, 0.0)
    focal_span_px: tuple[float, float] = (0.0, 0.0)
    shown: dict[str, float] = field(default_factory=dict)
    parallel: bool = False

    @property
    def lens_room(self) -> tuple[float, float]:
        """What a gain of 1 can be measured as, least and greatest, by another lens that the film does not exclude.

        Source: a parallax is a path in the picture over the focal length, so a longer lens makes the gain smaller.
        """
        near, far = self.focal_span_px
        return (self.focal_px / far, self.focal_px / near) if near > 0 else (1.0, 1.0)

    @property
    def zoom(self) -> float:
        """How far the picture is zoomed within the film, greatest over least; 1 where no zoom was found."""
        return math.exp(float(np.ptp(self.log_zoom))) if len(self.log_zoom) else 1.0


def fit_camera(
    points_px: Array,
    page_mm: Array,
    times_s: Array,
    image_px: tuple[int, int],
    *,
    camera: KnownCamera | None = None,
) -> CameraFit:
    """Poses of all frames, with focal length (unless given), rolling shutter and distortion estimated over the film.

    Parameters: points_px (T, N, 2) pictures of page_mm (N, 2); image_px: width, height; times_s (T,), rising; camera:
        what is known of it, which is not estimated.
    Convention: module docstring.
    Returns: CameraFit with T frames.
    Source: maximum a posteriori over reprojection error; the plane's two poses by `plane_pose`.
    """
    film, final, lasting_px, log_zoom = _solved(points_px, page_mm, times_s, image_px, camera)
    camera_mm, errors = _choose(final)
    tangent_sd, tangent_shape = _slow_errors(film)
    camera_mm[:, :2] += page_mm.mean(axis=0)
    return CameraFit(
        camera_mm,
        errors,
        film.focal,
        film.focal_sd,
        camera is not None,
        film.shutter_s,
        tangent_sd,
        film.tangent_error(final),
        film.bend_k1,
        film.bend_k1_sd,
        camera is None and _at_limit(film.focal / max(image_px)),
        (float(film.axis[0]) * max(image_px), float(film.axis[1]) * max(image_px)),
        math.exp(film.stretch),
        math.exp(film.print_aspect),
        lasting_px,
        log_zoom,
        film.cuts,
        slow_to_fast(film.residuals_px(final), times_s, np.cumsum(film.cuts)),
        film.twist,
        tangent_shape,
        film.focal_span_px,
        film.shown,
        film.parallel,
    )


def _solved(
    points_px: Array,
    page_mm: Array,
    times_s: Array,
    image_px: tuple[int, int],
    camera: KnownCamera | None,
) -> tuple[FilmWide, PlanePoses, float, Array]:
    """The film's camera, all poses, the error that lasts, px, and the zoom's logarithm, (T,), 0 where there is none.

    A zoom is looked for only where one camera leaves errors that last, and kept only where it explains them.
    """
    film = FilmWide(points_px, page_mm, times_s, image_px, camera).solve()
    poses, none = film.all_poses(), np.zeros(len(points_px))
    lasting, noise = lasting_error_px(film.residuals_px(poses), times_s, np.cumsum(film.cuts))
    if camera is not None or lasting <= MAX_LASTING_PX:
        return film, poses, lasting, none
    # A homography has two residuals more than a pose, which share the noise of all its points.
    frame_px = noise * math.sqrt(len(page_mm) / 2)
    middle = ((image_px[0] - 1) / 2, (image_px[1] - 1) / 2)
    best, log_zoom = film, none
    for _ in range(ROUNDS):

        def residual_of(path: Array, camera: FilmWide = best) -> tuple[Array, Array]:
            return camera.of_points(unzoomed(points_px, path, middle)).zoom_residual()

        path = zoom_path(residual_of, best.chosen, times_s, film.cuts, frame_px)
        if path is None:
            return film, poses, lasting, none
        log_zoom = path
        best = FilmWide(unzoomed(points_px, log_zoom, middle), page_mm, times_s, image_px).solve()
    again = best.all_poses()
    left, _ = lasting_error_px(best.residuals_px(again), times_s, np.cumsum(best.cuts))
    kept = left <= min(MAX_LASTING_PX, (1 - TAKEN_SHARE) * lasting)
    return (best, again, left, log_zoom) if kept else (film, poses, lasting, none)


def _slow_errors(film: FilmWide) -> tuple[tuple[float, float], tuple[float, float]]:
    """`tangent_sd` and `tangent_shape`, as in `CameraFit`.

    Source: propagation of the covariance along its principal axes.  One unknown at a time will not do: the aspects of
        picture and print mostly cancel each other, and each by itself bends the poses.
    """
    sd = np.sqrt(np.diag(film.covariance))
    known = np.where(sd > 0, sd, 1.0)
    sizes, axes = np.linalg.eigh(film.covariance / np.outer(known, known))
    steps = PROBE_SDS * known * (axes * np.sqrt(np.maximum(sizes, 0.0))).T
    here, _ = _choose(film.moved(np.zeros(len(sd))))
    moved = [_stretch(here, _choose(film.moved(step))[0]) for step in steps if np.any(step)]
    (along_x, shape_x), (along_y, shape_y) = np.linalg.norm(moved, axis=0) / PROBE_SDS if moved else np.zeros((2, 2))
    scale = math.hypot(along_x, LENS_MODEL_SD_SHARE), math.hypot(along_y, LENS_MODEL_SD_SHARE)
    return scale, (float(shape_x), float(shape_y))


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
    if len(sure) and np.any(doubtful):
        tangents, unsure = centres[..., :2] / centres[..., 2:], np.flatnonzero(doubtful)
        kept = tangents[sure, better[sure]]
        expected = np.column_stack([np.interp(unsure, sure, column) for column in kept.T])
        apart = tangents[unsure] - expected[:, None]
        better[unsure] = np.hypot(apart[..., 0], apart[..., 1]).argmin(axis=1)
    return centres[frames, better], poses.error_px[frames, better]


def _stretch(camera: Array, other: Array) -> Array:
    """Relative change of the spread of tangents from this path to the other, signed, and the root mean square of what
    else changes; (2, 2), along x and y.
    """
    found = np.zeros((2, 2))
    for axis in (0, 1):
        here, there = (c[:, axis] / c[:, 2] - np.mean(c[:, axis] / c[:, 2]) for c in (camera, other))
        power = float(here @ here)
        share = float(here @ (there - here)) / power if power > 0 else 0.0
        found[axis] = share, np.std(there - (1 + share) * here)
    return found
