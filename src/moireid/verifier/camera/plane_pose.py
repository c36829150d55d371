"""Poses of a known plane in many frames at once, and a film's camera in closed form.

A distant plane has two poses that fit almost equally well, with opposite tilts; both are kept until the end.  All
frames are refined together in arrays, because a film-wide search needs them some thirty times.

A hand that trembles between two frames moves the rows of a rolling shutter by an unknown speed.  Where that matters,
each frame has some slack along its rows: the errors in that direction count less.

A film may be a crop, or a tile of a recorded call, so that its optical axis meets the picture far from the middle or
outside of it; or it may be stretched.  A search from the middle does not find that.  So optical axis, focal length and
pixel aspect are also computed from homographies alone (`closed_form`): each homography of a plane gives two linear
equations of the image of the absolute conic.

Convention: points (N, 3) of the plane in its own frame; rotation plane -> camera; OpenCV's camera axes; slack (T, N):
    the direction of the rows over the points, of length sqrt(1 - a^2), where a is the weight of an error in that
    direction, in u and in v; None: all errors count alike.
    In `ClosedForm` lengths are in long sides of the picture, the axis from the picture's middle, x right, y down;
    aspect is the focal length along x over that along y, 1 for square pixels, below 1 in a picture that was squeezed.
    Axis and focal length are those of the picture once its pixels are square.
Source: start by infinitesimal plane-based pose estimation (Collins and Bartoli, 2014); refinement by Gauss-Newton on
    the reprojection error.  Closed form: Zhang, A flexible new technique for camera calibration, 2000,
    section 3.1; frames that fit badly, as some are shaken, get Geman and McClure's weight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.kernel.fitting import refined_poses

Array = NDArray[np.float64]
ROUNDS = 4


@dataclass(frozen=True)
class ClosedForm:
    """axis (2,), focal and aspect, in the unit and convention of this module."""

    axis: Array
    focal: float
    aspect: float


def closed_form(points: Array, plane: Array, *, square: bool) -> ClosedForm | None:
    """The camera that explains a film's homographies; None where they do not determine it.

    Parameters: points (T, N, 2): pictures of the plane's points, from the picture's middle, in long sides; plane
        (N, 2): any unit; square: whether pixels are known to be square.
    """
    homographies = plane_homographies((plane - plane.mean(axis=0)) / np.ptp(plane), points)
    homographies /= np.linalg.norm(homographies, axis=(1, 2), keepdims=True)
    rows = np.concatenate([_row(homographies, 0, 1), _row(homographies, 0, 0) - _row(homographies, 1, 1)])
    if square:
        rows = np.column_stack([rows[:, 0] + rows[:, 1], rows[:, 2:]])
    weight = np.ones(len(rows))
    for _ in range(ROUNDS):
        conic = np.linalg.svd(rows * weight[:, None], full_matrices=False)[2][-1]
        left = np.abs(rows @ conic)
        weight = 1 / (1.0 + (left / (2 * np.median(left) + 1e-15)) ** 2)
    along, across = (conic[0], conic[0]) if square else conic[:2]
    both_x, both_y, rest = conic[-3:]
    if along * across <= 0:
        return None
    axis = np.array([-both_x / along, -both_y / across])
    power = (rest - both_x**2 / along - both_y**2 / across) / across
    if not power > 0:
        return None
    aspect = float(np.sqrt(across / along))
    return ClosedForm(axis / [aspect, 1.0], float(np.sqrt(power)), aspect)


def _row(homographies: Array, i: int, j: int) -> Array:
    """Coefficients (T, 5) of h_i' B h_j, for B11, B22, B13, B23, B33 and no skew."""
    a, b = homographies[:, :, i], homographies[:, :, j]
    return np.column_stack(
        [
            a[:, 0] * b[:, 0],
            a[:, 1] * b[:, 1],
            a[:, 2] * b[:, 0] + a[:, 0] * b[:, 2],
            a[:, 2] * b[:, 1] + a[:, 1] * b[:, 2],
            a[:, 2] * b[:, 2],
        ]
    )


STEPS = 6
#: Added to the normal matrix of a homography in unit coordinates: it solves also what points do not determine.
LEAST_RIDGE = 1e-12
#: This share of the normal matrix's diagonal is added to it, so that a frame of poor geometry takes small steps.
DAMPING = 1e-6
#: Largest rotation in one step; a larger one would leave the basin of its pose.
MOST_TURN_RAD = 0.5


@dataclass(frozen=True)
class PlanePoses:
    """Rotations (T, 2, 3, 3) and translations (T, 2, 3) of both poses, and their RMS reprojection errors (T, 2) px."""

    rotation: Array
    translation: Array
    error_px: Array

    @property
    def camera(self) -> Array:
        """Camera centres in the plane's frame, (T, 2, 3)."""
        return np.asarray(-np.einsum("tsji,tsj->tsi", self.rotation, self.translation))

    @property
    def least_error_px(self) -> Array:
        """Error of the better pose of each frame, (T,)."""
        return np.asarray(self.error_px.min(axis=1))

    def residuals_px(self, plane: Array, points_px: Array, focal: float, centre: tuple[float, float]) -> Array:
        """What the better pose of each frame leaves of points (T, N, 2), (T, 2 N) px."""
        frames, better = np.arange(len(self.error_px)), self.error_px.argmin(axis=1)
        turned = np.einsum("tij,nj->tni", self.rotation[frames, better], plane)
        local = turned + self.translation[frames, better][:, None]
        seen = focal * local[..., :2] / local[..., 2:] + np.array(centre)
        return np.asarray((seen - points_px).reshape(len(frames), -1))


def rotations(vectors: NDArray[np.floating]) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3), rad.

    Source: Rodrigues, cos a + (1 - cos a) / a^2 v v' + sin a / a [v]x for a vector v of length a.
    """
    angle = np.sqrt(np.sum(vectors**2, axis=-1))[..., None, None]
    x, y, z = (np.sinc(angle[..., 0, 0] / np.pi) * vectors[..., k] for k in range(3))
    turn = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * vectors[..., :, None] * vectors[..., None, :]
    turn += np.cos(angle) * np.eye(3)
    for row, column, part in ((2, 1, x), (0, 2, y), (1, 0, z)):
        turn[..., row, column] += part
        turn[..., column, row] -= part
    return np.asarray(turn)


def loosened(errors: Array, slack: Array) -> Array:
    """Errors whose part along the slack is weighted by a; both (..., N), as the module's convention has it.

    Source: the square root of the inverse covariance 1 + s s' of a unit noise and an unknown along s is
        1 - c u u', where u is `slack`; applied to residuals and derivatives alike it makes least squares exact.
    """
    square = np.sum(slack**2, axis=-1, keepdims=True)
    share = (1 - np.sqrt(np.maximum(1 - square, 0.0))) / np.maximum(square, 1e-12)
    return np.asarray(errors - share * slack * np.sum(slack * errors, axis=-1, keepdims=True))


def start_poses(
    plane: Array, points_px: Array, focal: float, centre: tuple[float, float], slack: Array | None = None
) -> PlanePoses:
    """Both poses of every frame without a start value, refined; points_px (T, N, 2)."""
    seen = (points_px - np.array(centre)) / focal
    rotation, translation = _from_homographies(plane_homographies(plane[:, :2], seen))
    return refine_poses(plane, points_px, focal, centre, rotation, translation, slack=slack)


def plane_homographies(plane: Array, seen: Array) -> Array:
    """Plane (N, 2) -> picture of each frame, (T, 3, 3), 1 in the last place.

    Source: least squares (direct linear transformation), in coordinates of unit size.
    """
    middle, reach = plane.mean(axis=0), float(np.abs(plane - plane.mean(axis=0)).max())
    off = seen.mean(axis=1, keepdims=True)
    size = np.maximum(np.abs(seen - off).max(axis=(1, 2), keepdims=True), 1e-12)
    flat = np.column_stack([(plane - middle) / reach, np.ones(len(plane))])
    local = (seen - off) / size
    by_axis = np.zeros((len(seen), 2, len(plane), 8))
    by_axis[:, 0, :, :3], by_axis[:, 1, :, 3:6] = flat, flat
    by_axis[..., 6:] = -local.swapaxes(1, 2)[..., None] * flat[:, :2]
    table = by_axis.reshape(len(seen), -1, 8)
    turned = table.swapaxes(-1, -2)
    wanted = local.swapaxes(1, 2).reshape(len(seen), -1, 1)
    found = np.linalg.solve(turned @ table + LEAST_RIDGE * np.eye(8), turned @ wanted)[..., 0]
    homographies = np.concatenate([found, np.ones((len(seen), 1))], axis=1).reshape(-1, 3, 3)
    homographies[:, :2] = size * homographies[:, :2] + off[:, 0, :, None] * homographies[:, 2:]
    homographies[..., :2] /= reach
    homographies[..., 2] -= homographies[..., :2] @ middle
    return np.asarray(homographies / homographies[:, 2:, 2:])


def _from_homographies(homographies: Array) -> tuple[Array, Array]:
    """Both poses, (T, 2, 3, 3) and (T, 2, 3), whose projection agrees with a homography at the plane's origin.

    Source: Collins and Bartoli (2014), section 3: the homography's derivative there is a rotation towards the origin's
        line of sight, times the upper part of a rotation, over the depth; the third row of that has two signs.
    """
    at, depth = homographies[:, :2, 2], homographies[:, 2, :2]
    slope = homographies[:, :2, :2] - at[:, :, None] * depth[:, None]
    sight = np.concatenate([at, np.ones((len(at), 1))], axis=1)
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    # The shortest rotation that takes the optical axis there.
    towards = np.zeros((len(at), 3, 3))
    towards[:, :2, :2] = np.eye(2) - sight[:, :2, None] * sight[:, None, :2] / (1 + sight[:, 2, None, None])
    towards[:, :, 2], towards[:, 2, :2] = sight, -sight[:, :2]
    inner = np.linalg.solve(towards[:, :2, :2] - at[:, :, None] * towards[:, 2:, :2], slope)
    square = inner @ inner.swapaxes(-1, -2)
    half, apart = (square[:, 0, 0] + square[:, 1, 1]) / 2, (square[:, 0, 0] - square[:, 1, 1]) / 2
    near = np.sqrt(half + np.hypot(apart, square[:, 0, 1]))
    upper = inner / near[:, None, None]
    rest = np.sqrt(np.maximum(1 - (upper**2).sum(axis=1), 0.0))
    rest[:, 1] *= np.where((upper[:, :, 0] * upper[:, :, 1]).sum(axis=1) > 0, -1.0, 1.0)
    columns = np.stack([np.concatenate([upper, sign * rest[:, None]], axis=1) for sign in (1.0, -1.0)], axis=1)
    third = np.cross(columns[..., 0], columns[..., 1])
    rotation = towards[:, None] @ np.concatenate([columns, third[..., None]], axis=-1)
    shift = np.column_stack([at, np.ones(len(at))]) / near[:, None]
    return rotation, np.repeat(shift[:, None], 2, axis=1)


def moved_poses(
    poses: PlanePoses,
    plane: Array,
    points_px: Array,
    zoom: float,
    focal: float,
    centre: tuple[float, float],
    steps: int = STEPS,
    slack: Array | None = None,
) -> PlanePoses:
    """Poses at another focal length `focal`, which is `zoom` times that of `poses`, or for slightly moved points."""
    nearer = poses.translation * np.array([1.0, 1.0, zoom])
    return refine_poses(plane, points_px, focal, centre, poses.rotation, nearer, steps, slack)


def point_error_px(poses: PlanePoses, points: int) -> float:
    """Standard deviation of one coordinate of a point, px, from the errors that poses leave of so many points.

    Source: the two residuals that a homography has more than a pose; a chi-square of two has its median at 1.386.
    """
    return float(np.sqrt(np.median(poses.least_error_px**2) * points / 1.386))


def tangent_error(
    poses: PlanePoses, plane: Array, focal: float, slack: Array | None = None, frames: int = 9
) -> tuple[float, float]:
    """Standard deviation of Cx/Cz and Cy/Cz of one frame, from the reprojection errors.

    Convention: the median over some frames spread over the film.
    Source: covariance sigma^2 (J'J)^-1 of least squares.
    """
    places = np.linspace(0, len(poses.error_px) - 1, min(frames, len(poses.error_px))).astype(int)
    sides = poses.error_px.argmin(axis=1)
    sigma = point_error_px(poses, len(plane)) / focal
    step = 1e-6
    spreads = []
    for frame in places:
        rotation, translation = poses.rotation[frame, sides[frame]], poses.translation[frame, sides[frame]]
        seen, tangents = _seen_and_tangents(plane, rotation, translation)
        rows = []
        for k in range(6):
            turn = rotations(step * np.eye(6)[k, :3])
            moved = _seen_and_tangents(plane, turn @ rotation, translation + step * translation[2] * np.eye(6)[k, 3:])
            rows.append(np.concatenate([moved[0] - seen, moved[1] - tangents]) / step)
        table = np.array(rows).T
        jacobian, by_tangent = table[:-2], table[-2:]
        if slack is not None:
            by_axis = jacobian.reshape(len(plane), 2, 6).transpose(1, 2, 0)
            jacobian = loosened(by_axis, slack[frame]).transpose(2, 0, 1).reshape(-1, 6)
        covariance = np.linalg.pinv(jacobian.T @ jacobian)
        spreads.append(np.sqrt(np.maximum(np.diag(by_tangent @ covariance @ by_tangent.T), 0)))
    along_x, along_y = sigma * np.median(spreads, axis=0)
    return float(along_x), float(along_y)


def _seen_and_tangents(plane: Array, rotation: Array, translation: Array) -> tuple[Array, Array]:
    """Normalised picture coordinates of the points, flat, and the camera's tangents in the plane's frame, (2,)."""
    local = plane @ rotation.T + translation
    camera = -rotation.T @ translation
    return (local[:, :2] / local[:, 2:]).ravel(), camera[:2] / camera[2]


def refine_poses(
    plane: Array,
    points_px: Array,
    focal: float,
    centre: tuple[float, float],
    rotation: Array,
    translation: Array,
    steps: int = STEPS,
    slack: Array | None = None,
) -> PlanePoses:
    """Gauss-Newton from the given poses, (T, 2, 3, 3) and (T, 2, 3)."""
    seen = (points_px - np.array(centre)) / focal
    rotation, translation, left = refined_poses(
        plane, seen, slack, rotation, translation, steps=steps, damping=DAMPING, most_turn=MOST_TURN_RAD
    )
    return PlanePoses(rotation, translation, focal * left)


def derivatives(plane: Array, poses: PlanePoses, slack: Array | None = None) -> Array:
    """Derivatives of each pose by rotation and shift, (T, S, 6, 2 N).

    Convention: in normalised picture coordinates, u of all points before v.
    """
    turned = _turned(poses.rotation, plane)
    flat, near = _projected(turned, poses.translation)
    jacobian = np.empty((*flat.shape[:2], 6, 2, len(plane)))
    _fill_jacobian(jacobian, turned, flat, near)
    if slack is not None:
        jacobian = loosened(jacobian, slack[:, None, None, None])
    return np.asarray(jacobian.reshape(*jacobian.shape[:3], -1))


def _turned(rotation: Array, plane: Array) -> Array:
    """The plane's points rotated into camera axes, before the shift, (T, 2, 3, N)."""
    # One product of tall matrices is ten times faster than many small ones.
    return np.asarray((rotation.reshape(-1, 3) @ plane.T).reshape(*rotation.shape[:-1], len(plane)))


def _projected(turned: Array, translation: Array) -> tuple[Array, Array]:
    """Normalised picture coordinates, (T, 2, 2, N), and one over the depth, (T, 2, N)."""
    near = 1 / (turned[..., 2, :] + translation[..., 2, None])
    return (turned[..., :2, :] + translation[..., :2, None]) * near[..., None, :], near


def _fill_jacobian(jacobian: Array, turned: Array, flat: Array, near: Array) -> None:
    """Derivatives of u and v by a small rotation (before the shift) and by the shift, (T, 2, 6, 2, N).

    Source: the derivative of u = x/z by the camera point is p = (1, 0, -u) / z, and by a small rotation it is the cross
        product of the rotated point with p; likewise for v = y/z.
    """
    x, y, z = (turned[..., k, :] * near for k in range(3))
    u, v = flat[..., 0, :], flat[..., 1, :]
    by_u = (-y * u, z + x * u, -y, near, 0.0, -u * near)
    by_v = (-z - y * v, x * v, x, 0.0, near, -v * near)
    for k in range(6):
        jacobian[..., k, 0, :], jacobian[..., k, 1, :] = by_u[k], by_v[k]
