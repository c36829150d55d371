"""Registering the known page: the homography that makes the picture's markers match the printed ones.

Corners use only a small part of a marker.  Here every edge of every module counts.  So the tilt is more precise, and
registration still works where a marker no longer decodes.

Source: inverse compositional alignment (Baker and Matthews, Lucas-Kanade 20 Years On, 2004), with a gain and an offset
    of brightness estimated in each marker.  Deviation: the template is drawn from the badge file and not taken from a
    frame, so nothing drifts.  The loop is in the kernel (`registration.c`); the limits are here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Fiducial
from moireid.verifier.kernel.page import (
    ALL_SEEN,
    LOOSE,
    PagePrint,
    Points,
    RulesStruct,
    values_at,
)
from moireid.verifier.picture import Picture, as_picture
from moireid.verifier.tracking.borders import Borders
from moireid.verifier.tracking.print_template import Template, TemplatePrinter, printer_of
from moireid.verifier.tracking.search_work import SOLVED_NS, STEP_NS

Array = NDArray[np.float64]
#: Steps in which the page must be found; as many more may settle it.
MAX_STEPS = 12
#: No marker in sight after so many steps: it is given up.  On simulated films pages that are found show one within
#: three.
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
#: Prints of so many samples, four markers of 32 px, bring a page within this first, px, by every second one of their
#: samples along and across.
COARSE_FROM, NEAR_PX = 4096, 0.5
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
#: What the kernel needs of these.
RULES = RulesStruct(
    MAX_STEPS,
    HOPELESS_STEPS,
    BENT_SEEN_STEPS,
    BENT_STEPS,
    STOP_PX,
    LEFT_SHARE,
    MIN_CORRELATION,
    MIN_GAIN,
    COVERED_LEFT,
    COVERED_LEFT_RATIO,
)


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
        #: The template that was drawn last.
        self.last: Template | None = None

    def at(self, homography: Array) -> Template:
        """The template at about the scale and the slant of a homography."""
        scales, kept = scales_px_per_mm(homography, self._printer.middle), self.last
        if not (
            kept
            and all(one / SCALE_STEP < now < one * SCALE_STEP for one, now in zip(kept.scales, scales, strict=True))
        ):
            kept = self.last = self._printer.draw(*scales)
        return kept


class PageRegistrar:
    """Registers pages of one layout; between frames it keeps only `work_ns`, the work of all registrations."""

    def __init__(self, fiducial: Fiducial | TemplatePrinter, borders: Borders | None = None) -> None:
        """Parameters: borders: of the badge's gratings; they help if only two markers are visible."""
        self._borders = borders
        self.printer = fiducial if isinstance(fiducial, TemplatePrinter) else printer_of(fiducial)
        self.work_ns = 0.0
        self._least_seen = math.ceil(MIN_SHARE * len(self.printer.patches))
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
        template = template or self.printer.draw(*scales_px_per_mm(start, self._middle))
        picture, shown = as_picture(picture), self._prepared(template)
        state, page = shown.follow(picture.struct, np.ascontiguousarray(start, np.float64))
        return self._outcome(picture, template, state, page)

    def _prepared(self, template: Template) -> PagePrint:
        shown = self._print_of(template)
        if shown.is_prepared:
            return shown
        gradient, coarse = template.gradient() * np.float32(self._extent), None
        # A smeared print serves one frame, too few for another print.
        if shown.samples >= COARSE_FROM and not template.smeared:
            few = template.samples.every_second
            printed = [template.values[part] - template.values[part].mean() for part in few]
            first = [0, *np.cumsum([len(part) for part in few]).tolist()]
            every = np.concatenate(few)
            coarse = self._new_print(template, Points(template.samples.points[every]), first, printed)
            coarse.prepare(gradient[:, every])
        shown.prepare(gradient, coarse, NEAR_PX)
        self.work_ns += SOLVED_NS * shown.samples
        return shown

    def _outcome(self, picture: Picture, template: Template, state: int, page: Array) -> Registration | None:
        """What `PagePrint.follow` has found; of a page that the visible patches do not hold, by its borders."""
        shown = self._print_of(template)
        self.work_ns += STEP_NS * shown.compared
        if not state:
            return None
        correlation, contrast, vague = shown.correlation, shown.contrast, (1.0, 1.0)
        if state & LOOSE:
            # With two markers on one side the page can still tilt about them, so the pose is useless without the
            # borders. A smeared border cannot help: its displacement would follow the smear.
            held = None if template.smeared else self._held_by_borders(picture, page, template, shown.seen)
            if held is None:
                return None
            page, correlation, vague, contrast = held
        elif not state & ALL_SEEN:
            every = (True,) * shown.patches
            vague = _ratios(*(_tilt_sd(shown.normal(seen)) for seen in (shown.seen, every)))
        return Registration(page, correlation, vague, contrast) if correlation >= MIN_CORRELATION else None

    def _print_of(self, template: Template) -> PagePrint:
        """The template as the kernel takes it; kept with the template."""
        if template.kept_print is None:
            samples = template.samples
            template.kept_print = self._new_print(template, samples.places, samples.first, template.printed)
        return template.kept_print

    def _new_print(
        self, template: Template, places: Points, first: Sequence[int], printed: Sequence[NDArray[np.float32]]
    ) -> PagePrint:
        return PagePrint(
            places,
            first,
            [-1 if patch.side is None else patch.side for patch in self.printer.patches],
            np.concatenate(printed),
            least_seen=self._least_seen,
            squares=SQUARES,
            middle=self._middle,
            extent=self._extent,
            px_per_mm=template.px_per_mm,
            rules=RULES,
            least_correlation=SMEARED_CORRELATION if template.smeared else MARKER_CORRELATION,
        )

    def _held_by_borders(
        self, picture: Picture, page: Array, template: Template, seen: tuple[bool, ...]
    ) -> tuple[Array, float, tuple[float, float], float] | None:
        """The page from two markers and the gratings' borders, correlation, vagueness and contrast; None without
        borders.
        """
        borders, shown = self._borders, self._print_of(template)
        if borders is None or sum(seen) != 2:
            return None
        warp = page @ self._to_page
        places = Points(((borders.places - self._middle) / self._extent).reshape(-1, 2))
        freed, prior = (
            np.zeros_like(borders.freedom_sd),
            np.diag([*np.zeros(8), *(BORDER_NOISE / borders.freedom_sd) ** 2]),
        )
        used = np.array(seen)[template.samples.patch]
        normal = np.zeros_like(prior)
        for _ in range(MAX_STEPS):
            residual, edges = shown.compare(picture.struct, warp), values_at(picture.struct, warp, places)
            if residual is None or edges is None or shown.seen != seen:
                return None
            contrast = shown.contrast
            brightness = edges.astype(float).reshape(borders.inward.shape)
            found = borders.equations(brightness, freed, self._middle, self._extent, template.px_per_mm, contrast)
            if found is None:
                return None
            rows, right = found
            normal = prior + rows.T @ rows
            normal[:8, :8] += shown.normal(seen)
            side = rows.T @ right - prior @ np.append(np.zeros(8), freed)
            side[:8] += shown.free @ np.where(used, residual, np.float32(0.0))
            step = np.linalg.lstsq(normal, side, rcond=None)[0]
            moved = _stepped(warp, step[:8])
            if moved is None:
                return None
            warp, freed = moved, freed + step[8:]
            if np.abs(step[:8]).max() * self._extent * template.px_per_mm < STOP_PX:
                break
        every, homography = (True,) * len(seen), warp @ self._from_page
        if not np.all(np.isfinite(homography)):
            return None
        vague = _ratios(_tilt_sd(normal), _tilt_sd(shown.normal(every)))
        return homography / homography[2, 2], shown.correlation, vague, contrast

    def residuals(
        self, picture: Picture | NDArray[Any], homography: Array, template: Template
    ) -> tuple[Array | None, tuple[bool, ...]]:
        """Picture less print under this homography (None outside the picture), and which markers are visible."""
        shown = self._print_of(template)
        residual = shown.compare(as_picture(picture).struct, homography @ self._to_page)
        if residual is None:
            return None, (False,) * len(self.printer.patches)
        return residual.astype(float), shown.seen


def _tilt_sd(normal: Array) -> Array:
    """Standard deviations (2,) of a warp's two tilts, for noise of one unit in each sample, from a normal matrix."""
    return np.asarray(np.sqrt(np.diag(np.linalg.pinv(normal))[6:8]))


def _ratios(found: Array, least: Array) -> tuple[float, float]:
    """One over the other, and at least 1."""
    x, y = np.maximum(found / least, 1.0)
    return float(x), float(y)


def _stepped(warp: Array, step: Array) -> Array | None:
    """The warp after a step of its eight parameters, h33 = 1; None if the step folds the page."""
    a, b, c, d, e, f, g, h = step.tolist()
    stepped = np.array(((1 + a, b, c), (d, 1 + e, f), (g, h, 1)))
    if not np.linalg.det(stepped):
        return None
    moved = warp @ np.linalg.inv(stepped)
    return np.asarray(moved / moved[2, 2])


def scale_px_per_mm(homography: Array, place_mm: Array) -> float:
    """Pixels per millimetre around a place of the page: the square root of the area scale."""
    (x, y), (g, h, i) = place_mm.tolist(), homography[2].tolist()
    # The Jacobian determinant of a homography is det(H) / w^3.
    return math.sqrt(abs(float(np.linalg.det(homography)) / (g * x + h * y + i) ** 3))


def scales_px_per_mm(homography: Array, place_mm: Array) -> tuple[float, float, float]:
    """`scale_px_per_mm`, and px per mm along x and y of the page, by which a picture blurs edges across these.

    Source: blur that is round in the picture has the covariance (J' J)^-1 on the page, J the Jacobian there.
    """
    x, y = place_mm.tolist()
    (a, b, c), (d, e, f), (g, h, i) = homography.tolist()
    w = g * x + h * y + i
    u, v = (a * x + b * y + c) / w, (d * x + e * y + f) / w
    xx, xy, yx, yy = (a - g * u) / w, (b - h * u) / w, (d - g * v) / w, (e - h * v) / w
    area = abs(xx * yy - xy * yx)
    return math.sqrt(area), area / math.hypot(xy, yy), area / math.hypot(xx, yx)
