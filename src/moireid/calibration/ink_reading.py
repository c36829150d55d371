"""By how much a printer widens lines, from pictures of the strip on a pitch test sheet (`moireid.ink_strip`).

1. Count the grey levels of each patch, away from its borders.
2. Fit growth, tone curve, light along the strip and the ink's darkness to all patches at once.
3. Say that it cannot be known where the strip is too small or hidden, or does not fit.

A camera codes light by a tone curve that phones change from picture to picture, so a grey patch alone does not say how
much of it is inked.  A growth moves fine lines three times as far as coarse ones, and neither paper nor solid ink; the
tone curve moves all that are equally grey alike.  So both follow from the patches.

Convention: growth is of a whole line, both edges together, um, as `dots.ink_growth_mm`.  It includes the shadow that
ink casts within the paper (optical dot gain), as a lens sheet shows that too.
Source: nonlinear least squares; light of a patch = paper (1 - c) + ink c, c its share of ink (Murray and Davies, 1936);
    the tone curve is a power with an S-shaped term.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from moireid.badge import Badge
from moireid.ink_strip import InkPatch, ink_patches, strip_rect_mm
from moireid.verifier.picture import CODING_POWER

Array = NDArray[np.float64]
#: Pixels to a millimetre: with fewer, blur reaches the patches' inner parts; with more, each line shows, and a camera
#: that sharpens its picture widens or narrows it.  Samples to a pixel.
LEAST_PX_PER_MM, MOST_PX_PER_MM, SAMPLES_PER_PX = 2.0, 9.0, 3
#: Standard deviations of the tone curve's power about that of sRGB, of its S-shaped term, and of the light's slope and
#: bend along the strip.
POWER_SD, SHAPE_SD, LIGHT_SD = 0.35, 0.4, 0.2
#: Error of a patch's light as a share of the paper's, at least: paper and toner are uneven.
LEAST_NOISE = 0.004
#: Lines of other pitches may grow by other amounts than the fine ones, which are like a badge's: standard deviations of
#: the differences, um.  Set by hand; that of the coarse ones is large, as a camera that sharpens widens or narrows
#: lines that it resolves (`moireid lab bench ink-growth`: with 3 um the error is 8 um in place of 4).
COARSE_SD_UM, FINEST_SD_UM = 15.0, 6.0
#: A worse fit is no strip, as where a lens sheet covers it; solid ink must be this dark; the error bar this small, um.
MOST_MISFIT, MOST_INK_LIGHT, MOST_SD_UM = 0.03, 0.6, 12.0
#: Error of the growth in addition, um: of the printer's dots, and of the model.
FLOOR_SD_UM = 2.0
#: Of each patch of paper, at most this share may be overexposed.
MOST_CLIPPED_SHARE, CLIPPED = 0.05, 254
#: Growth that is searched, um; within what a printer profile holds.
RANGE_UM = (-60.0, 150.0)
#: The unknowns: growth, um; power and S-shaped term of the tone curve; light of ink over that of paper; level, slope
#: and bend of the light along the strip; how much more the coarse and the finest lines grow, um.  PRIOR: which of them
#: have one.
USUAL = np.array([30.0, 1.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 0.0])
BOUNDS = ([RANGE_UM[0], 0.3, -1.2, 0.0, 0.5, -1, -1, -30, -30], [RANGE_UM[1], 2.5, 1.2, 1.0, 1.5, 1, 1, 30, 30])
PRIOR = [1, 2, 5, 6, 7, 8]
PRIOR_SD = np.array([POWER_SD, SHAPE_SD, LIGHT_SD, LIGHT_SD, COARSE_SD_UM, FINEST_SD_UM])


@dataclass(frozen=True)
class InkGrowth:
    """Growth of a line, um, with its standard deviation; why: the reason where pictures do not show it, and um is None.

    misfit: root mean square of the patches about the fit, as a share of the paper's light; pictures: number used.
    """

    um: float | None = None
    sd_um: float = 0.0
    why: str = ""
    misfit: float = 0.0
    pictures: int = 0


def ink_growth(pictures: Sequence[tuple[NDArray[np.uint8], Array]], chart: Badge) -> InkGrowth:
    """The growth of lines, from one or more pictures.

    Parameters
    ----------
    pictures : sequence of (array (height, width), array (3, 3))
        Grey pictures at full size, each with its homography, page mm -> px.
    chart : Badge
        The pitch test sheet.

    Returns
    -------
    InkGrowth
        Of several pictures the median; they share their errors, so that more of them do not make the error bar smaller.

    Notes
    -----
    Convention, source: module docstring.
    """
    found = [_from_picture(luma, page, chart) for luma, page in pictures]
    read = [one for one in found if one.um is not None]
    if not read:
        return found[0] if found else InkGrowth(why="No picture shows the strip.")
    growths = np.array([one.um for one in read], float)
    scatter = 1.4826 * float(np.median(np.abs(growths - np.median(growths))))
    sd_um = max(float(np.median([one.sd_um for one in read])), scatter)
    misfit = float(np.median([one.misfit for one in read]))
    return InkGrowth(round(float(np.median(growths)), 1), round(sd_um, 1), "", misfit, len(read))


def _from_picture(luma: NDArray[np.uint8], page: Array, chart: Badge) -> InkGrowth:
    """The growth from one picture, or why it does not show it."""
    px_per_mm = _px_per_mm(page, chart)
    if px_per_mm < LEAST_PX_PER_MM:
        return InkGrowth(
            why=f"The strip has {px_per_mm:.1f} pixels to a millimetre, and {LEAST_PX_PER_MM:g} are needed: take a "
            "photo from nearer, or a photo in place of a film."
        )
    if px_per_mm > MOST_PX_PER_MM:
        return InkGrowth(
            why=f"The strip has {px_per_mm:.1f} pixels to a millimetre, and {MOST_PX_PER_MM:g} are the most, as "
            "cameras sharpen lines that they resolve: take a photo from farther away, about 1 m."
        )
    patches = ink_patches(chart)
    levels = [_levels(luma, page, patch, px_per_mm) for patch in patches]
    if any(one.sum() == 0 for one in levels):
        return InkGrowth(why="The strip is not wholly within the picture.")
    counts = np.array([one / one.sum() for one in levels])
    paper = counts[[patch.kind == "paper" for patch in patches]]
    if paper[:, CLIPPED:].sum(axis=1).max() > MOST_CLIPPED_SHARE:
        return InkGrowth(why="The paper is overexposed: take a darker photo.")
    return _fitted(counts, patches, float(paper.mean(axis=0) @ np.arange(256)))


def _px_per_mm(page: Array, chart: Badge) -> float:
    """Scale of the picture along the strip."""
    x0, y0, x1, y1 = strip_rect_mm(chart)
    ends = cv2.perspectiveTransform(np.array([[[x0, y0]], [[x1, y1]]]), page)
    return float(np.linalg.norm(ends[1] - ends[0])) / (x1 - x0)


def _levels(luma: NDArray[np.uint8], page: Array, patch: InkPatch, px_per_mm: float) -> Array:
    """How often each count occurs in the inner part of a patch, (256,); samples are dense, so pixels count by area."""
    x0, y0, x1, y1 = patch.inner_mm
    across, down = (max(2, round(SAMPLES_PER_PX * px_per_mm * size)) for size in (x1 - x0, y1 - y0))
    x, y = (low + (np.arange(n) + 0.5) / n * (high - low) for low, high, n in ((x0, x1, across), (y0, y1, down)))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 1, 2)
    places = np.rint(cv2.perspectiveTransform(points, page)[:, 0]).astype(int)
    inside = np.all((places >= 0) & (places < luma.shape[::-1]), axis=1)
    if not inside.all():
        return np.zeros(256)
    return np.bincount(luma[places[:, 1], places[:, 0]], minlength=256).astype(float)


def _tone(power: float, shape: float, paper_count: float) -> Array:
    """Light of each count, (256,), 1 at the paper's: a power of the coded light with an S-shaped term."""
    coded = np.maximum(np.arange(256) / paper_count, 1e-3) ** (CODING_POWER * power)
    return np.asarray(coded + shape * coded * (1 - coded) * (1 - 2 * coded))


def _fitted(counts: Array, patches: tuple[InkPatch, ...], paper_count: float) -> InkGrowth:
    """Growth and its error bar from the patches' shares of counts, (K, 256)."""
    places = np.linspace(-1, 1, len(patches))

    def apart(unknown: Array) -> Array:
        growth_um, power, shape, ink, level, slope, bend, coarse_um, finest_um = unknown
        grown_um = {"fine": growth_um, "coarse": growth_um + coarse_um, "finest": growth_um + finest_um}
        share = np.array([patch.ink_share(grown_um.get(patch.kind, 0.0) / 1000) for patch in patches])
        light = (level + slope * places + bend * places**2) * (1 - share * (1 - ink))
        seen = counts @ _tone(power, shape, paper_count)
        return np.concatenate([(seen - light) / LEAST_NOISE, (unknown - USUAL)[PRIOR] / PRIOR_SD])

    tried = [
        least_squares(apart, [start_um, *USUAL[1:]], bounds=BOUNDS, x_scale=[20, *6 * [0.2], 5, 5])
        for start_um in (10.0, 60.0)
    ]
    best = min(tried, key=lambda one: one.cost)
    rest = best.fun[: len(patches)]
    noise = max(1.0, float(np.sqrt(rest @ rest / (len(patches) - 7))))
    covariance = np.linalg.pinv(best.jac.T @ best.jac) * noise**2
    misfit = LEAST_NOISE * float(np.sqrt(np.mean(rest**2)))
    growth_um, sd_um = float(best.x[0]), float(np.hypot(np.sqrt(covariance[0, 0]), FLOOR_SD_UM))
    return _checked(growth_um, sd_um, misfit, float(best.x[3]))


def _checked(growth_um: float, sd_um: float, misfit: float, ink_light: float) -> InkGrowth:
    """The result, unless the fit shows that this is no strip or that it does not give the growth."""
    if misfit > MOST_MISFIT or ink_light > MOST_INK_LIGHT:
        return InkGrowth(
            why="The lowest row of patches does not look as printed: keep the lens sheet, hands and shadows off it, "
            "and print this version's pitch test.",
            misfit=misfit,
        )
    if sd_um > MOST_SD_UM or not RANGE_UM[0] < growth_um < RANGE_UM[1]:
        return InkGrowth(
            why=f"The patches leave an error of {sd_um:.0f} um, and {MOST_SD_UM:g} are allowed: take a sharp, evenly "
            "lit photo from about 1 m.",
            misfit=misfit,
        )
    return InkGrowth(growth_um, sd_um, "", misfit, 1)
