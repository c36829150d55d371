"""What is the same in all frames of a film: focal length, rolling-shutter time, and radial distortion.

1. In which direction does the shutter run through the picture?  Tested at its usual time.
2. Shutter time alone, then focal length alone, each from its prior.
3. All together.
4. If the focal length is far from its prior, estimate it again on a steady camera path (`steady_path`).
Convention: as `fit`; distortion is estimated in units of the guessed focal length, and returned in units of the found
    one.
Source: maximum a posteriori over reprojection error.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import maximum_filter1d, median_filter

from moireid.verifier.camera.distortion import TakenIn
from moireid.verifier.camera.fast_poses import NearPoses
from moireid.verifier.camera.map_search import Unknown, minimise, minimise_together, posterior
from moireid.verifier.camera.plane_pose import PlanePoses, moved_poses, start_poses
from moireid.verifier.camera.smoothing import GAP_S, unbroken
from moireid.verifier.camera.steady_path import SPARE, steady_errors_px
from moireid.verifier.camera.stretches import AROUND
from moireid.verifier.limits import (
    DISTORTION_MAX_K1,
    DISTORTION_PRIOR_SD_K1,
    FOCAL_FAR_SDS,
    FOCAL_PRIOR_RATIO,
    FOCAL_PRIOR_SD_LOG,
    FOCAL_RANGE_RATIO,
    JUMP_NOISE_SDS,
    MAX_PICTURE_JUMP,
    SHUTTER_MAX_S,
    SHUTTER_PRIOR_S,
    SHUTTER_PRIOR_SD_S,
)

Array = NDArray[np.float64]
#: A joint search moves by at most this many steps from settled poses, and then starts again from its result; until it
#: moves by less than this share of a step; most repetitions.
NEARBY_STEPS, SETTLED, MOST_SETTLED = 2.0, 0.2, 6
#: Within this change of the focal length's logarithm, refined poses are still near.
NEARBY_ZOOM = 0.15
#: Most frames used to estimate the film-wide unknowns.
SOLVE_FRAMES = 300


class FilmWide:
    """The film-wide unknowns of registered pages.

    focal: px; shutter_s: time from first to last row; bend: distortion in units of the guessed focal length; covariance
    (2, 2): of the focal length's logarithm (0 if it was given) and the distortion.
    """

    def __init__(
        self,
        points_px: Array,
        page_mm: Array,
        times_s: Array,
        image_px: tuple[int, int],
        focal_px: float | None,
    ) -> None:
        """Parameters: as `fit.fit_camera`."""
        self._points, self._times = points_px, times_s
        self._centre = ((image_px[0] - 1) / 2.0, (image_px[1] - 1) / 2.0)
        self.plane = np.column_stack([page_mm - page_mm.mean(axis=0), np.zeros(len(page_mm))])
        self._velocity = _velocity_px_s(points_px, times_s, focal_px or FOCAL_PRIOR_RATIO * max(image_px))
        apart = (points_px - points_px.mean(axis=1, keepdims=True)) / np.array(image_px, float)
        # Programs rotate films, so the shutter may run down, right, up or left.
        self._directions: list[Array] = [apart[..., 1:2], apart[..., 0:1], -apart[..., 1:2], -apart[..., 0:1]]
        self._rows = self._directions[0]
        self._chosen = np.unique(np.linspace(0, len(points_px) - 1, min(SOLVE_FRAMES, len(points_px))).astype(int))
        self._long_side, self._given = max(image_px), focal_px is not None
        self._guess = focal_px or FOCAL_PRIOR_RATIO * max(image_px)
        self._bends = TakenIn(points_px, self._guess, self._centre)
        self._start = start_poses(self.plane, points_px[self._chosen], self._guess, self._centre)
        self._start_focal, self._near = float(self._guess), NearPoses(self.plane, self._start)
        self.focal, self.shutter_s, self.bend = float(self._guess), SHUTTER_PRIOR_S, 0.0
        self.covariance = np.zeros((2, 2))

    @property
    def focal_sd(self) -> float:
        """Standard deviation of the focal length, px."""
        return self.focal * math.sqrt(self.covariance[0, 0])

    @property
    def bend_k1(self) -> float:
        """Radial distortion in units of the focal length found (OpenCV's k1)."""
        return self.bend * (self.focal / self._guess) ** 2

    @property
    def bend_k1_sd(self) -> float:
        """Standard deviation of `bend_k1`."""
        return math.sqrt(self.covariance[1, 1]) * (self.focal / self._guess) ** 2

    def solve(self) -> None:
        """Steps 1 to 4."""
        shutter = (0.0, SHUTTER_MAX_S, SHUTTER_PRIOR_S, SHUTTER_PRIOR_SD_S)
        middle = math.log(self._guess)
        least, most = (math.log(ratio * self._long_side) for ratio in FOCAL_RANGE_RATIO)
        zoom = (least, most, middle, FOCAL_PRIOR_SD_LOG)
        self._rows = self._likeliest_rows()  # 1
        self.shutter_s, _ = minimise(lambda s: self._errors(shutter_s=s), *shutter)  # 2
        if not self._given:
            log_focal, _ = minimise(lambda x: self._errors(log_focal=x), *zoom)
            self.focal = math.exp(log_focal)
            if abs(log_focal - middle) > 0.1:
                # Far from the guessed focal length all shutter directions look alike, so the direction is tested again.
                self._rows, self.shutter_s = self._likeliest_rows(), SHUTTER_PRIOR_S
        self._solve_together([] if self._given else [Unknown(*zoom, 0.06)], Unknown(*shutter, 0.003))  # 3
        if not self._given and abs(math.log(self.focal) - middle) > FOCAL_FAR_SDS * FOCAL_PRIOR_SD_LOG:
            self._solve_steadily(zoom, Unknown(*shutter, 0.003))  # 4

    def _solve_together(self, zoom: list[Unknown], shutter: Unknown) -> None:
        """Estimate shutter, distortion and, if unknown, focal length, by repeated joint searches."""
        bend = Unknown(-DISTORTION_MAX_K1, DISTORTION_MAX_K1, 0.0, DISTORTION_PRIOR_SD_K1, 0.03, heavy=True)
        unknowns, k = (*zoom, shutter, bend), len(zoom)

        def residuals(at: Array) -> Array:
            focal = math.exp(at[0]) if zoom else self.focal
            points = self._flat(self._chosen, shutter_s=float(at[k]), bend=float(at[k + 1]))
            return self._near.residuals_px(points, focal / self._start_focal, focal, self._centre)

        for _ in range(MOST_SETTLED):
            self._settle()
            before = np.array([math.log(self.focal)] * k + [self.shutter_s, self.bend])
            usual = float(np.median(self._errors())) or 1e-9
            near = [one.near(at, NEARBY_STEPS) for one, at in zip(unknowns, before, strict=True)]
            place, covariance = minimise_together(residuals, before, near, usual)
            if zoom:
                self.focal = math.exp(place[0])
                self.covariance = covariance[np.ix_([0, 2], [0, 2])]
            else:
                self.covariance[1, 1] = covariance[1, 1]
            self.shutter_s, self.bend = float(place[k]), float(place[k + 1])
            if np.all(np.abs(place - before) < [SETTLED * one.step for one in near]):
                break

    def _solve_steadily(self, zoom: tuple[float, float, float, float], shutter: Unknown) -> None:
        """Estimate the focal length on a steady path; if it changes, estimate the rest again."""
        found = math.log(self.focal)

        def errors(log_focal: float) -> Array:
            focal, points = math.exp(log_focal), self._flat(self._chosen)
            poses = moved_poses(self._start, self.plane, points, focal / self._start_focal, focal, self._centre)
            return steady_errors_px(poses, self.plane, points, self._times[self._chosen], focal, self._centre)

        log_focal, log_sd = posterior(errors, *zoom, SPARE)
        if abs(log_focal - found) < FOCAL_FAR_SDS * FOCAL_PRIOR_SD_LOG:
            return
        self.focal = math.exp(log_focal)
        self._solve_together([], shutter)
        self.covariance[0], self.covariance[:, 0] = 0.0, 0.0
        self.covariance[0, 0] = log_sd**2

    def all_poses(self) -> PlanePoses:
        """Poses of all frames with the estimated parameters."""
        return start_poses(self.plane, self._flat(slice(None)), self.focal, self._centre)

    def moved(self, poses: PlanePoses, off: Array) -> PlanePoses:
        """The poses if the parameters of `covariance`, in its order, changed by `off`."""
        zoom = math.exp(off[0])
        points = self._flat(slice(None), bend=self.bend + off[1])
        return moved_poses(poses, self.plane, points, zoom, self.focal * zoom, self._centre)

    def _flat(
        self, frames: NDArray[np.int64] | slice, *, shutter_s: float | None = None, bend: float | None = None
    ) -> Array:
        """Points as seen by a pinhole camera without a rolling shutter."""
        seconds, bent = (self.shutter_s if shutter_s is None else shutter_s), (self.bend if bend is None else bend)
        rolled = self._velocity[frames] * self._rows[frames] * seconds
        return np.asarray(self._points[frames] - self._bends.px(bent, frames) - rolled)

    def _errors(
        self, *, log_focal: float | None = None, shutter_s: float | None = None, bend: float | None = None
    ) -> Array:
        """Reprojection errors (T,) px of the chosen frames; parameters not given keep their present estimate."""
        focal = self.focal if log_focal is None else math.exp(log_focal)
        points = self._flat(self._chosen, shutter_s=shutter_s, bend=bend)
        zoom = focal / self._start_focal
        if abs(math.log(zoom)) > NEARBY_ZOOM:
            return moved_poses(self._start, self.plane, points, zoom, focal, self._centre).least_error_px
        return self._near.least_error_px(points, zoom, focal, self._centre)

    def _settle(self) -> None:
        """Refine the poses at the present estimates, as the start of the next search."""
        zoom = self.focal / self._start_focal
        points = self._flat(self._chosen)
        self._start = moved_poses(self._start, self.plane, points, zoom, self.focal, self._centre)
        self._start_focal, self._near = self.focal, NearPoses(self.plane, self._start)

    def _likeliest_rows(self) -> Array:
        """The likeliest direction of the shutter, tested at its usual time."""
        tried = []
        for direction in self._directions:
            self._rows = direction
            tried.append(self._errors(shutter_s=SHUTTER_PRIOR_S))
        scale = min(float(np.median(errors)) for errors in tried) or 1e-9
        return self._directions[int(np.argmin([np.sum(np.log1p((errors / scale) ** 2)) for errors in tried]))]


def _velocity_px_s(points_px: Array, times_s: Array, focal_px: float) -> Array:
    """Velocity of each point, (T, N, 2) px/s: derivative of a cubic spline through the frames, not across cuts, and 0
    beside gaps.

    Registered points are exact to some hundredths of a pixel, so they are interpolated and not smoothed: smoothing
    would flatten a hand's tremor, and the shutter time would be overestimated.
    """
    velocity = np.zeros_like(points_px)
    for stretch in unbroken(times_s, GAP_S, np.cumsum(_cuts(points_px / focal_px))):
        if len(stretch) < 4:
            continue
        clock = times_s[stretch]
        kept = _apart(clock, 0.5 * float(np.median(np.diff(clock))))
        if len(kept) >= 4:
            spline = CubicSpline(clock[kept], points_px[stretch][kept])
            velocity[stretch] = spline(np.clip(clock, clock[kept[0]], clock[kept[-1]]), 1)
    return velocity


def _cuts(points: Array) -> NDArray[np.bool_]:
    """Frames before which the points (T, N, 2), in focal lengths, jump, (T,).

    Source: third differences, in which a jump counts twice at its place, and a hand's motion hardly at all.
    """
    found = np.zeros(len(points), bool)
    if len(points) < AROUND:
        return found
    jerk = np.abs(np.diff(points, 3, axis=0)).max(axis=(1, 2))
    usual = median_filter(jerk, AROUND, mode="nearest")
    sudden = (jerk > np.maximum(2 * MAX_PICTURE_JUMP, JUMP_NOISE_SDS * usual)) & (jerk == maximum_filter1d(jerk, 3))
    found[2:-1] = sudden
    return found


def _apart(clock: Array, least_s: float) -> list[int]:
    """Indices of times that are at least `least_s` apart: a file may have two times that are equal or nearly so, and a
    spline through both would give a huge velocity.
    """
    kept = [0]
    for place in range(1, len(clock)):
        if clock[place] - clock[kept[-1]] >= max(least_s, 1e-6):
            kept.append(place)
    return kept
