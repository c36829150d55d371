"""The camera of a film: the nine figures that are the same in all its frames, and what they leave of the page's points.

Convention: as `fit`; distortion is kept in units of the usual focal length, and returned in units of the found one;
    unknowns in the order of `FilmCamera`.
"""

from __future__ import annotations

import copy
import math
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from moireid.question import KnownCamera
from moireid.verifier.camera.distortion import MIDDLE, TakenIn
from moireid.verifier.camera.fast_poses import NearPoses
from moireid.verifier.camera.map_search import Unknown
from moireid.verifier.camera.page_shape import lifted_px
from moireid.verifier.camera.page_speed import jumps, lengthened_px, velocity_px_s
from moireid.verifier.camera.plane_pose import (
    PlanePoses,
    moved_poses,
    start_poses,
    tangent_error,
)
from moireid.verifier.limits import GAIN_REJECTED_SDS, LENS_RATIOS
from moireid.verifier.measuring import (
    AXIS_MAX_SHARE,
    AXIS_PRIOR_SD_SHARE,
    DISTORTION_MAX,
    DISTORTION_PRIOR_SD,
    FOCAL_PRIOR_RATIO,
    FOCAL_PRIOR_SD_LOG,
    FOCAL_RANGE_RATIO,
    PRINT_ASPECT_MAX_LOG,
    PRINT_ASPECT_PRIOR_SD_LOG,
    SHUTTER_MAX_S,
    SHUTTER_PRIOR_S,
    SHUTTER_PRIOR_SD_S,
    STRETCH_MAX_LOG,
    STRETCH_PRIOR_SD_LOG,
    TWIST_MAX_PER_M,
    TWIST_PRIOR_SD_PER_M,
)
from moireid.verifier.series import spread_out

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
#: Within this change of the focal length's logarithm, refined poses are still near.
NEARBY_ZOOM = 0.15
SHUTTER = Unknown(0.0, SHUTTER_MAX_S, SHUTTER_PRIOR_S, SHUTTER_PRIOR_SD_S, 0.003)
BENDS = [
    Unknown(-most, most, 0.0, sd, step, heavy=True)
    for most, sd, step in zip(DISTORTION_MAX, DISTORTION_PRIOR_SD, (0.03, 0.1), strict=True)
]
ASIDE = Unknown(-AXIS_MAX_SHARE, AXIS_MAX_SHARE, 0.0, AXIS_PRIOR_SD_SHARE, 0.03, heavy=True)
STRETCH = Unknown(-STRETCH_MAX_LOG, STRETCH_MAX_LOG, 0.0, STRETCH_PRIOR_SD_LOG, 0.005, heavy=True)
PRINT = Unknown(-PRINT_ASPECT_MAX_LOG, PRINT_ASPECT_MAX_LOG, 0.0, PRINT_ASPECT_PRIOR_SD_LOG, 0.001, heavy=True)
TWIST = Unknown(-TWIST_MAX_PER_M, TWIST_MAX_PER_M, 0.0, TWIST_PRIOR_SD_PER_M, 0.05, heavy=True)
#: Where a twist moves the points depends on the poses, which depend on it.
TWIST_ROUNDS = 2
#: The unknowns by name, in their order.
FIGURES = ("focal", "shutter", "bend", "bend_far", "axis_x", "axis_y", "aspect", "print_aspect", "twist")
#: Places of the distortion and of the axis among the unknowns.
BEND_AT, AXIS_AT = slice(2, 4), slice(4, 6)
#: Share of an unknown's step used for finite differences.
PROBE = 0.05
#: A film adds at least this share to what is known of its focal length beforehand, or it excludes no lens: where in the
#: long valley the search stopped would decide.  Derived: of 1 % one standard deviation is a factor of 4.5.
LEAST_ADDED_SHARE = 0.01
#: Most frames used to estimate the film-wide unknowns.
SOLVE_FRAMES = 300
#: Most frames from which each of them is first estimated alone, as a start of the joint search over all of those.
START_FRAMES = 100
#: A page that moved by less, px, was not filmed again: registration of one picture repeats within 0.003 px, and noise
#: moves it by 0.02 px or more.  Fewest pictures that are enough.
SAME_PX, LEAST_PICTURES = 0.01, 8


def different_pictures(points_px: Array) -> Numbers:
    """Frames that show another picture than those before them, rising; all frames, if these are too few.

    A call that freezes, or a coder, repeats a picture.  Were most frames one picture, the unknowns would fit that one
    without error, and the misfit would take all others for outliers.
    Parameters: points_px (T, N, 2).
    """
    moved_px = np.sqrt((np.diff(points_px, axis=0) ** 2).sum(axis=2).mean(axis=1))
    path = np.concatenate([[0.0], np.cumsum(moved_px)])
    _, first = np.unique((path / SAME_PX).astype(np.int64), return_index=True)
    return np.asarray(first if len(first) >= LEAST_PICTURES else np.arange(len(points_px)), np.int64)


class FilmCamera:
    """The film-wide unknowns of registered pages.

    focal: px; shutter_s: time from first to last row; bend (2,): distortion in units of the usual focal length; axis
    (2,): place of the optical axis; stretch: logarithm of a pixel's width over its height; print_aspect: logarithm of
    the page's height over that of its design, at one width; twist: as `page_shape`; covariance (9, 9): of the
    focal length's logarithm, shutter, distortion, axis, stretch, print aspect and twist; 0 for what was given or is
    fixed.
    """

    def __init__(
        self,
        points_px: Array,
        page_mm: Array,
        times_s: Array,
        image_px: tuple[int, int],
        camera: KnownCamera | None = None,
    ) -> None:
        """Parameters: as `fit.fit_camera`."""
        self._long_side, self._given = max(image_px), camera is not None
        self._known = camera is not None and camera.calibrated
        self._usual = FOCAL_PRIOR_RATIO * self._long_side
        self._guess = camera.focal_px(self._long_side) if camera is not None else self._usual
        self._points, self._times = points_px, times_s
        self._middle = (image_px[0] - 1) / 2.0, (image_px[1] - 1) / 2.0
        #: Where the optical axis meets the picture, from its middle, in long sides of the picture.
        self.axis = np.zeros(2)
        #: Whether it is taken to be in the middle, as the film does not show it.
        self._centred = False
        #: Logarithm of a pixel's width over its height; points are made square with it.
        self.stretch, self._stretched = 0.0, False
        self.print_aspect = 0.0
        #: Twist of a page that is seen not to be flat, 1/m, and what 1/m moves the points by (`page_shape`).
        self.twist, self._twisted, self._lifted = 0.0, False, np.zeros_like(points_px)
        #: Whether the focal length is that of a steady path; and the distortion beyond which a search is given up.
        self._steadied, self._most_bend = False, math.inf
        self.plane = np.column_stack([page_mm - page_mm.mean(axis=0), np.zeros(len(page_mm))])
        #: Frames before which the picture jumps, (T,).
        self.cuts = jumps(points_px / self._guess, times_s)
        self._velocity = velocity_px_s(points_px, times_s, self.cuts)
        apart = (points_px - points_px.mean(axis=1, keepdims=True)) / np.array(image_px, float)
        # Programs rotate films, so the shutter may run down, right, up or left.
        self._directions: list[Array] = [apart[..., 1:2], apart[..., 0:1], -apart[..., 1:2], -apart[..., 0:1]]
        self._rows = self._directions[0]
        pictures = different_pictures(points_px)
        self._chosen: Numbers = pictures[spread_out(len(pictures), SOLVE_FRAMES)]
        self._bends = TakenIn(points_px, self._usual)
        self._longer = lengthened_px(points_px, self.plane[:, :2])
        self.focal, self.shutter_s, self.bend = float(self._guess), SHUTTER_PRIOR_S, np.zeros(2)
        if camera is not None and camera.calibrated:
            self._take(camera)
        start_px = self._flat(self._chosen) if self._known else points_px[self._chosen]
        self._start = start_poses(self.plane, start_px, self._guess, self._centre)
        self._start_focal, self._near = float(self._guess), NearPoses(self.plane, self._start)
        #: What a tremor that hides between the frames moves a row that is a picture's height away, over the noise.
        self._hidden_sds = 0.0
        #: In how many of the chosen frames one error is seen.
        self._repeats = 1.0
        self.covariance = np.zeros((9, 9))

    def _take(self, known: KnownCamera) -> None:
        """Start from a calibrated camera; what is known of it is not solved."""
        square = (self._usual / self.focal) ** 2
        self.bend = np.array([known.k1 * square + MIDDLE * known.k2 * square**2, known.k2 * square**2])
        self.stretch = math.log(known.aspect)
        self.axis = np.array(known.axis) / [known.aspect, 1.0]

    @property
    def _centre(self) -> tuple[float, float]:
        return self._placed(self.axis)

    def _placed(self, axis: Array) -> tuple[float, float]:
        return self._middle[0] + float(axis[0]) * self._long_side, self._middle[1] + float(axis[1]) * self._long_side

    @property
    def chosen(self) -> NDArray[np.int64]:
        """The frames from which the unknowns are estimated."""
        return self._chosen

    @property
    def focal_sd(self) -> float:
        """Standard deviation of the focal length, px."""
        return self.focal * math.sqrt(self.covariance[0, 0])

    @property
    def focal_span_px(self) -> tuple[float, float]:
        """Focal lengths that the film itself does not exclude, least and greatest, px, whatever the prior says.

        Notes
        -----
        Source: the posterior less the prior is what the film shows, with three standard deviations to either side; in
            one over the focal length, as perspective grows with that.  Where the film shows nothing, all lenses.
        """
        if self._given:
            return self.focal, self.focal
        usual, found = 1 / FOCAL_PRIOR_RATIO, self._long_side / self.focal
        prior, both = FOCAL_PRIOR_SD_LOG**-2, 1 / max(self.covariance[0, 0], 1e-12)
        own = max(both - prior, LEAST_ADDED_SHARE * prior)
        middle = found * (1 + prior / own * math.log(found / usual))
        reach = GAIN_REJECTED_SDS * found / math.sqrt(own)
        least, most = LENS_RATIOS
        far = np.clip(middle - reach, 1 / most, found)
        near = np.clip(middle + reach, found, max(1 / least, found))
        return self._long_side / float(near), self._long_side / float(far)

    @property
    def parallel(self) -> bool:
        """Whether the film does not exclude the longest lens, whose rays are next to parallel."""
        return not self._given and self.focal_span_px[1] >= 0.99 * LENS_RATIOS[1] * self._long_side

    @property
    def shown(self) -> dict[str, float]:
        """Of each figure that was solved, the share of its information that is the film's, and not the prior's.

        Source: 1 less the posterior variance over that of the prior.
        """
        sd = np.sqrt(np.diag(self.covariance))
        return {
            name: float(np.clip(1 - (sd[k] / one.prior_sd) ** 2, 0.0, 1.0))
            for k, (name, one) in enumerate(zip(FIGURES, self._unknowns(), strict=True))
            if sd[k] > 0
        }

    @property
    def bend_k1(self) -> float:
        """Radial distortion in units of the focal length found (OpenCV's k1)."""
        return float(self.bend[0] - MIDDLE * self.bend[1]) * (self.focal / self._usual) ** 2

    @property
    def bend_k1_sd(self) -> float:
        """Standard deviation of `bend_k1`."""
        apart = np.array([1.0, -MIDDLE])
        variance = float(apart @ self.covariance[BEND_AT, BEND_AT] @ apart)
        return math.sqrt(variance) * (self.focal / self._usual) ** 2

    def _lift(self, frames: NDArray[np.int64] | slice, poses: PlanePoses) -> None:
        """Compute what a twist does to these frames' points, at their poses."""
        self._lifted = self._lifted.copy()
        self._lifted[frames] = lifted_px(self.plane, poses, self.focal, self._bends, frames)

    def _apart(self, frames: NDArray[np.int64] | slice) -> Array:
        """Rows of the points from those of the page's middle, in picture heights, (T, N)."""
        rows = self._rows[frames][..., 0]
        return np.asarray(rows - rows.mean(axis=1, keepdims=True))

    def _slack(self, frames: NDArray[np.int64] | slice) -> Array | None:
        """The slack of these frames' rows, as `plane_pose` has it; None without any."""
        if not self._hidden_sds:
            return None
        along = self._hidden_sds * self._apart(frames)
        return np.asarray(along / np.sqrt(1 + (along**2).sum(axis=1, keepdims=True)))

    def tangent_error(self, poses: PlanePoses) -> tuple[float, float]:
        """As `plane_pose.tangent_error`, of the poses of all frames."""
        return tangent_error(poses, self.plane, self.focal, self._slack(slice(None)))

    def _unknowns(self) -> list[Unknown]:
        """All that a joint search may solve: focal length, shutter, distortion, axis x and y, stretch, print aspect."""
        return [self._zoom(), SHUTTER, *BENDS, ASIDE, ASIDE, STRETCH, PRINT, TWIST]

    def _at(self) -> Array:
        """The unknowns as they are estimated now, (9,)."""
        camera = (math.log(self.focal), self.shutter_s, *self.bend, *self.axis, self.stretch)
        return np.array([*camera, self.print_aspect, self.twist])

    def _zoom(self) -> Unknown:
        """The focal length's logarithm."""
        least, most = (math.log(ratio * self._long_side) for ratio in FOCAL_RANGE_RATIO)
        return Unknown(least, most, math.log(self._guess), FOCAL_PRIOR_SD_LOG, 0.06)

    def _residuals(self, before: Array, free: list[int], places: Array) -> Array:
        """Residuals of the chosen frames, (T, 2 N) px, with these places of the free unknowns."""
        points, focal, centre = self._seen(before, free, places)
        return self._near.residuals_px(points, focal / self._start_focal, focal, centre)

    def _slopes(self, before: Array, free: list[int]) -> Array:
        """Derivatives of `_residuals` by the free unknowns at the settled poses, (n, T, 2 N) px.

        Source: variable projection (Kaufman, A variable projection method for solving separable nonlinear least squares
            problems, 1975): how the points move, less what the poses follow.
        """
        points, focal, centre = self._seen(before, free, before[free])
        left = self._near.residuals_px(points, focal / self._start_focal, focal, centre)
        slopes = []
        for k in free:
            # Towards zero, so that finite differences never leave the bounds.
            probe = PROBE * self._unknowns()[k].step * (-1 if before[k] > 0 else 1)
            there, other_focal, other = self._seen(before, [k], before[[k]] + probe)
            # A longer focal length is as points nearer to the axis, in a picture that is enlarged.
            moved = (there - np.array(other)) * (focal / other_focal) - (points - np.array(centre))
            slopes.append((self._near.following_px(moved) + left * (other_focal / focal - 1)) / probe)
        return np.stack(slopes)

    def _seen(self, before: Array, free: list[int], places: Array) -> tuple[Array, float, tuple[float, float]]:
        """Points of the chosen frames, focal length and centre, with these places of the free unknowns."""
        at = before.copy()
        at[free] = places
        points = self._flat(
            self._chosen,
            shutter_s=float(at[1]),
            bend=at[BEND_AT],
            axis=at[AXIS_AT],
            stretch=float(at[6]),
            print_aspect=float(at[7]),
            twist=float(at[8]),
        )
        return points, math.exp(at[0]), self._placed(at[AXIS_AT])

    def all_poses(self) -> PlanePoses:
        """Poses of all frames with the estimated parameters."""
        every = slice(None)
        poses = start_poses(self.plane, self._flat(every), self.focal, self._centre, self._slack(every))
        for _ in range(TWIST_ROUNDS if self._twisted else 0):
            self._lift(every, poses)
            poses = start_poses(self.plane, self._flat(every), self.focal, self._centre, self._slack(every))
        return poses

    def residuals_px(self, poses: PlanePoses) -> Array:
        """What the poses of all frames leave, (T, 2 N) px; in full, as a zoom would hide behind the rows' slack."""
        return poses.residuals_px(self.plane, self._flat(slice(None)), self.focal, self._centre)

    def zoom_residual(self) -> tuple[Array, Array]:
        """The residual of the chosen frames along a zoom's direction, px, and its slope, (n,) each.

        Convention: residual = slope times (the zoom's logarithm that is missing).
        """
        points = self._flat(self._chosen)
        left = self._near.residuals_px(points, 1.0, self.focal, self._centre)
        # A zoom's logarithm that is taken away moves each point towards the middle by its distance from there.
        slopes = self._near.following_px(np.array(self._middle) - points)
        size = np.linalg.norm(slopes, axis=1)
        return -(slopes * left).sum(axis=1) / np.maximum(size, 1e-12), size

    def of_points(self, points_px: Array) -> Self:
        """The same camera for other points (T, N, 2)."""
        film = copy.copy(self)
        film._points, film._velocity = points_px, velocity_px_s(points_px, self._times, self.cuts)
        film._bends = TakenIn(points_px, self._usual)
        film._longer = lengthened_px(points_px, self.plane[:, :2])
        slack = self._slack(self._chosen)
        film._start = start_poses(self.plane, film._flat(self._chosen), self.focal, self._centre, slack)
        film._start_focal, film._near = self.focal, NearPoses(self.plane, film._start, slack)
        return film

    def of_fewer(self) -> Self:
        """The same camera on `START_FRAMES` of the chosen frames, near their poses."""
        film = copy.copy(self)
        some = spread_out(len(self._chosen), START_FRAMES)
        film._chosen = self._chosen[some]
        film._start = PlanePoses(*(part[some] for part in vars(self._start).values()))
        film._near = NearPoses(self.plane, film._start, film._slack(film._chosen))
        return film

    def moved(self, off: Array) -> PlanePoses:
        """The chosen frames' poses if the parameters of `covariance`, in its order, changed by `off`."""
        focal = self.focal * math.exp(off[0])
        points = self._flat(
            self._chosen,
            shutter_s=self.shutter_s + off[1],
            bend=self.bend + off[BEND_AT],
            axis=self.axis + off[AXIS_AT],
            stretch=self.stretch + off[6],
            print_aspect=self.print_aspect + off[7],
            twist=self.twist + off[8],
        )
        return self._moved_poses(points, focal, self._placed(self.axis + off[AXIS_AT]))

    def _moved_poses(self, points: Array, focal: float, centre: tuple[float, float]) -> PlanePoses:
        """The chosen frames' poses for other points or another camera, from those of the last settling."""
        zoom, slack = focal / self._start_focal, self._slack(self._chosen)
        return moved_poses(self._start, self.plane, points, zoom, focal, centre, slack=slack)

    def _flat(
        self,
        frames: NDArray[np.int64] | slice,
        *,
        shutter_s: float | None = None,
        bend: Array | None = None,
        axis: Array | None = None,
        stretch: float | None = None,
        print_aspect: float | None = None,
        twist: float | None = None,
    ) -> Array:
        """Points as a pinhole camera without a rolling shutter, with square pixels, sees them of a page as designed."""
        seconds, bent = (self.shutter_s if shutter_s is None else shutter_s), (self.bend if bend is None else bend)
        rolled = self._velocity[frames] * self._rows[frames] * seconds
        centre = self._placed(self.axis if axis is None else axis)
        points = self._points[frames] - self._bends.px(bent, centre, frames) - rolled
        points -= self._longer[frames] * (self.print_aspect if print_aspect is None else print_aspect)
        if twist is not None or self._twisted:
            points -= self._lifted[frames] * (self.twist if twist is None else twist)
        points[..., 0] += (points[..., 0] - self._middle[0]) * math.expm1(
            -(self.stretch if stretch is None else stretch)
        )
        return np.asarray(points)

    def _errors(self, *, log_focal: float | None = None, **others: Any) -> Array:
        """Reprojection errors (T,) px of the chosen frames; others: as `_flat`.

        What is not given keeps its present estimate.
        """
        focal = self.focal if log_focal is None else math.exp(log_focal)
        points = self._flat(self._chosen, **others)
        zoom = focal / self._start_focal
        if abs(math.log(zoom)) > NEARBY_ZOOM:
            return self._moved_poses(points, focal, self._centre).least_error_px
        return self._near.least_error_px(points, zoom, focal, self._centre)

    def _settle(self) -> None:
        """Refine the poses at the present estimates, as the start of the next search."""
        self._start = self._moved_poses(self._flat(self._chosen), self.focal, self._centre)
        if self._twisted:
            self._lift(self._chosen, self._start)
            self._start = self._moved_poses(self._flat(self._chosen), self.focal, self._centre)
        self._start_focal, self._near = self.focal, NearPoses(self.plane, self._start, self._slack(self._chosen))
