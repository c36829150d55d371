"""What is the same in all frames of a film: focal length, rolling-shutter time, distortion, and the print's shape.

1. The print's aspect alone, and then the page's twist: each hides all else.
2. In which direction does the shutter run through the picture?  Tested at its usual time.
3. Shutter time alone, then focal length alone, each from its prior.
4. All together.
5. If the focal length is far from its prior, estimate it again on a steady camera path (`smoothing`).
6. If a tremor hides between the frames, rows are less precise than they seem: estimate all again with that slack.
Convention: as `fit`; distortion is estimated in units of the usual focal length, and returned in units of the found
    one; unknowns in the order of `FilmWide`.
Source: maximum a posteriori over reprojection error.
"""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.distortion import MIDDLE, TakenIn
from moireid.verifier.camera.fast_poses import NearPoses
from moireid.verifier.camera.known_camera import KnownCamera
from moireid.verifier.camera.map_search import SPARE_PER_FRAME, Unknown, minimise, posterior, repeated, step_together
from moireid.verifier.camera.page_shape import lifted_px
from moireid.verifier.camera.page_speed import hidden_speed_px_s, jumps, lengthened_px, velocity_px_s
from moireid.verifier.camera.plane_pose import (
    ClosedForm,
    PlanePoses,
    closed_form,
    moved_poses,
    point_error_px,
    start_poses,
    tangent_error,
)
from moireid.verifier.camera.smoothing import SPARE, steady_errors_px
from moireid.verifier.measuring import (
    AXIS_MAX_SHARE,
    AXIS_PRIOR_SD_SHARE,
    DISTORTION_MAX,
    DISTORTION_PRIOR_SD,
    FOCAL_FAR_SDS,
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
    TWIST_AT_LIMIT_SHARE,
    TWIST_MAX_PER_M,
    TWIST_PRIOR_SD_PER_M,
)

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
#: A joint search moves by at most this many steps from settled poses, and then starts again from its result; until it
#: moves by less than this share of a step; most repetitions: the valley of focal length and distortion is long.
NEARBY_STEPS, SETTLED, MOST_SETTLED = 2.0, 0.05, 60
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
#: Another start is tried if its axis is this far from the middle, in long sides, or its pixels are stretched by so
#: much, and if it leaves at most so many times what the search from the middle left.
AXIS_FAR_SHARE, STRETCH_FAR_LOG, NEARLY_AS_GOOD = 0.03, 0.004, 2.0
#: A print's aspect hides all else if the errors fall to this share, or less, once it is taken away.
HIDING_SHARE = 0.7
#: A focal length is near the guessed one up to this change of its logarithm.
USUAL_ZOOM = 0.1
#: Places of the distortion and of the axis among the unknowns.
BEND_AT, AXIS_AT = slice(2, 4), slice(4, 6)
#: Share of an unknown's step used for finite differences.
PROBE = 0.05
#: A hidden tremor counts from this share of the mean square of what is left; more than this share it cannot be, as
#: registration has noise of its own.  Set by hand.
LEAST_HIDDEN, MOST_HIDDEN = 0.1, 0.75
#: From here on errors count as repeated; less is within the scatter of independent ones.
LEAST_REPEATED = 1.2
#: Most frames used to estimate the film-wide unknowns.
SOLVE_FRAMES = 300
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


class FilmWide:
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
        focal_px: float | None,
        known: KnownCamera | None = None,
    ) -> None:
        """Parameters: as `fit.fit_camera`."""
        self._known, self._long_side = known is not None, max(image_px)
        if known is not None:
            focal_px = known.focal * self._long_side
        self._points, self._times = points_px, times_s
        self._middle = (image_px[0] - 1) / 2.0, (image_px[1] - 1) / 2.0
        #: Where the optical axis meets the picture, from its middle, in long sides of the picture.
        self.axis = np.zeros(2)
        #: Logarithm of a pixel's width over its height; points are made square with it.
        self.stretch, self._stretched = 0.0, False
        self.print_aspect = 0.0
        #: Twist of a page that is seen not to be flat, 1/m, and what 1/m moves the points by (`page_shape`).
        self.twist, self._twisted, self._lifted = 0.0, False, np.zeros_like(points_px)
        #: Whether the focal length is that of a steady path.
        self._steadied = False
        self.plane = np.column_stack([page_mm - page_mm.mean(axis=0), np.zeros(len(page_mm))])
        #: Frames before which the picture jumps, (T,).
        self.cuts = jumps(points_px / (focal_px or FOCAL_PRIOR_RATIO * self._long_side), times_s)
        self._velocity = velocity_px_s(points_px, times_s, self.cuts)
        apart = (points_px - points_px.mean(axis=1, keepdims=True)) / np.array(image_px, float)
        # Programs rotate films, so the shutter may run down, right, up or left.
        self._directions: list[Array] = [apart[..., 1:2], apart[..., 0:1], -apart[..., 1:2], -apart[..., 0:1]]
        self._rows = self._directions[0]
        pictures = different_pictures(points_px)
        some = np.linspace(0, len(pictures) - 1, min(SOLVE_FRAMES, len(pictures))).astype(int)
        self._chosen: Numbers = pictures[np.unique(some)]
        self._given = focal_px is not None
        self._usual = FOCAL_PRIOR_RATIO * self._long_side
        self._guess = focal_px or self._usual
        self._bends = TakenIn(points_px, self._usual)
        self._longer = lengthened_px(points_px, self.plane[:, :2])
        self.focal, self.shutter_s, self.bend = float(self._guess), SHUTTER_PRIOR_S, np.zeros(2)
        if known is not None:
            self._take(known)
        start_px = points_px[self._chosen] if known is None else self._flat(self._chosen)
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
    def bend_k1(self) -> float:
        """Radial distortion in units of the focal length found (OpenCV's k1)."""
        return float(self.bend[0] - MIDDLE * self.bend[1]) * (self.focal / self._usual) ** 2

    @property
    def bend_k1_sd(self) -> float:
        """Standard deviation of `bend_k1`."""
        apart = np.array([1.0, -MIDDLE])
        variance = float(apart @ self.covariance[BEND_AT, BEND_AT] @ apart)
        return math.sqrt(variance) * (self.focal / self._usual) ** 2

    def solve(self) -> FilmWide:
        """The likeliest of the solutions from the picture's middle and from the closed forms."""
        self._solve_from_the_middle()
        tried = [self, *(found for camera in self._other_starts() if (found := self._solved_from(camera)) is not None)]
        scale = min(float(np.median(film._errors())) for film in tried) or 1e-9

        def cost(film: FilmWide) -> float:
            return film._cost(scale)

        best = min(tried, key=cost)
        # Another direction of the shutter than the usual one may come from what was not yet solved then.
        sure = best._steadied or best._rows is best._directions[0]
        best = best if sure else min((best, best._rolled_down()), key=cost)
        if not best._twisted:
            best._untwist()
            if best._twisted:
                best._solve_again()
        if abs(best.twist) > TWIST_AT_LIMIT_SHARE * TWIST_MAX_PER_M:
            best.twist, best._twisted = 0.0, False
            best._solve_again()
        best._count_once()
        best._loosen()
        return best

    def _untwist(self) -> None:
        """Take a page's twist for a start that takes much of the errors away, and solve it from then on; less may be
        noise.
        """
        self._lift(self._chosen, self._start)
        found, _ = minimise(lambda x: self._errors(twist=x), *TWIST.alone)
        left, before = (float(np.median(self._errors(twist=x))) for x in (found, 0.0))
        self._twisted = left < HIDING_SHARE * before and abs(found) < TWIST_AT_LIMIT_SHARE * TWIST_MAX_PER_M
        self.twist = found if self._twisted else 0.0

    def _lift(self, frames: NDArray[np.int64] | slice, poses: PlanePoses) -> None:
        """Compute what a twist does to these frames' points, at their poses."""
        self._lifted = self._lifted.copy()
        self._lifted[frames] = lifted_px(self.plane, poses, self.focal, self._bends, frames)

    def _count_once(self) -> None:
        """Estimate all again, with errors that last over some frames counted once; nothing, where few do."""
        before = self._at()
        points, focal, centre = self._seen(before, [], before[[]])
        repeats = repeated(self._near.residuals_px(points, focal / self._start_focal, focal, centre))
        if repeats < LEAST_REPEATED:
            return
        self._repeats = repeats
        self._solve_again()

    def _solve_again(self) -> None:
        """Estimate all again; a focal length of a steady path stays, with its error bar."""
        zoom_variance = self.covariance[0, 0]
        self._solve_together(zoom=not self._steadied)
        if self._steadied:
            self.covariance[0, 0] = zoom_variance

    def _loosen(self) -> None:
        """Give the rows the slack that a hidden tremor needs, and estimate all again; nothing, where that is little.

        Source: method of moments.  What is left of a page's fit is noise, and what the poses could not follow of the
            tremor; as `hidden_speed_px_s` may be too large, the tremor is at most `MOST_HIDDEN` of it.
        """
        rows = self._apart(self._chosen)
        none = np.zeros_like(rows)
        left = [self._near.following_px(np.stack(pair, axis=-1)) for pair in ((rows, none), (none, rows))]
        kept = float(np.median((np.square(left).sum(axis=(0, 2))) / 2))
        moved_px = hidden_speed_px_s(self._points, self._times, self.cuts) * self.shutter_s
        error_px = point_error_px(self._start, len(self.plane)) or 1e-9
        hidden = min(MOST_HIDDEN, kept * (moved_px / error_px) ** 2)
        if hidden < LEAST_HIDDEN:
            return
        self._hidden_sds = math.sqrt(hidden / (1 - hidden) / kept)
        self._solve_again()

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

    def _rolled_down(self) -> FilmWide:
        """The solution for a shutter that runs down, searched from this one."""
        film = copy.copy(self)
        film._rows = film._directions[0]
        if not self._known:
            film.bend, film.axis = np.zeros(2), np.zeros(2)
        film._solve_together()
        return film

    def _other_starts(self) -> list[ClosedForm]:
        """Cameras to search from again: the guess, and those of the closed form that leave little, if they are far.

        None where the camera is known, or the page twisted, which closed forms take for flat.
        """
        if self._known or self._twisted:
            return []
        points = (self._flat(self._chosen, bend=np.zeros(2), stretch=0.0) - self._middle) / self._long_side
        found = [closed_form(points, self.plane[:, :2], square=square) for square in (True, False)]
        most = NEARLY_AS_GOOD * float(np.median(self._errors()))
        # The focal length was first searched alone, with the axis in the middle, and may be caught in a valley there.
        caught = not self._steadied and abs(math.log(self.focal / self._guess)) > USUAL_ZOOM
        starts = [ClosedForm(np.zeros(2), self._guess / self._long_side, 1.0)] if caught else []
        for camera in found:
            if camera is not None and self._far(camera):
                # With a free aspect, noise shortens the closed form's focal length; the guess may be nearer.
                usual = replace(camera, focal=self._guess / self._long_side)
                start = min((camera, usual), key=self._left_by)
                starts += [start] if self._left_by(start) < most else []
        return starts

    def _solved_from(self, camera: ClosedForm) -> FilmWide:
        """Another solution, searched from a camera."""
        film = copy.copy(self)
        film.axis, film.stretch, film.focal = camera.axis, math.log(camera.aspect), self._guess
        film._stretched = abs(film.stretch) > STRETCH_FAR_LOG
        if not self._given:
            least, most = (ratio * self._long_side for ratio in FOCAL_RANGE_RATIO)
            film.focal = float(np.clip(camera.focal * self._long_side, least, most))
        film.shutter_s, film.bend, film.covariance = SHUTTER_PRIOR_S, np.zeros(2), np.zeros((9, 9))
        film.print_aspect = 0.0
        film._start = start_poses(film.plane, film._flat(film._chosen), film.focal, film._centre)
        film._start_focal, film._near = film.focal, NearPoses(film.plane, film._start)
        if film._stretched:
            # The closed form's is off by some thousandths, which hides the shutter.
            near = replace(STRETCH.near(film.stretch, NEARBY_STEPS), prior=film.stretch, prior_sd=STRETCH_MAX_LOG)
            film.stretch, _ = minimise(lambda x: film._errors(shutter_s=0.0, stretch=x), *near.alone)
        # Where the camera is not yet right, the direction of the shutter is estimated badly, so it is tested again.
        for _ in range(2):
            before, film._rows = film._rows, film._likeliest_rows()
            film._solve_together()
            if film._rows is before:
                break
        return film

    def _cost(self, scale_px: float) -> float:
        """Twice the negative logarithm of the posterior, as the joint search has it."""
        misfit = SPARE_PER_FRAME / self._repeats * float(np.sum(np.log1p((self._errors() / scale_px) ** 2)))
        free, at = self._free(), self._at()
        return misfit + sum(float(self._unknowns()[k].cost(at[k])) for k in free)

    def _unknowns(self) -> list[Unknown]:
        """All that a joint search may solve: focal length, shutter, distortion, axis x and y, stretch, print aspect."""
        return [self._zoom(), SHUTTER, *BENDS, ASIDE, ASIDE, STRETCH, PRINT, TWIST]

    def _free(self, *, zoom: bool = True) -> list[int]:
        """Which of the unknowns are solved: not a focal length that was given.

        A stretched picture and a print of another aspect look alike but where the camera rolls.  Where the picture is
        far from square, all of it is the picture's, since prints are not.  Of a known camera, none is solved.
        """
        page = [8] if self._twisted else []
        if self._known:
            return [1, 7, *page]
        return [*([0] if zoom and not self._given else []), *range(1, 7), *([] if self._stretched else [7]), *page]

    def _at(self) -> Array:
        """The unknowns as they are estimated now, (9,)."""
        camera = (math.log(self.focal), self.shutter_s, *self.bend, *self.axis, self.stretch)
        return np.array([*camera, self.print_aspect, self.twist])

    def _far(self, camera: ClosedForm) -> bool:
        """Whether a camera is far from a usual one, and possible."""
        aside, stretch = float(np.abs(camera.axis).max()), abs(math.log(camera.aspect))
        return (
            (aside > AXIS_FAR_SHARE or stretch > STRETCH_FAR_LOG)
            and aside < AXIS_MAX_SHARE
            and stretch < STRETCH_MAX_LOG
        )

    def _left_by(self, camera: ClosedForm) -> float:
        """Median reprojection error with a camera, px."""
        points = self._flat(self._chosen, bend=np.zeros(2), stretch=math.log(camera.aspect))
        poses = start_poses(self.plane, points, camera.focal * self._long_side, self._placed(camera.axis))
        return float(np.median(poses.least_error_px))

    def _zoom(self) -> Unknown:
        """The focal length's logarithm."""
        least, most = (math.log(ratio * self._long_side) for ratio in FOCAL_RANGE_RATIO)
        return Unknown(least, most, math.log(self._guess), FOCAL_PRIOR_SD_LOG, 0.06)

    def _solve_from_the_middle(self) -> None:
        """Steps 1 to 5."""
        middle, zoom = math.log(self._guess), self._zoom().alone
        self._unhide()  # 1
        self._untwist()
        self._rows = self._likeliest_rows()  # 2
        self.shutter_s, _ = minimise(lambda s: self._errors(shutter_s=s), *SHUTTER.alone)  # 3
        if not self._given:
            log_focal, _ = minimise(lambda x: self._errors(log_focal=x), *zoom)
            self.focal = math.exp(log_focal)
            if abs(log_focal - middle) > USUAL_ZOOM:
                # Far from the guessed focal length all shutter directions look alike, so the direction is tested again.
                self._rows, self.shutter_s = self._likeliest_rows(), SHUTTER_PRIOR_S
        self._solve_together()  # 4
        if not self._given and abs(math.log(self.focal) - middle) > FOCAL_FAR_SDS * FOCAL_PRIOR_SD_LOG:
            self._solve_steadily(zoom)  # 5

    def _unhide(self) -> None:
        """Take a print's aspect for a start that takes much of the errors away; less may be noise."""
        found, _ = minimise(lambda x: self._errors(shutter_s=0.0, print_aspect=x), *PRINT.alone)
        left, before = (float(np.median(self._errors(shutter_s=0.0, print_aspect=x))) for x in (found, 0.0))
        self.print_aspect = found if left < HIDING_SHARE * before else 0.0

    def _solve_together(self, *, zoom: bool = True) -> None:
        """Estimate all unknowns by repeated joint searches; zoom: the focal length too, if it was not given."""
        free = self._free(zoom=zoom)
        unknowns = [self._unknowns()[k] for k in free]
        for _ in range(MOST_SETTLED):
            self._settle()
            before = self._at()

            usual = float(np.median(self._errors())) or 1e-9
            near = [one.near(at, NEARBY_STEPS) for one, at in zip(unknowns, before[free], strict=True)]
            residuals, slopes = partial(self._residuals, before, free), self._slopes(before, free)
            found, covariance = step_together(residuals, slopes, before[free], near, usual, self._repeats)
            place = before.copy()
            place[free] = found
            if 0 in free:
                self.focal = math.exp(place[0])
            self.shutter_s, self.bend, self.axis = float(place[1]), place[BEND_AT], place[AXIS_AT]
            self.stretch, self.print_aspect, self.twist = (float(value) for value in place[6:])
            self.covariance = np.zeros((9, 9))
            self.covariance[np.ix_(free, free)] = covariance
            if np.all(np.abs(found - before[free]) < [SETTLED * one.step for one in near]):
                break

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

    def _solve_steadily(self, zoom: tuple[float, float, float, float]) -> None:
        """Estimate the focal length on a steady path; if it changes, estimate the rest again."""
        found = math.log(self.focal)

        def errors(log_focal: float) -> Array:
            focal, points = math.exp(log_focal), self._flat(self._chosen)
            poses = self._moved_poses(points, focal, self._centre)
            return steady_errors_px(poses, self.plane, points, self._times[self._chosen], focal, self._centre)

        log_focal, log_sd = posterior(errors, *zoom, SPARE)
        if abs(log_focal - found) < FOCAL_FAR_SDS * FOCAL_PRIOR_SD_LOG:
            return
        self.focal, self._steadied = math.exp(log_focal), True
        self._solve_together(zoom=False)
        self.covariance[0], self.covariance[:, 0] = 0.0, 0.0
        self.covariance[0, 0] = log_sd**2

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

    def of_points(self, points_px: Array) -> FilmWide:
        """The same camera for other points (T, N, 2)."""
        film = copy.copy(self)
        film._points, film._velocity = points_px, velocity_px_s(points_px, self._times, self.cuts)
        film._bends = TakenIn(points_px, self._usual)
        film._longer = lengthened_px(points_px, self.plane[:, :2])
        slack = self._slack(self._chosen)
        film._start = start_poses(self.plane, film._flat(self._chosen), self.focal, self._centre, slack)
        film._start_focal, film._near = self.focal, NearPoses(self.plane, film._start, slack)
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

    def _likeliest_rows(self) -> Array:
        """The likeliest direction of the shutter, tested at its usual time."""
        tried = []
        for direction in self._directions:
            self._rows = direction
            tried.append(self._errors(shutter_s=SHUTTER_PRIOR_S))
        scale = min(float(np.median(errors)) for errors in tried) or 1e-9
        return self._directions[int(np.argmin([np.sum(np.log1p((errors / scale) ** 2)) for errors in tried]))]
