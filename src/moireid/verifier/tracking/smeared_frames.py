"""Following a badge through frames that motion has smeared, where no marker decodes and the sharp print does not match.

1. Where is the page?  Repeat its last motion, for a few frames at most.
2. How is it smeared?  Along that motion, by its speed times the exposure, which is learnt over the film.
3. Search the smeared markers around that place of the page, all four by one shift.
4. Register the page with them.  The residual shows whether the smear should be longer, shorter or rotated; repeat step
4 until that no longer changes.

Convention: smears are in page mm, one per patch, symmetric about the middle of the exposure, so that a frame's pose is
    the one at this moment.
Source: normalised cross-correlation for step 3; step 4 as `register`.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.verifier.picture import Picture, as_picture
from moireid.verifier.tracking.patch_search import sought
from moireid.verifier.tracking.print_template import MOST_MODULES, Template, without_gains
from moireid.verifier.tracking.registration import (
    FOLLOWED_CORRELATION,
    KeptTemplate,
    PageRegistrar,
    Registration,
    scale_px_per_mm,
)
from moireid.verifier.tracking.track import FrameSighting, TrackEnds

Array = NDArray[np.float64]
#: A badge that was lost for longer must be found again by its markers.
LOST_S = 0.25
#: Radius of the search around the expected place, in modules, a thirtieth of a second after it was seen, and growth for
#: each thirtieth more.
REACH_MODULES, REACH_MORE, REACH_S = 4.0, 2.0, 1 / 30
#: A page that is expected this many times as large or as small as it last was, is expected by a false motion.
MOST_GROWTH = 2.0
#: Mean correlation of the patches below which another smear is tried, and below which the page is given up.
UNSURE, SOUGHT = 0.65, 0.4
#: A page is not searched again if its smear changes by less than this, in modules.  Step 4 is not repeated from this
#: correlation on, once the exposure is known: a smear is symmetric, so its length moves no page.  Not from a lower one:
#: a page that correlates by 0.03 less than usual is taken for covered (`limits.COVERED_CORRELATION`).
SAME_MODULES, WELL_SMEARED = 0.25, 0.98
#: Exposures to try while none is known, as a share of the time between two frames; the middling one first.
FIRST_SHARES = (0.35, 0.15, 0.7)
#: Weight of a new frame in the learnt exposure, and number of repetitions of step 4.
LEARNT, STEPS = 0.3, 3
#: Largest change of a smear's length (as a share) and of its direction (rad) in one step of step 4.
MOST_CHANGE = 0.4
#: Step 4 ends when the smear changes by less than this.
SETTLED = 0.1
PROBE = 0.1


class ShakenFollower:
    """Follows one badge through smeared frames; its only memory is the exposure."""

    def __init__(self, registrar: PageRegistrar, template: KeptTemplate, ends: TrackEnds) -> None:
        """Parameters: template, ends: of the badge, kept by its tracker."""
        self._registrar, self._template, self._ends = registrar, template, ends
        self._centers = registrar.printer.centers_mm
        self._module_mm = registrar.printer.module_mm
        self.exposure_s: float | None = None  #: Estimated from the film so far.

    def find(self, luma: Picture | NDArray[np.uint8], time_s: float) -> Registration | None:
        """The page in a smeared frame; None if it is not found near its expected place."""
        before, last = self._ends.before, self._ends.last
        if before is None or last is None or not 0 < time_s - last.time_s <= LOST_S:
            return None
        expected, lost = _expected(before, last, time_s)
        grown = self._scale(expected) / self._scale(last.page)
        if not 1 / MOST_GROWTH < grown < MOST_GROWTH:
            return None
        light = as_picture(luma).in_light
        frame_s = (time_s - last.time_s) / lost
        tried = [self.exposure_s] if self.exposure_s else [share * frame_s for share in FIRST_SHARES]
        best, best_s = None, 0.0
        for exposure_s in tried:
            found = self._registered(light, (before, last), expected, exposure_s, time_s)
            if found is None:
                # Nothing there looks like a smeared page, so another smear would not either.
                break
            if found[0] is not None and (best is None or found[0].correlation > best.correlation):
                best, best_s = found
        if best is not None and best.correlation >= FOLLOWED_CORRELATION:
            known_s = self.exposure_s or best_s
            self.exposure_s = (1 - LEARNT) * known_s + LEARNT * best_s
        return best

    def _scale(self, page: Array) -> float:
        return scale_px_per_mm(page, self._registrar.printer.middle)

    def _velocity(self, past: tuple[FrameSighting, FrameSighting], page: Array, time_s: float) -> Array:
        """Velocity (K, 2) of the patches, page mm/s, if `page` is the present homography."""
        before, last = past
        now = self._way(last.page, page) / (time_s - last.time_s)
        then = self._way(before.page, last.page) / max(last.time_s - before.time_s, 1e-6)
        # A difference gives the velocity half a frame ago, so it is extrapolated.
        return np.asarray(1.5 * now - 0.5 * then) if time_s - last.time_s < 0.1 else now

    def _way(self, one: Array, other: Array) -> Array:
        """Displacement of the patches from one frame to another, (K, 2) page mm."""
        back = np.linalg.inv(other) @ one
        return np.asarray(
            self._centers - cv2.perspectiveTransform(self._centers.reshape(-1, 1, 2), back).reshape(-1, 2)
        )

    def _registered(
        self,
        light: Picture,
        past: tuple[FrameSighting, FrameSighting],
        expected: Array,
        exposure_s: float,
        time_s: float,
    ) -> tuple[Registration | None, float] | None:
        """Steps 3 and 4 with one exposure.

        Returns: the page, and the exposure estimated from its smear; None if step 3 finds nothing.
        """
        since_s, place = time_s - past[1].time_s, expected
        reach = REACH_MODULES + REACH_MORE * max(since_s / REACH_S - 1, 0.0)
        smear = self._smear(past, expected, time_s, exposure_s)
        for _ in range(2):
            score, place = sought(self._registrar, light, expected, self._smeared(expected, smear), reach)
            if score < UNSURE:
                still = sought(self._registrar, light, expected, self._template.at(expected), reach)
                score, place = max((score, place), still, key=lambda found: found[0])
            if score < SOUGHT:
                return None
            # The place found gives the velocity, and with it the smear.
            before, smear = smear, self._smear(past, place, time_s, exposure_s)
            if np.abs(smear - before).max() < SAME_MODULES * self._module_mm:
                break
        return self._settled(light, place, smear, exposure_s)

    def _settled(
        self, light: Picture, place: Array, smear: Array, exposure_s: float
    ) -> tuple[Registration | None, float]:
        """Step 4 from a place and a smear; returns the page and the exposure, as `_registered`."""
        best: Registration | None = None
        best_s, tried_s = exposure_s, exposure_s
        for _ in range(STEPS):
            template = self._smeared(place, smear)
            found = self._registrar.register(light, place, template)
            if found is None or (best is not None and found.correlation <= best.correlation):
                break
            best, place, best_s = found, found.homography, tried_s
            if self.exposure_s and found.correlation >= WELL_SMEARED:
                break
            growth, turn = self._change(light, place, template, smear)
            if max(abs(growth), abs(turn)) < SETTLED:
                break
            c, s = math.cos(turn), math.sin(turn)
            smear, tried_s = self._limited((1 + growth) * smear @ np.array([[c, s], [-s, c]])), (1 + growth) * tried_s
        return best, best_s

    def _smear(
        self, past: tuple[FrameSighting, FrameSighting], place: Array, time_s: float, exposure_s: float
    ) -> Array:
        """Smear (K, 2) of the patches, page mm, if `place` is the present homography."""
        return self._limited(exposure_s * self._velocity(past, place, time_s))

    def _smeared(self, place: Array, smear: Array) -> Template:
        return self._registrar.printer.smeared(self._template.at(place), smear)

    def _limited(self, smear: Array) -> Array:
        longest = float(np.linalg.norm(smear, axis=1).max())
        return np.asarray(smear * min(1.0, MOST_MODULES * self._module_mm / max(longest, 1e-9)))

    def _change(self, light: Picture, place: Array, template: Template, smear: Array) -> tuple[float, float]:
        """Share by which the smear should be longer, and angle by which it should be rotated, rad."""
        residual, seen = self._registrar.residuals(light, place, template)
        if residual is None:
            return 0.0, 0.0
        turned = smear @ np.array([[math.cos(PROBE), math.sin(PROBE)], [-math.sin(PROBE), math.cos(PROBE)]])
        others = [self._registrar.printer.smeared(template, other) for other in ((1 + PROBE) * smear, turned)]
        if any(len(other.values) != len(template.values) for other in others):
            return 0.0, 0.0
        rows = np.stack([(other.values - template.values) / PROBE for other in others])
        used = np.array(seen)[template.samples.patch]
        rows = np.where(used, without_gains(rows, template.samples.parts, template.values), 0.0)
        normal = rows @ rows.T
        change = np.linalg.solve(normal + 1e-9 * np.trace(normal) * np.eye(2) + 1e-12 * np.eye(2), rows @ residual)
        change = np.clip(change, -MOST_CHANGE, MOST_CHANGE)
        return float(change[0]), float(change[1])


def _expected(before: FrameSighting, last: FrameSighting, time_s: float) -> tuple[Array, int]:
    """The expected homography, and how many frames ago the page was last seen."""
    if last.time_s - before.time_s > LOST_S:
        # It has just come back, so its motion is not known yet.
        return last.page, 1
    between = max(last.time_s - before.time_s, 1e-6)
    lost = max(1, round((time_s - last.time_s) / between))
    moved = last.page
    # A hand turns back within some frames, so the motion is repeated at most twice.
    for _ in range(min(lost, 2)):
        moved = moved @ np.linalg.inv(before.page) @ last.page
    return np.asarray(moved / moved[2, 2]), lost
