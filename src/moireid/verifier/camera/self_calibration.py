"""Solve what is the same in all frames: focal length, rolling-shutter time, distortion, and the print's shape.

1. The print's aspect alone, and then the page's twist: each hides all else.  They are starts; some frames are enough.
2. In which direction does the shutter run through the picture?  Tested at its usual time.
3. All together, from a lens without distortion and from a barrel.
4. If the focal length is far from its prior, estimate it again on a steady camera path (`smoothing`).
5. If a tremor hides between the frames, rows are less precise than they seem: estimate all again with that slack.
6. If the axis ran off, as the film does not show it, estimate all again with it in the middle.
7. Error bars cover the other solutions, as far as the film leaves them likely.
Convention: as `film_camera`.
Source: maximum a posteriori over reprojection error.
"""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.fast_poses import NearPoses
from moireid.verifier.camera.film_camera import AXIS_AT, BEND_AT, PRINT, STRETCH, TWIST, FilmCamera
from moireid.verifier.camera.map_search import SPARE_PER_FRAME, minimise, posterior, repeated, step_together
from moireid.verifier.camera.page_speed import hidden_speed_px_s
from moireid.verifier.camera.plane_pose import ClosedForm, closed_form, point_error_px, start_poses
from moireid.verifier.camera.smoothing import SPARE, steady_errors_px
from moireid.verifier.limits import MAX_LASTING_PX
from moireid.verifier.measuring import (
    AXIS_MAX_SHARE,
    FOCAL_FAR_SDS,
    FOCAL_PRIOR_SD_LOG,
    FOCAL_RANGE_RATIO,
    SHUTTER_PRIOR_S,
    STRETCH_MAX_LOG,
    TWIST_AT_LIMIT_SHARE,
    TWIST_MAX_PER_M,
)

Array = NDArray[np.float64]
#: A joint search moves by at most this many steps from settled poses, and then starts again from its result; until it
#: moves by less than this share of a step; most repetitions: the valley of focal length and distortion is long.
NEARBY_STEPS, SETTLED, MOST_SETTLED = 2.0, 0.05, 60
#: Another start is tried if its axis is this far from the middle, in long sides, or its pixels are stretched by so
#: much, and if it leaves at most so many times what the search from the middle left.
AXIS_FAR_SHARE, STRETCH_FAR_LOG, NEARLY_AS_GOOD = 0.03, 0.004, 2.0
#: A print's aspect, or an axis off the middle, is no noise if the errors fall to this share, or less, by it.
HIDING_SHARE = 0.7
#: Distortions to search from, as minima of one are far from the other, and beyond which a search has come to where the
#: other begins: none, and a webcam's barrel.  From either of them, and the guessed focal length, k1 of -0.4 to 0.2 and
#: focal lengths of 0.5 to 1.6 long sides are found.
BENDS_TRIED = ((0.0, math.inf), (-0.3, -0.15))
#: A hidden tremor counts from this share of the mean square of what is left; more than this share it cannot be, as
#: registration has noise of its own.  Set by hand.
LEAST_HIDDEN, MOST_HIDDEN = 0.1, 0.75
#: From here on errors count as repeated; less is within the scatter of independent ones.
LEAST_REPEATED = 1.2


class FilmWide(FilmCamera):
    """A film's camera that is solved by maximum a posteriori, step by step as above."""

    def solve(self) -> FilmWide:
        """The likeliest of the solutions from the picture's middle and from the closed forms."""
        tried = self._solved_from_the_middle()
        tried += [tried[0]._solved_from(camera) for camera in tried[0]._other_starts()]
        best = _likeliest(tried)[0]
        # Another direction of the shutter than the usual one may come from what was not yet solved then.
        if not (best._steadied or best._rows is best._directions[0]):
            tried.append(best._rolled_down())
            best = _likeliest(tried)[0]
        if not best._twisted:
            few = best.of_fewer()
            few._untwist()
            best._begin_from(few)
            if best._twisted:
                best._solve_again()
        if abs(best.twist) > TWIST_AT_LIMIT_SHARE * TWIST_MAX_PER_M:
            best.twist, best._twisted = 0.0, False
            best._solve_again()
        best._count_once()
        best._loosen()
        if best._astray():
            middle = copy.copy(self)
            middle._centred = True
            middle = middle.solve()
            left, free = (float(np.median(film._errors())) for film in (middle, best))
            if left < max(MAX_LASTING_PX / 2, free / HIDING_SHARE):
                return middle
        best._cover([film for film in tried if film is not best])
        return best

    def _astray(self) -> bool:
        """Whether the axis is far from the middle, and the film does not show its lens.

        A page that is seen from the front and never turns shows neither lens nor axis, and far from the axis poses have
        more freedom to follow errors of some thousandths of a pixel; the fringes would be predicted from aside.  A turn
        of a tenth of a degree may show the axis, though not the lens: then the middle leaves more of the corners.
        """
        if self._known or np.abs(self.axis).max() < AXIS_FAR_SHARE:
            return False
        any_lens = copy.copy(self)
        if self._given:
            any_lens._given, any_lens._guess = False, self._usual
            any_lens._solve_together()
        return any_lens.parallel

    def _begin_from(self, few: FilmWide) -> None:
        """Take over what was estimated from fewer frames, as a start."""
        for name in ("print_aspect", "twist", "_twisted"):
            setattr(self, name, getattr(few, name))

    def _untwist(self) -> None:
        """Take a page's twist for a start that takes much of the errors away, and solve it from then on; less may be
        noise.
        """
        self._lift(self._chosen, self._start)
        found, _ = minimise(lambda x: self._errors(twist=x), *TWIST.alone)
        left, before = (float(np.median(self._errors(twist=x))) for x in (found, 0.0))
        self._twisted = left < HIDING_SHARE * before and abs(found) < TWIST_AT_LIMIT_SHARE * TWIST_MAX_PER_M
        self.twist = found if self._twisted else 0.0

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

    def _rolled_down(self) -> FilmWide:
        """The solution for a shutter that runs down, searched from this one."""
        film = copy.copy(self)
        film._rows = film._directions[0]
        if not self._known:
            film.bend, film.axis = np.zeros(2), np.zeros(2)
        film._solve_together()
        return film

    def _other_starts(self) -> list[ClosedForm]:
        """Cameras to search from again: those of the closed form that leave little, if they are far.

        None where the camera is known, or the page twisted, which closed forms take for flat.
        """
        if self._known or self._twisted:
            return []
        points = (self._flat(self._chosen, bend=np.zeros(2), stretch=0.0) - self._middle) / self._long_side
        found = [closed_form(points, self.plane[:, :2], square=square) for square in (True, False)]
        most = NEARLY_AS_GOOD * float(np.median(self._errors()))
        starts = []
        for camera in found:
            if camera is not None and self._centred:
                camera = replace(camera, axis=np.zeros(2))
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
        film._solve_with_rows()
        return film

    def _cost(self, scale_px: float) -> float:
        """Twice the negative logarithm of the posterior, as the joint search has it."""
        misfit = SPARE_PER_FRAME / self._repeats * float(np.sum(np.log1p((self._errors() / scale_px) ** 2)))
        free, at = self._free(), self._at()
        return misfit + sum(float(self._unknowns()[k].cost(at[k])) for k in free)

    def _free(self, *, zoom: bool = True) -> list[int]:
        """Which of the unknowns are solved: not a focal length that was given.

        A stretched picture and a print of another aspect look alike but where the camera rolls.  Where the picture is
        far from square, all of it is the picture's, since prints are not.  Of a known camera, none is solved.
        """
        page = [8] if self._twisted else []
        if self._known:
            return [1, 7, *page]
        axis = [] if self._centred else [4, 5]
        return [*([0] if zoom and not self._given else []), 1, 2, 3, *axis, 6, *([] if self._stretched else [7]), *page]

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

    def _solved_from_the_middle(self) -> list[FilmWide]:
        """The solutions by steps 1 to 4, the likeliest first."""
        few = self.of_fewer()
        few._unhide()  # 1
        few._untwist()
        self._begin_from(few)
        tried = []
        for bend, most in ((None, math.inf),) if self._known else BENDS_TRIED:
            film = copy.copy(self)
            film.bend, film._most_bend = self.bend if bend is None else np.array([bend, 0.0]), most
            film._solve_with_rows()  # 2, 3
            if film.bend[0] <= most:
                film._most_bend = math.inf
                tried.append(film)
        tried = _likeliest(tried)
        far = abs(math.log(tried[0].focal / self._guess)) > FOCAL_FAR_SDS * FOCAL_PRIOR_SD_LOG
        if not self._given and far:
            tried[0]._solve_steadily(self._zoom().alone)  # 4
        # The misfit of free tilts, from which the others come, is none of a steady path's.
        return tried[:1] if tried[0]._steadied else tried

    def _solve_with_rows(self) -> None:
        """Estimate all together; where the camera is not yet right, the direction of the shutter is estimated badly, so
        it is tested again.
        """
        for _ in range(2):
            before, self._rows = self._rows, self._likeliest_rows()
            self._solve_together()
            if self._rows is before or self.bend[0] > self._most_bend:
                break

    def _cover(self, others: list[FilmWide]) -> None:
        """Let the error bars cover the other solutions, as far as the film leaves them likely.

        Source: variance of a mixture of two, by their posteriors, with errors that last counted once.
        """
        for film in others:
            film._repeats = self._repeats
            scale = min(float(np.median(one._errors())) for one in (self, film)) or 1e-9
            share = 1 / (1 + math.exp(min(0.5 * (film._cost(scale) - self._cost(scale)), 50.0)))
            apart = np.where(np.diag(self.covariance) > 0, film._at() - self._at(), 0.0)
            self.covariance += share * np.outer(apart, apart)

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
            settled = np.all(np.abs(found - before[free]) < [SETTLED * one.step for one in near])
            if settled or self.bend[0] > self._most_bend:
                break

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

    def _likeliest_rows(self) -> Array:
        """The likeliest direction of the shutter, tested at its usual time."""
        tried = []
        for direction in self._directions:
            self._rows = direction
            tried.append(self._errors(shutter_s=SHUTTER_PRIOR_S))
        scale = min(float(np.median(errors)) for errors in tried) or 1e-9
        return self._directions[int(np.argmin([np.sum(np.log1p((errors / scale) ** 2)) for errors in tried]))]


def _likeliest(films: list[FilmWide]) -> list[FilmWide]:
    """Solutions of one film, the likeliest first."""
    scale = min(float(np.median(film._errors())) for film in films) or 1e-9
    return sorted(films, key=lambda film: film._cost(scale))
