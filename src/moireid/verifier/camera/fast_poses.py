"""Fast reprojection errors of a plane's poses near known ones; and whether one camera explains all poses of a film.

A film-wide search needs the errors two hundred times, so they are written for speed: one normal matrix serves all
values nearby, and poses are the last axis of every array, because NumPy is fast along a long last axis.  It costs a
tenth of `plane_pose.moved_poses` and gives the same errors (a test checks it).  The gradient is computed anew for each
value; otherwise poses would stop next to the best ones, and error bars would be up to 4 % too small.

A program that follows a face, zooms or stabilises moves the optical axis and the focal length within the film.  A zoom
can often be solved (`map_search.zoom_path`).  The path of an axis cannot, from the badge alone: it changes poses much
as another focal length does.  But both show.  The errors that one camera leaves are then no longer those of single
frames, but go on over many frames (`lasting_error_px`).

Convention: as `plane_pose`; the plane is z = 0, so a pose has three columns: the plane's x axis and its y axis in
    camera axes, and the shift.  Residuals (T, 2 N) px of N points, as `PlanePoses.residuals_px`.
Source: lasting errors: the slow part of the residuals, less what white noise leaves in it; noise by the difference of
    neighbouring frames (von Neumann 1941).
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.plane_pose import MOST_TURN_RAD, PlanePoses, loosened, normal_equations
from moireid.verifier.camera.smoothing import CUT_OFFS_HZ, GAP_S, slow_part, unbroken
from moireid.verifier.measuring import STRAY_MEDIANS_RATIO

Array = NDArray[np.float64]
#: Each step leaves a twentieth to a fifth of the error, and the misfit near its minimum grows with the square of that.
#: After three steps the error bars of a film at 2 m are right within 0.1 %.
STEPS = 3
#: More steps for a joint search along a valley, where poses move far; if they lag behind, the search stops early.
WHOLE_STEPS = 6


class NearPoses:
    """Known poses, and the matrices that turn a gradient near them into a step."""

    def __init__(self, plane: Array, poses: PlanePoses, slack: Array | None = None) -> None:
        """Parameters: plane (N, 3) with z = 0; poses: the best ones; M = 2 T, both poses of all frames."""
        frames = len(poses.error_px)
        self._better = poses.error_px.argmin(axis=1)
        self._plane = np.column_stack([plane[:, :2], np.ones(len(plane))])
        columns = np.concatenate([poses.rotation[..., :2], poses.translation[..., None]], axis=-1)
        self._columns = np.ascontiguousarray(columns.transpose(2, 3, 1, 0)).reshape(3, 3, 2 * frames)
        self._slack = slack
        self._derivatives, normal = normal_equations(plane, poses, slack)
        solver = np.linalg.inv(normal)
        self._solver = np.ascontiguousarray(solver.transpose(2, 3, 1, 0)).reshape(6, 6, 2 * frames)

    def least_error_px(self, points_px: Array, zoom: float, focal: float, centre: tuple[float, float]) -> Array:
        """Reprojection error of the better pose of each frame, (T,) px, after the poses are updated.

        Parameters: points_px (T, N, 2), near those of the poses; focal: `zoom` times that of the poses.
        Returns: infinity if both poses see the plane from behind.
        """
        left, depth = self._residuals(points_px, zoom, focal, centre, STEPS)
        error = np.sqrt((left**2).sum(axis=0).mean(axis=0))
        error[(depth.min(axis=0) <= 0) | ~np.isfinite(error)] = np.inf
        return np.asarray(error.reshape(2, -1).min(axis=0))

    def residuals_px(self, points_px: Array, zoom: float, focal: float, centre: tuple[float, float]) -> Array:
        """Residuals of each frame's better pose, (T, 2 N) px.

        Parameters: as `least_error_px`.  Convention: the better pose is chosen at the known poses, so that the
            residuals are smooth functions of the parameters.
        """
        left, _ = self._residuals(points_px, zoom, focal, centre, WHOLE_STEPS)
        frames = np.arange(len(self._better))
        chosen = left.reshape(2, left.shape[1], 2, -1)[:, :, self._better, frames]
        return np.asarray(chosen.reshape(-1, len(frames)).T)

    def following_px(self, moves_px: Array) -> Array:
        """How residuals change as points move by so much, (T, N, 2) px, and the better poses follow; (T, 2 N) px.

        Convention: 0 in a frame without a pose, which adds no information.
        Source: the moves less their projection onto the derivatives by the pose, at the known poses.
        """
        moves = self._weighed(moves_px.transpose(2, 1, 0))
        flat = moves.reshape(-1, moves.shape[-1]).T
        along = flat[:, None] @ self._reach
        return np.nan_to_num((along @ self._reach.swapaxes(-1, -2))[:, 0] - flat)

    def _residuals(
        self, points_px: Array, zoom: float, focal: float, centre: tuple[float, float], steps: int
    ) -> tuple[Array, Array]:
        """Residuals (2, N, M) px and depths (N, M) after the poses are updated."""
        seen = np.tile(((points_px - np.array(centre)) / focal).transpose(2, 1, 0), 2)
        columns = self._columns.copy()
        columns[2, 2] *= zoom
        for _ in range(steps):
            gradient = self._gradient(columns, seen)
            columns = _stepped(columns, -np.einsum("ijm,jm->im", self._solver, gradient))
        flat, depth = self._projected(columns)
        return focal * self._weighed(flat - seen), depth

    def _weighed(self, errors: Array) -> Array:
        """Errors (2, N, T or M), less those that the slack allows."""
        if self._slack is None:
            return errors
        slack = np.tile(self._slack.T, errors.shape[-1] // len(self._slack))
        return np.asarray(np.moveaxis(loosened(np.moveaxis(errors, 1, 2), slack.T), 2, 1))

    @cached_property
    def _reach(self) -> Array:
        """Orthonormal directions in which the residuals move as the better pose does, (T, 2 N, 6)."""
        chosen = self._derivatives[np.arange(len(self._better)), self._better]
        return np.asarray(np.linalg.qr(chosen.swapaxes(-1, -2))[0])

    def _gradient(self, columns: Array, seen: Array) -> Array:
        """Half of the gradient of the squared residuals by a rotation (before the shift) and by the shift, (6, M).

        Source: derivatives as in `plane_pose`; the derivative by rotation is the moment of that by shift about the
            plane's origin, computed from moments of the plane's coordinates, as a point is a sum of the columns.
        """
        flat, depth = self._projected(columns)
        force = np.empty((3, *depth.shape))
        np.divide(self._weighed(self._weighed(flat - seen)), depth, out=force[:2])
        force[2] = -(flat * force[:2]).sum(axis=0)
        moments = self._plane.T @ force  # axes: force, plane's x and y and 1, M
        turn = _cross(columns[:, 0], moments[:, 0]) + _cross(columns[:, 1], moments[:, 1])
        return np.concatenate([turn, moments[:, 2]])

    def _projected(self, columns: Array) -> tuple[Array, Array]:
        """Normalised picture coordinates, (2, N, M), and depths, (N, M)."""
        local = self._plane @ columns
        return local[:2] / local[2], local[2]


def _stepped(columns: Array, step: Array) -> Array:
    """Poses (3, 3, M) after a rotation and a shift, (6, M).

    Source: Cayley's form, which is an exact rotation; its angle differs from `step` by a twelfth of its cube.
    """
    turn, shift = step[:3], step[3:]
    turn = turn * np.minimum(1.0, MOST_TURN_RAD / np.maximum(np.abs(turn).max(axis=0), 1e-12))
    half = 0.5 * turn[:, None]
    once = _cross(half, columns[:, :2])
    turned = columns[:, :2] + (once + _cross(half, once)) * (2 / (1 + (half**2).sum(axis=0)))
    return np.concatenate([turned, (columns[:, 2] + shift)[:, None]], axis=1)


def _cross(a: Array, b: Array) -> Array:
    """Cross product along the first axis."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


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
    slow = _slow(errors, clock, LASTING_S, numbers)
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
    slow = _slow(errors, times_s[known], SMOOTHED_S, numbers[known])
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


def _slow(errors: Array, times_s: Array, spread_s: float, numbers: NDArray[np.int64]) -> Array:
    return np.column_stack([slow_part(column, times_s, spread_s, numbers) for column in errors.T])
