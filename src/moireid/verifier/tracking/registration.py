"""Registering the known page: the homography that makes the picture's markers match the printed ones.

Corners use only a small part of a marker.  Here every edge of every module counts.  So the tilt is more precise, and
registration still works where a marker no longer decodes.

Source: inverse compositional alignment (Baker and Matthews, Lucas-Kanade 20 Years On, 2004), with a gain and an offset
    of brightness estimated in each marker.  Deviation: the template is drawn from the badge file and not taken from a
    frame, so nothing drifts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Fiducial
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.borders import Borders
from moireid.verifier.tracking.print_template import Template, TemplatePrinter, printer_of, without_gains
from moireid.verifier.tracking.sampling import Places, Sampler, determinant, inverse
from moireid.verifier.tracking.search_work import SOLVED_NS, STEP_NS

Array = NDArray[np.float64]
#: Steps in which the page must be found; as many more may settle it.
MAX_STEPS = 12
#: No marker in sight after so many steps: it is given up.  On the films of `benchmarks/verify_speed.py`, pages that are
#: found show one within three.
HOPELESS_STEPS = 5
#: Where some patches seem hidden: steps after which all must be seen, and in which they must settle.
BENT_SEEN_STEPS, BENT_STEPS = 3, 8
#: Standard deviation of a sample at a border, in units of the markers' contrast.
BORDER_NOISE = 0.05
#: Iteration stops when no point of the page will move by more than this, px.
STOP_PX = 0.003
#: A step leaves at most a fifth of its own length, so one that is not yet below the limit may be the last.
#: Trap: it mostly leaves far less, but the correlation is that before the step, and small markers need it settled.
LEFT_SHARE = 0.2
#: Least correlation between picture and print.
MIN_CORRELATION = 0.80
#: A followed page needs a higher correlation than one whose markers were decoded (0.80), since it may be lost. Genuine
#: pages reach 0.93 and more at 3 m.
FOLLOWED_CORRELATION = 0.90
#: Standard deviation of camera noise and coding, counts.  It is the same for faint print, which therefore correlates
#: less even if it is placed well.  Standard deviation of a marker, as a share of its contrast.
NOISE_COUNTS, PRINT_SD = 1.5, 0.48
#: A patch is visible if it has this correlation with its print; this share of them must be, three of four
#: markers.  With 0.5, a grey patch over a marker would count as the marker, as its outline is similar.
MARKER_CORRELATION, MIN_SHARE = 0.7, 0.75
#: The limit in a smeared frame, which correlates less; there, leaving a marker out does more harm than a poor one.
SMEARED_CORRELATION = 0.5
#: Least contrast of a marker's black and white, in the picture's counts.
MIN_GAIN = 2.0
#: The template is drawn again when the picture's scale changes by more than this factor.
SCALE_STEP = 1.2
#: A patch of a frame counts as covered where the print leaves more than this share of its power unexplained, and so
#: many times what it leaves in the middle one of the patches.  Set by hand: a fingertip over a corner leaves a third in
#: the two patches next to it, and a hundredth to a tenth in the others.
SQUARES, COVERED_LEFT, COVERED_LEFT_RATIO = 4, 0.2, 4.0


@dataclass(frozen=True)
class Registration:
    """Homography page mm -> image px, (3, 3) with h33 = 1; correlation of picture and print over the markers.

    vague: standard deviation of the tilt along x and y over that with the whole fiducial visible; contrast: between
    black and white in the clearest marker, in the picture's own unit.
    """

    homography: Array
    correlation: float
    vague: tuple[float, float] = (1.0, 1.0)
    contrast: float = math.inf

    @property
    def clear(self) -> bool:
        """Whether a followed page, in a picture in counts, looks as much like the print as noise allows.

        Source: noise of s standard deviations of the print turns a correlation c into c', 1 / c'^2 = 1 / c^2 + s^2.
        """
        noise = NOISE_COUNTS / (PRINT_SD * self.contrast)
        return self.correlation >= 1 / math.hypot(1 / FOLLOWED_CORRELATION, noise)


class KeptTemplate:
    """The template of one badge, kept while its scale in the picture hardly changes."""

    def __init__(self, printer: TemplatePrinter) -> None:
        self._printer = printer
        self._kept: Template | None = None

    def at(self, homography: Array) -> Template:
        """The template at about the scale of a homography."""
        px_per_mm, kept = scale_px_per_mm(homography, self._printer.middle), self._kept
        if not (kept and kept.px_per_mm / SCALE_STEP < px_per_mm < kept.px_per_mm * SCALE_STEP):
            kept = self._kept = self._printer.draw(px_per_mm)
        return kept


class PageRegistrar:
    """Registers pages of one layout; between frames it keeps only `work_ns`, the work of all registrations."""

    def __init__(self, fiducial: Fiducial | TemplatePrinter, borders: Borders | None = None) -> None:
        """Parameters: borders: of the badge's gratings; they help if only two markers are visible."""
        self._borders = borders
        self.printer = fiducial if isinstance(fiducial, TemplatePrinter) else printer_of(fiducial)
        self.work_ns = 0.0
        self._least_seen = math.ceil(MIN_SHARE * len(self.printer.patches))
        sides = [patch.side for patch in self.printer.patches]
        # Without one of its sides a frame slides: what is next to it is taken for its line.
        self._sides = [[k for k, own in enumerate(sides) if own == side] for side in set(sides) - {None}]
        self._middle, self._extent = self.printer.middle, self.printer.extent
        # Warps are estimated in coordinates of about one, so that their eight parameters are of like size.
        self._to_page = np.array([[self._extent, 0, self._middle[0]], [0, self._extent, self._middle[1]], [0, 0, 1.0]])
        self._from_page = np.linalg.inv(self._to_page)

    def register(
        self, picture: Picture | NDArray[Any], start: Array, template: Template | None = None
    ) -> Registration | None:
        """Refine `start` on this frame; None if the page does not match.

        Parameters: template: at about the scale of `start`, smeared like the frame; None: draw a sharp one.
        Convention: as `MarkerFinder`.
        """
        template = template or self.printer.draw(scale_px_per_mm(start, self._middle))
        warp, sampler = start @ self._to_page, Sampler(picture)
        solved: tuple[bool, ...] = ()
        for steps in range(2 * MAX_STEPS + 1):
            values = sampler.at(warp, template.samples.places)
            if values is None:
                return None
            self.work_ns += STEP_NS * len(values)
            compared = _compared(values, template)
            correlation, seen, contrast = compared.correlation, compared.seen, compared.contrast
            # A page that is found but still moves goes on: where it is stopped, a marker may be off by a pixel.
            found = correlation >= MIN_CORRELATION and self._enough(seen)
            if steps == 2 * MAX_STEPS or (steps == MAX_STEPS and not found):
                break
            if steps == HOPELESS_STEPS and not any(seen):
                return None
            # Far from the right place all markers match badly; then all of them are used for the step.
            asked = seen if self._enough(seen) else (True,) * len(seen)
            if asked != solved:
                self.work_ns += SOLVED_NS * len(values) * (asked not in template.solvers)
                solved = asked
            step = compared.step(template, asked)
            moved = _stepped(warp, step)
            if moved is None:
                return None
            warp = moved
            if LEFT_SHARE * float(np.abs(step).max()) * self._extent * template.px_per_mm < STOP_PX:
                break
        if not all(seen) and (bent := self._with_all(sampler, warp, template)) is not None:
            warp, compared = bent
            correlation, seen, contrast = compared.correlation, compared.seen, compared.contrast
        vague = (1.0, 1.0)
        if not self._enough(seen):
            # With two markers on one side the page can still tilt about them, so the pose is useless without the
            # borders. A smeared border cannot help: its displacement would follow the smear.
            held = None if template.smeared else self._held_by_borders(sampler, warp, template, seen)
            if held is None:
                return None
            warp, correlation, vague, contrast = held
        elif not all(seen):
            vague = _ratios(template.tilt_sd(seen), template.tilt_sd((True,) * len(seen)))
        homography = warp @ self._from_page
        if not (correlation >= MIN_CORRELATION and np.all(np.isfinite(homography))):
            return None
        return Registration(homography / homography[2, 2], float(correlation), vague, contrast)

    def _with_all(self, sampler: Sampler, warp: Array, template: Template) -> tuple[Array, PatchComparison] | None:
        """The warp that all patches agree on, from one that some do not fit; None if there is none.

        On a page that is bent the others' plane misses a patch, which then seems hidden.
        """
        every = (True,) * len(self.printer.patches)
        for steps in range(BENT_STEPS):
            values = sampler.at(warp, template.samples.places)
            if values is None:
                return None
            self.work_ns += STEP_NS * len(values)
            compared = _compared(values, template)
            if steps >= BENT_SEEN_STEPS and not all(compared.seen):
                return None
            step = compared.step(template, every)
            if LEFT_SHARE * float(np.abs(step).max()) * self._extent * template.px_per_mm < STOP_PX:
                return (warp, compared) if all(compared.seen) else None
            moved = _stepped(warp, step)
            if moved is None:
                return None
            warp = moved
        return None

    def _enough(self, seen: tuple[bool, ...]) -> bool:
        """Whether the visible patches hold the page."""
        return sum(seen) >= self._least_seen and all(any(seen[k] for k in side) for side in self._sides)

    def _held_by_borders(
        self, sampler: Sampler, warp: Array, template: Template, seen: tuple[bool, ...]
    ) -> tuple[Array, float, tuple[float, float], float] | None:
        """The warp from two markers and the gratings' borders, correlation, vagueness and contrast; None without
        borders.
        """
        borders = self._borders
        if borders is None or sum(seen) != 2:
            return None
        places = Places(((borders.places - self._middle) / self._extent).reshape(-1, 2))
        freed, prior = (
            np.zeros_like(borders.freedom_sd),
            np.diag([*np.zeros(8), *(BORDER_NOISE / borders.freedom_sd) ** 2]),
        )
        used = np.array(seen)[template.samples.patch]
        free = without_gains(np.where(used, template.jacobian, 0.0), template.samples.parts, template.values)
        normal = np.zeros_like(prior)
        for _ in range(MAX_STEPS):
            values, edges = sampler.at(warp, template.samples.places), sampler.at(warp, places)
            if values is None or edges is None:
                return None
            compared = _compared(values, template)
            correlation, contrast = compared.correlation, compared.contrast
            if compared.seen != seen:
                return None
            brightness = edges.astype(float).reshape(borders.inward.shape)
            found = borders.equations(brightness, freed, self._middle, self._extent, template.px_per_mm, contrast)
            if found is None:
                return None
            rows, right = found
            normal = prior + rows.T @ rows
            normal[:8, :8] += free @ free.T
            side = rows.T @ right - prior @ np.append(np.zeros(8), freed)
            side[:8] += free @ np.where(used, compared.residual(template), 0.0)
            step = np.linalg.lstsq(normal, side, rcond=None)[0]
            moved = _stepped(warp, step[:8])
            if moved is None:
                return None
            warp, freed = moved, freed + step[8:]
            if np.abs(step[:8]).max() * self._extent * template.px_per_mm < STOP_PX:
                break
        return warp, correlation, self._vagueness(normal, template), contrast

    def _vagueness(self, normal: Array, template: Template) -> tuple[float, float]:
        """Standard deviations of the two tilts over those with all four markers, for the same noise."""
        whole = without_gains(template.jacobian.astype(float), template.samples.parts, template.values)
        least, found = (np.sqrt(np.diag(np.linalg.pinv(one))[6:8]) for one in (whole @ whole.T, normal))
        return _ratios(found, least)

    def residuals(
        self, picture: Picture | NDArray[Any], homography: Array, template: Template
    ) -> tuple[Array | None, tuple[bool, ...]]:
        """Picture less print under this homography (None outside the picture), and which markers are visible."""
        values = Sampler(picture).at(homography @ self._to_page, template.samples.places)
        if values is None:
            return None, (False,) * len(self.printer.patches)
        compared = _compared(values, template)
        return compared.residual(template), compared.seen


@dataclass(frozen=True)
class PatchComparison:
    """Picture and print, patch by patch: brightness about its mean (n,), counts, of each patch; its gain (K,); which
    patches are visible; the correlation over those; the contrast of the clearest, counts.

    A hidden patch is left out, as its cover has edges of its own.
    """

    centred: list[NDArray[np.float32]]
    gain: list[float]
    seen: tuple[bool, ...]
    correlation: float
    contrast: float

    def step(self, template: Template, asked: tuple[bool, ...]) -> Array:
        """Change of the warp's eight parameters that takes most of the residual away.

        Convention: a solver's rows are free of each marker's offset and of its print, so the brightness may be
            used as the residual.
        """
        step = np.zeros(8)
        for solver, own, gain in zip(template.solver(asked), self.centred, self.gain, strict=True):
            if gain > MIN_GAIN:
                step += (solver @ own) / gain
        return step

    def residual(self, template: Template) -> Array:
        """Picture less print (N,), in units of print contrast, with each marker's own gain and offset."""
        each = zip(self.centred, self.gain, template.printed, strict=True)
        left = [own / gain - printed if gain > MIN_GAIN else np.zeros_like(own) for own, gain, printed in each]
        return np.concatenate(left).astype(float)


def _compared(values: NDArray[np.float32], template: Template) -> PatchComparison:
    """The brightness (N,) at a template's places, against its print."""
    least = SMEARED_CORRELATION if template.smeared else MARKER_CORRELATION
    centred, gains, seen, fits = [], [], [], []
    # Four numbers each: Python's own arithmetic takes less time than NumPy's calls.
    for part, printed, power in zip(template.samples.parts, template.printed, template.power, strict=True):
        own = values[part] - np.add.reduce(values[part]) / (part.stop - part.start)
        along, most = float(printed @ own), math.sqrt(power * float(own @ own))
        centred.append(own)
        gains.append(along / power)
        # A washed-out marker must not be scaled up to full contrast.
        seen.append(along > MIN_GAIN * power and along >= least * most)
        fits.append((along, most))
    seen = _uncovered(seen, fits)
    explained = sum(along for (along, _), shown in zip(fits, seen, strict=True) if shown)
    whole = sum(most for (_, most), shown in zip(fits, seen, strict=True) if shown)
    return PatchComparison(centred, gains, tuple(seen), explained / whole if whole > 0 else 0.0, max(gains))


def _uncovered(seen: list[bool], fits: list[tuple[float, float]]) -> list[bool]:
    """The visible patches without those that a thumb covers in part; only a frame has enough to leave some out.

    Parameters: fits: of each patch, what the print explains, and what it would if it explained all.
    """
    if len(seen) <= SQUARES or not all(most > 0 for _, most in fits):
        return seen
    left = [1 - (along / most) ** 2 for along, most in fits]
    most_left = max(COVERED_LEFT, COVERED_LEFT_RATIO * sorted(left)[len(left) // 2])
    return [shown and own <= most_left for shown, own in zip(seen, left, strict=True)]


def _ratios(found: Array, least: Array) -> tuple[float, float]:
    """One over the other, and at least 1."""
    x, y = np.maximum(found / least, 1.0)
    return float(x), float(y)


def _stepped(warp: Array, step: Array) -> Array | None:
    """The warp after a step of its eight parameters, h33 = 1; None if the step folds the page."""
    a, b, c, d, e, f, g, h = step.tolist()
    back = inverse(np.array(((1 + a, b, c), (d, 1 + e, f), (g, h, 1))))
    if back is None:
        return None
    moved = warp @ back
    return np.asarray(moved / moved[2, 2])


def scale_px_per_mm(homography: Array, place_mm: Array) -> float:
    """Pixels per millimetre around a place of the page: the square root of the area scale."""
    (x, y), (g, h, i) = place_mm.tolist(), homography[2].tolist()
    # The Jacobian determinant of a homography is det(H) / w^3.
    return math.sqrt(abs(determinant(homography) / (g * x + h * y + i) ** 3))
