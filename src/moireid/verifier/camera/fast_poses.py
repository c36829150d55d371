"""A plane's poses near known ones; and whether one camera explains all poses of a film.

A film-wide search needs the errors two hundred times, near poses that are known.  From there, few steps are enough.

A program that follows a face, zooms or stabilises moves the optical axis and the focal length within the film.  A zoom
can often be solved (`map_search.zoom_path`).  The path of an axis cannot, from the badge alone: it changes poses much
as another focal length does.  But both show.  The errors that one camera leaves are then no longer those of single
frames, but go on over many frames (`lasting_error_px`).

Convention: as `plane_pose`; residuals (T, 2 N) px of N points, u of all points before v.
Source: lasting errors: the slow part of the residuals, less what white noise leaves in it; noise by the difference of
    neighbouring frames (von Neumann 1941).
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.plane_pose import PlanePoses, derivatives, loosened, moved_poses
from moireid.verifier.camera.smoothing import CUT_OFFS_HZ, GAP_S, slow_part, unbroken
from moireid.verifier.measuring import STRAY_MEDIANS_RATIO

Array = NDArray[np.float64]
#: After two steps the errors of points that are moved by some pixels are right within 1e-6.
STEPS = 2
#: More steps for a joint search along a valley, where poses move far; if they lag behind, the search stops early.
WHOLE_STEPS = 4


class NearPoses:
    """Known poses, from which those of slightly moved points are found in few steps."""

    def __init__(self, plane: Array, poses: PlanePoses, slack: Array | None = None) -> None:
        """Parameters: plane (N, 3) with z = 0; poses: the best ones; slack: as `plane_pose`."""
        frames, better = np.arange(len(poses.error_px)), poses.error_px.argmin(axis=1)
        self._plane, self._poses, self._slack = plane, poses, slack
        self._better = PlanePoses(*(part[frames, better][:, None] for part in vars(poses).values()))

    def least_error_px(self, points_px: Array, zoom: float, focal: float, centre: tuple[float, float]) -> Array:
        """Reprojection error of the better pose of each frame, (T,) px, after the poses are updated.

        Parameters: points_px (T, N, 2), near those of the poses; focal: `zoom` times that of the poses.
        Returns: infinity if both poses see the plane from behind, or their equations have no solution.
        """
        return moved_poses(self._poses, self._plane, points_px, zoom, focal, centre, STEPS, self._slack).least_error_px

    def residuals_px(self, points_px: Array, zoom: float, focal: float, centre: tuple[float, float]) -> Array:
        """Residuals of each frame's better pose, (T, 2 N) px.

        Parameters: as `least_error_px`.  Convention: the better pose is chosen at the known poses, so that the
            residuals are smooth functions of the parameters.
        """
        poses = moved_poses(self._better, self._plane, points_px, zoom, focal, centre, WHOLE_STEPS, self._slack)
        left = poses.residuals_px(self._plane, points_px, focal, centre).reshape(points_px.shape)
        return self._weighed(left)

    def following_px(self, moves_px: Array) -> Array:
        """How residuals change as points move by so much, (T, N, 2) px, and the better poses follow; (T, 2 N) px.

        Convention: 0 in a frame without a pose, which adds no information.
        Source: the moves less their projection onto the derivatives by the pose, at the known poses.
        """
        flat = self._weighed(moves_px)
        along = flat[:, None] @ self._reach
        return np.nan_to_num((along @ self._reach.swapaxes(-1, -2))[:, 0] - flat)

    def _weighed(self, errors: Array) -> Array:
        """Errors (T, N, 2), less those that the slack allows, (T, 2 N)."""
        apart = errors.swapaxes(1, 2)
        if self._slack is not None:
            apart = loosened(apart, self._slack[:, None])
        return apart.reshape(len(errors), -1)

    @cached_property
    def _reach(self) -> Array:
        """Orthonormal directions in which the residuals move as the better pose does, (T, 2 N, 6)."""
        return np.asarray(np.linalg.qr(derivatives(self._plane, self._better, self._slack)[:, 0].swapaxes(-1, -2))[0])


#: Standard deviation of the mean over time that separates what lasts from noise, s.
LASTING_S = 0.25
#: Share of the noise that is left in such a mean.  White noise leaves 0.19 at 30 frames a second and 0.27 at 15; a
#: codec repeats its errors for a few frames.
NOISE_LEFT_SHARE = 0.45
#: Least power that smoothing removes, over what it keeps.
LEAST_REMOVED = 1e-6
#: Standard deviation of the mean that halves the frequency at which smoothing halves, s.
SMOOTHED_S = math.sqrt(2 * math.log(2)) / (2 * math.pi * CUT_OFFS_HZ[0])


def lasting_error_px(residuals_px: Array, times_s: Array, numbers: NDArray[np.int64]) -> tuple[float, float]:
    """Reprojection error that lasts longer than noise does, and the noise, root mean squares over points, px.

    Parameters: numbers (T,): as `stretches`.
    Convention: module docstring; misregistered frames count as bounded.
    """
    errors, known = _bounded(residuals_px)
    if len(known) < 2:
        return 0.0, 0.0
    clock, numbers = times_s[known], numbers[known]
    slow = slow_part(errors, clock, LASTING_S, numbers)
    runs = [run for run in unbroken(clock, GAP_S, numbers) if len(run) > 1]
    steps = np.concatenate([np.diff(errors[run], axis=0) for run in runs]) if runs else errors
    # The square of a point's error is the sum of those of its two coordinates.
    lasting, noise = 2 * float((slow**2).mean()), float((steps**2).mean())
    return math.sqrt(max(lasting - NOISE_LEFT_SHARE**2 * noise, 0.0)), math.sqrt(noise)


def slow_to_fast(residuals_px: Array, times_s: Array, numbers: NDArray[np.int64]) -> float:
    """How much of the residuals is too slow for smoothing to remove, over what it removes; 0 where it removes nothing.

    A coder that saves leaves small markers as they were for some frames, so their errors are slow.  Poses share them,
    but in a pose what is slow cannot be distinguished from motion.  In the residuals it can.
    Parameters: numbers (T,): as `stretches`.
    Convention: as `lasting_error_px`.
    Source: one coordinate of a homography errs as another does, so slow and fast parts have one ratio in all of them.
    """
    errors, known = _bounded(residuals_px)
    if len(known) < 2:
        return 0.0
    slow = slow_part(errors, times_s[known], SMOOTHED_S, numbers[known])
    kept, removed = float((slow**2).mean()), float(((errors - slow) ** 2).mean())
    # Of frames that are too far apart to be smoothed, rounding alone is removed.
    return math.sqrt(kept / removed) if removed > LEAST_REMOVED * kept else 0.0


def _bounded(residuals_px: Array) -> tuple[Array, NDArray[np.int64]]:
    """The residuals of the frames that have some, with those of misregistered frames bounded, and which they are."""
    size = np.sqrt((residuals_px**2).mean(axis=1))
    known = np.flatnonzero(np.isfinite(size))
    if not len(known):
        return residuals_px[known], known
    most = STRAY_MEDIANS_RATIO * float(np.median(size[known]))
    return residuals_px[known] * np.minimum(1.0, most / np.maximum(size[known], 1e-12))[:, None], known
