"""Where the camera was, in the badge's own frame: focal length, rolling shutter and one pose a frame.

A plane seen in perspective tells the tilt only through small second differences of its corners, so the pose is the
weak signal of the whole method.  Three things make it good enough: registered corners, a focal length and a shutter
time solved over the whole film, and smoothing at the end.

Convention: page millimetres, x right, y down, z into the page; the camera's z is negative.  The parallax coordinate
of the page is u = Cx / |Cz| with Cx counted from the point looked at.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_smoothing_spline

from moireid.verifier.plane_pose import PlanePoses, moved_poses, start_poses, tangent_error

Array = NDArray[np.float64]
#: Prior of the focal length over the picture's longer side: phones' main cameras film at 0.7 to 0.85 (26 mm
#: equivalent and some crop for stabilisation); 35 % lets a zoom of two lie at two standard deviations.
FOCAL_PRIOR, FOCAL_PRIOR_SD = 0.78, 0.35
#: Prior of the shutter's run from first to last row, s: phone sensors take 5 to 20 ms.
SHUTTER_PRIOR_S, SHUTTER_PRIOR_SD_S = 0.010, 0.010
SHUTTER_LIMIT_S = 0.033
#: Frames that the film-wide unknowns are solved on; a long film has more than enough.
SOLVE_FRAMES = 300
#: Two frames further apart than this tell no velocity, and are not smoothed into one another.
GAP_S = 0.15
#: Smoothing may take away this many times the error that the poses are known to have: coded pictures err by up to twice
#: of it on films at 3 m whose poses are known, and a hand moves by less than 1 cm above 3 Hz.
EXPLAINED = 2.5
#: Cut-offs of smoothing.  A hand's path is slower than 2 Hz, of which the lowest leaves 83 %, and of 1 Hz 99 %.
CUT_OFFS_HZ = (3.0, 4.0, 6.0, 9.0, 14.0)
#: A homography has eight parameters, a pose six: each frame leaves two residuals that test the focal length.
SPARE_PER_FRAME = 2


@dataclass(frozen=True)
class CameraFit:
    """Camera centres (T, 3) page mm, and what was solved over the film.

    reprojection_px: root mean square over corners, (T,); focal_sd_px: standard deviation, 0 where the focal length
    was given; shutter_s: first to last row; tangent_sd: what the focal length's error makes of the spread of the
    parallax coordinates along x and y, as a share; tangent_error: standard deviation of one frame's parallax
    coordinates along x and y, from what its pose leaves unexplained.
    """

    camera_mm: Array
    reprojection_px: Array
    focal_px: float
    focal_sd_px: float
    focal_given: bool
    shutter_s: float
    tangent_sd: tuple[float, float]
    tangent_error: tuple[float, float]


def fit_camera(
    points_px: Array, page_mm: Array, times_s: Array, image_px: tuple[int, int], *, focal_px: float | None = None
) -> CameraFit:
    """Poses of all frames, with focal length (unless given) and rolling shutter solved over the film.

    Parameters: points_px (T, N, 2) pictures of page_mm (N, 2); image_px: width, height; times_s (T,), rising.
    Convention: module docstring; the principal point is the picture's centre.
    Returns: CameraFit with T frames.
    Source: maximum a posteriori over reprojection error; the plane's two poses by `plane_pose`.
    """
    centre = ((image_px[0] - 1) / 2.0, (image_px[1] - 1) / 2.0)
    middle = page_mm.mean(axis=0)
    plane = np.column_stack([page_mm - middle, np.zeros(len(page_mm))])
    velocity = _velocity_px_s(points_px, times_s)
    apart = (points_px - points_px.mean(axis=1, keepdims=True)) / np.array(image_px, float)
    # Programs turn films, so the shutter may run down, right, up or left through the picture as it is now.
    directions = [apart[..., 1:2], apart[..., 0:1], -apart[..., 1:2], -apart[..., 0:1]]
    rows = directions[0]
    chosen = np.unique(np.linspace(0, len(points_px) - 1, min(SOLVE_FRAMES, len(points_px))).astype(int))

    def unrolled(shutter_s: float, frames: NDArray[np.int64] | slice = slice(None)) -> Array:
        return points_px[frames] - velocity[frames] * rows[frames] * shutter_s

    guess = focal_px or FOCAL_PRIOR * max(image_px)
    start = start_poses(plane, points_px[chosen], guess, centre)

    def poses(focal: float, shutter_s: float) -> PlanePoses:
        return moved_poses(start, plane, unrolled(shutter_s, chosen), focal / guess, focal, centre)

    def likeliest_rows(focal: float) -> Array:
        """The way in which the shutter runs, told at its usual time."""
        nonlocal rows
        tried = []
        for direction in directions:
            rows = direction
            tried.append(poses(focal, SHUTTER_PRIOR_S).least_error_px)
        scale = min(float(np.median(errors)) for errors in tried) or 1e-9
        return directions[int(np.argmin([np.sum(np.log1p((errors / scale) ** 2)) for errors in tried]))]

    rows = likeliest_rows(guess)
    shutter = (0.0, SHUTTER_LIMIT_S, SHUTTER_PRIOR_S, SHUTTER_PRIOR_SD_S)
    shutter_s, _ = _minimise(lambda s: poses(guess, s).least_error_px, *shutter)
    focal, log_sd = float(guess), 0.0
    if focal_px is None:
        long_side = max(image_px)
        zoom = (np.log(0.4 * long_side), np.log(2.5 * long_side), np.log(guess), FOCAL_PRIOR_SD)
        log_focal, log_sd = _minimise(lambda x: poses(float(np.exp(x)), shutter_s).least_error_px, *zoom)
        if abs(log_focal - np.log(guess)) > 0.1:
            # Far from the guessed focal length all ways of the shutter looked alike, so it is asked for again.
            rows = likeliest_rows(float(np.exp(log_focal)))
            shutter_s = SHUTTER_PRIOR_S
        log_focal, shutter_s, log_sd = _minimise_both(
            lambda x, s: poses(float(np.exp(x)), s).least_error_px, (log_focal, shutter_s), zoom, shutter, log_sd
        )
        focal = float(np.exp(log_focal))
    final = start_poses(plane, unrolled(shutter_s), focal, centre)
    camera, errors = _choose(final)
    tangent_sd = (0.0, 0.0)
    if log_sd > 0:
        other = moved_poses(final, plane, unrolled(shutter_s), np.exp(log_sd), focal * np.exp(log_sd), centre)
        tangent_sd = _stretch(camera, _choose(other)[0])
    camera[:, :2] += middle
    error = tangent_error(final, plane, focal)
    return CameraFit(camera, errors, focal, focal * log_sd, focal_px is not None, shutter_s, tangent_sd, error)


def _choose(poses: PlanePoses) -> tuple[Array, Array]:
    """Camera centres (T, 3) and errors (T,): where both poses fit alike, the one that continues its neighbours'."""
    centres, frames = poses.camera, np.arange(len(poses.error_px))
    better = poses.error_px.argmin(axis=1)
    best, other = poses.error_px[frames, better], poses.error_px[frames, 1 - better]
    # Twice the error is five standard deviations of what two spare residuals do by chance.
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
    """How much wider the other course of tangents is than this one, along x and y, as a share of it."""
    shares = []
    for axis in (0, 1):
        here, there = (c[:, axis] / c[:, 2] - np.mean(c[:, axis] / c[:, 2]) for c in (camera, other))
        power = float(here @ here)
        shares.append(abs(float(here @ (there - here)) / power) if power > 0 else 0.0)
    return shares[0], shares[1]


def _minimise(
    errors_px: Callable[[float], Array], low: float, high: float, prior: float, prior_sd: float
) -> tuple[float, float]:
    """Place of least misfit and prior together, and its standard deviation, by a parabola through the best three.

    The misfit of a frame is Cauchy's, log(1 + e^2/s^2) with s the median error at the best place: frames that were
    shaken or half hidden count little.  Near the bottom it is a chi-square of `SPARE_PER_FRAME` residuals a frame.
    """
    tried: dict[float, Array] = {float(place): errors_px(float(place)) for place in np.linspace(low, high, 12)}
    step = (high - low) / 11

    def misfits(scale: float) -> tuple[Array, Array]:
        places = np.array(sorted(tried))
        cauchy = np.array([_misfit(tried[p], scale) for p in places])
        return places, SPARE_PER_FRAME * cauchy + ((places - prior) / prior_sd) ** 2

    scale = min(float(np.median(errors)) for errors in tried.values()) or 1e-9
    for _ in range(4):
        step /= 2
        places, cost = misfits(scale)
        centre = float(places[int(np.argmin(cost))])
        for place in (centre - step, centre + step):
            if low <= place <= high and place not in tried:
                tried[place] = errors_px(place)
    places, cost = misfits(scale)
    best = int(np.clip(np.argmin(cost), 1, len(places) - 2))
    curve = np.polyfit(places[best - 1 : best + 2] - places[best], cost[best - 1 : best + 2], 2)
    if curve[0] <= 0:
        return float(places[int(np.argmin(cost))]), prior_sd
    place = float(np.clip(places[best] - curve[1] / (2 * curve[0]), places[best - 1], places[best + 1]))
    return place, float(min(1 / np.sqrt(curve[0]), prior_sd))


def _misfit(errors_px: Array, scale: float) -> float:
    """Cauchy's misfit of all frames; one whose pose could not be found is very wrong, not endlessly."""
    bounded = np.minimum(np.nan_to_num(errors_px, nan=np.inf), 1e3 * scale)
    return float(np.sum(np.log1p((bounded / scale) ** 2)))


def _minimise_both(
    errors_px: Callable[[float, float], Array], start: tuple[float, float],
    one: tuple[float, float, float, float], other: tuple[float, float, float, float], one_sd: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Both places of least misfit, and the standard deviation of the first, the other's doubt included.

    Parameters: start: near the minimum; one, other: low, high, prior and its standard deviation of each; one_sd:
        returned where the misfit has no minimum that a paraboloid can describe.
    Source: misfit as in `_minimise`.  Focal length and shutter share a valley, along which seeking one at a time
    stops early, with an error bar for the valley's width instead of its length; so a paraboloid is fitted to nine
    places around the best one, and again around its minimum, ever nearer.
    """
    scale = float(np.median(errors_px(*start))) or 1e-9
    place = np.array(start)
    low, high = np.array([one[0], other[0]]), np.array([one[1], other[1]])
    prior, prior_sd = np.array([one[2], other[2]]), np.array([one[3], other[3]])
    step = np.array([0.06, 0.003])
    grid = np.array([(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)], float)
    terms = np.column_stack([np.ones(9), grid, grid[:, 0] ** 2, grid[:, 0] * grid[:, 1], grid[:, 1] ** 2])
    sd = one_sd
    for _ in range(5):
        centre = np.clip(place, low + step, high - step)
        places = centre + grid * step
        misfit = [SPARE_PER_FRAME * _misfit(errors_px(*at), scale) for at in places]
        cost = np.array(misfit) + (((places - prior) / prior_sd) ** 2).sum(axis=1)
        _, bx, by, axx, axy, ayy = np.linalg.lstsq(terms, cost, rcond=None)[0]
        bend = np.array([[2 * axx, axy], [axy, 2 * ayy]])
        if axx <= 0 or np.linalg.det(bend) <= 0:
            place = places[int(np.argmin(cost))]
            continue
        move = np.clip(-np.linalg.solve(bend, [bx, by]), -2.0, 2.0)
        place = np.clip(centre + move * step, low, high)
        sd = float(step[0] * np.sqrt(2 * np.linalg.inv(bend)[0, 0]))
        if np.abs(move).max() < 1:
            step = step / 2
    return float(place[0]), float(place[1]), min(sd, one[3])


def _velocity_px_s(points_px: Array, times_s: Array) -> Array:
    """Velocity of each point, (T, N, 2) px/s: derivative of a cubic spline through the frames, 0 beside gaps.

    Registered points are good to some hundredths of a pixel, so they are interpolated and not smoothed: differences
    over several frames would cut the corners of a hand's tremor, and the shutter would come out longer than it is.
    """
    velocity = np.zeros_like(points_px)
    for stretch in stretches(times_s, GAP_S):
        if len(stretch) < 4:
            continue
        clock = times_s[stretch]
        kept = _apart(clock, 0.5 * float(np.median(np.diff(clock))))
        if len(kept) >= 4:
            spline = CubicSpline(clock[kept], points_px[stretch][kept])
            velocity[stretch] = spline(np.clip(clock, clock[kept[0]], clock[kept[-1]]), 1)
    return velocity


def _apart(clock: Array, least_s: float) -> list[int]:
    """Places of times that lie so far apart: a file may repeat a time, or hold two that nearly agree, and a spline
    through both would tell an endless velocity.
    """
    kept = [0]
    for place in range(1, len(clock)):
        if clock[place] - clock[kept[-1]] >= max(least_s, 1e-6):
            kept.append(place)
    return kept


def stretches(times_s: Array, gap_s: float) -> list[NDArray[np.int64]]:
    """Frames grouped into stretches without a gap of more than `gap_s`."""
    return np.split(np.arange(len(times_s)), np.flatnonzero(np.diff(times_s) > gap_s) + 1)


def _rising(times_s: Array) -> Array:
    """Times that rise strictly, as splines need; a file may repeat one."""
    return np.asarray(np.maximum.accumulate(times_s) + 1e-7 * np.arange(len(times_s)))


def smooth_camera(camera_mm: Array, times_s: Array, tangent_error: tuple[float, float]) -> Array:
    """Camera centres smoothed over time, (T, 3); tangent_error: of one frame, as `CameraFit` has it.

    The direction of the camera is noisy, its distance is not; so the tangents Cx/Cz and Cy/Cz and the distance are
    smoothed apart.  How much is chosen from the film itself by generalised cross-validation among a few cut-offs, none
    so low that a hand's own motion would be eaten.
    Convention: as `CameraFit`.
    Source: natural cubic smoothing spline (Woltring 1986 uses it for body motion the same way), whose response to a
    frequency f is 1 / (1 + (f / cut-off)^4).
    """
    clock = _rising(times_s)
    columns = np.column_stack([camera_mm[:, 0] / camera_mm[:, 2], camera_mm[:, 1] / camera_mm[:, 2], camera_mm[:, 2]])
    for stretch in stretches(times_s, GAP_S):
        if len(stretch) >= 8:
            for k in range(3):
                explained = EXPLAINED * tangent_error[k] if k < 2 else 0.0
                columns[stretch, k] = _smooth(clock[stretch], columns[stretch, k], explained)
    return np.column_stack([columns[:, 0] * columns[:, 2], columns[:, 1] * columns[:, 2], columns[:, 2]])


def _smooth(clock: Array, values: Array, explained: float) -> Array:
    """The smoothing spline of the lowest cut-off, if it leaves no more than `explained` (RMS).

    Else that of the cut-off which predicts left-out samples best.  Errors that last over some frames would deceive
    cross-validation, which takes them for motion; up to `explained` they are taken for errors.
    """
    count, length = len(clock), float(clock[-1] - clock[0])
    best: tuple[float, Array] | None = None
    for cut_off in CUT_OFFS_HZ:
        if cut_off > 0.5 * count / length:
            continue
        stiffness = count / length / (2 * np.pi * cut_off) ** 4
        course = np.asarray(make_smoothing_spline(clock, values, lam=stiffness)(clock))
        freedom = np.sum(1 / (1 + (np.arange(count) / (2 * length) / cut_off) ** 4))
        left = float(np.sum((values - course) ** 2))
        if cut_off == CUT_OFFS_HZ[0] and np.sqrt(left / count) <= explained:
            return course
        score = left / (1 - freedom / count) ** 2
        if best is None or score < best[0]:
            best = score, course
    return best[1] if best else values
