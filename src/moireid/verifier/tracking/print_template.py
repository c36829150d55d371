"""The printed patches as a picture shows them: brightness at sample places, and its change as the page moves.

Motion during the exposure smears the print in a frame.  The template is smeared in the same way, so that a shaken frame
is registered at the middle of the smear.

Convention: places in units of the patches' extent about their middle, so that a warp's eight parameters are of like
    size.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Fiducial
from moireid.verifier.kernel.fitting import smeared_means
from moireid.verifier.kernel.page import PagePrint, Points
from moireid.verifier.tracking.patches import Patch, module_of, patches_of
from moireid.verifier.tracking.search_work import DRAWN_NS, SMEAR_STEP_NS, SMEARED_NS

Array = NDArray[np.float64]
Single = NDArray[np.float32]
#: White kept around a patch, in modules; the grating begins 1.05 modules away.
BORDER_MODULES, FREE_MODULES = 0.7, 1.05
#: Standard deviation of the picture's own blur, px: the pixel's box (0.29), demosaicing, lens and codec.
BLUR_PX = 0.8
#: Samples along a square's side: at least this many; more than this add nothing; and along a part of a frame.
SIDE_SAMPLES, LONG_SAMPLES = (24, 96), (48, 240)
#: The print is drawn with this many fine samples per sample of the template, of which every half sample is kept.
FINE = 8
#: Longest smear, in modules; with a longer one, a marker of six modules is a grey spot.
MOST_MODULES = 3.0


@dataclass(frozen=True)
class PatchDrawing:
    """The patches, drawn: sample pitch of the template, mm; samples down and across of each patch; the border around
    them, in samples; each patch's brightness at whole and at half samples, (2, 2, rows, columns) with the border, and
    its gradient along x, and along y, per mm.

    samples: those of all patches, by how many each has; smears of many frames share them.
    """

    pitch_mm: float
    counts: tuple[tuple[int, int], ...]
    border: int
    pictures: tuple[Single, ...]
    along_x: tuple[Single, ...]
    along_y: tuple[Single, ...]
    samples: dict[tuple[int, ...], Samples] = field(default_factory=dict)

    @cached_property
    def grids(self) -> list[tuple[list[float], list[float]]]:
        """Places of each patch's columns, and of its rows, from its middle, mm."""
        return [(self._offsets(columns), self._offsets(rows)) for rows, columns in self.counts]

    def _offsets(self, count: int) -> list[float]:
        return [(k + 0.5 - count / 2 + 0.5 / FINE) * self.pitch_mm for k in range(count)]


@dataclass(frozen=True)
class Samples:
    """Where the patches are sampled: points (N, 2) of the page; those of each patch are `shapes` rows and columns of
    its drawing, and `corners` the first row and column.

    Convention: one patch's samples after another's.
    """

    points: Array
    corners: tuple[tuple[int, int], ...]
    shapes: tuple[tuple[int, int], ...]

    @cached_property
    def places(self) -> Points:
        """The points, as the kernel takes them."""
        return Points(self.points)

    @cached_property
    def count(self) -> NDArray[np.int64]:
        """Number of samples of each patch, (K,)."""
        return np.array([rows * columns for rows, columns in self.shapes])

    @cached_property
    def patch(self) -> NDArray[np.int64]:
        """The patch of each sample, (N,)."""
        return np.repeat(np.arange(len(self.count)), self.count)

    @cached_property
    def first(self) -> list[int]:
        """Where each patch's samples begin, and where the last one's end."""
        return [0, *np.cumsum(self.count).tolist()]

    @cached_property
    def every_second(self) -> list[NDArray[np.int64]]:
        """Every second sample of each patch, along and across."""
        numbers = zip(np.split(np.arange(len(self.points)), self.first[1:-1]), self.shapes, strict=True)
        return [part.reshape(shape)[::2, ::2].ravel() for part, shape in numbers]

    @cached_property
    def parts(self) -> tuple[slice, ...]:
        """Samples of each patch."""
        return tuple(slice(*ends) for ends in pairwise(self.first))


@dataclass
class Template:
    """Sample places, their printed brightness and its gradient.

    printed: values of each patch about their mean, (n,); gradient: gives the gradient (2, N) of the values, per mm;
    extent: a unit of the points, mm; scales: as `draw`; drawing: the source of values and gradient; smeared: whether
    motion smear is drawn; kept_print: as the kernel takes it, made when it is needed.
    """

    samples: Samples
    values: Single
    printed: list[Single]
    gradient: Callable[[], Single]
    extent: float
    scales: tuple[float, float, float]
    drawing: PatchDrawing
    smeared: bool = False
    kept_print: PagePrint | None = None

    @property
    def px_per_mm(self) -> float:
        """Of the area."""
        return self.scales[0]


def printer_of(fiducial: Fiducial) -> TemplatePrinter:
    """The printer of a fiducial's templates."""
    return TemplatePrinter(patches_of(fiducial), module_of(fiducial))


class TemplatePrinter:
    """Draws templates of one page at any scale; between them it keeps only `work_ns`, the work of all of them."""

    def __init__(self, patches: Sequence[Patch], module_mm: float) -> None:
        """Parameters: module_mm: width of the finest printed detail that counts."""
        self.patches, self.module_mm = tuple(patches), module_mm
        self.centers_mm = np.array([patch.center_mm for patch in self.patches])
        self.middle = self.centers_mm.mean(axis=0)
        self.extent = float(np.abs(self.centers_mm - self.middle).max())
        self.work_ns = 0.0

    def draw(self, px_per_mm: float, across: float | None = None, down: float | None = None) -> Template:
        """The patches at about one sample per pixel, blurred like a picture.

        Parameters: across, down: px per mm along x and y, where the page is slanted, as `scales_px_per_mm`.
        """
        scales = px_per_mm, across or px_per_mm, down or px_per_mm
        return self._sampled(scales, self._drawn(*scales), None)

    def smeared(self, template: Template, smear_mm: Array) -> Template:
        """The same template, smeared by motion.

        Parameters: smear_mm (K, 2): displacement of each patch during the exposure, page mm.
        """
        steps = _smear_steps(float(np.linalg.norm(smear_mm, axis=1).max()), template.drawing.pitch_mm)
        self.work_ns += len(template.values) * (SMEARED_NS + SMEAR_STEP_NS * steps)
        return self._sampled(template.scales, template.drawing, smear_mm)

    def _sampled(self, scales: tuple[float, float, float], drawing: PatchDrawing, smear_mm: Array | None) -> Template:
        smears = np.zeros((len(self.patches), 2)) if smear_mm is None else smear_mm
        samples = self._samples(drawing, smears)
        shown = _all_smeared(drawing.pictures, drawing, samples, smears)
        return Template(
            samples=samples,
            values=np.concatenate(shown),
            printed=[part - part.mean() for part in shown],
            gradient=partial(_gradient, drawing, samples, smears),
            extent=self.extent,
            scales=scales,
            drawing=drawing,
            smeared=smear_mm is not None,
        )

    def _samples(self, drawing: PatchDrawing, smears: Array) -> Samples:
        """Where the patches are sampled under smears (K, 2) mm; one drawing has few such sets, so each is kept."""
        kept = []
        for patch, grid, length in zip(self.patches, drawing.grids, np.hypot(*smears.T).tolist(), strict=True):
            # Beyond the white border lies the grating; a smear mixes it in.
            white = min(BORDER_MODULES, max(FREE_MODULES - length / self.module_mm / 2, 0.0)) * self.module_mm
            limits = [half + white for half in patch.half_mm]
            kept.append([_first_and_end(places, limit) for places, limit in zip(grid, limits, strict=True)])
        # Rectangles about one middle: as many samples are the same samples.
        shapes = tuple((bottom - top, right - left) for (left, right), (top, bottom) in kept)
        counts = tuple(rows * columns for rows, columns in shapes)
        if counts not in drawing.samples:
            points = []
            for ends, (across, down), center in zip(kept, drawing.grids, self.centers_mm, strict=True):
                own = np.meshgrid(across[slice(*ends[0])], down[slice(*ends[1])])
                points.append(np.column_stack([part.ravel() for part in own]) + center)
            corners = tuple((top + drawing.border, left + drawing.border) for (left, _), (top, _) in kept)
            drawing.samples[counts] = Samples((np.concatenate(points) - self.middle) / self.extent, corners, shapes)
        return drawing.samples[counts]

    def _drawn(self, px_per_mm: float, across: float, down: float) -> PatchDrawing:
        reaches = [[half + BORDER_MODULES * self.module_mm for half in patch.half_mm] for patch in self.patches]
        longest = max(max(reach) for reach in reaches)
        limits = SIDE_SAMPLES if longest == min(min(reach) for reach in reaches) else LONG_SAMPLES
        count = int(np.clip(2 * longest * px_per_mm, *limits))
        pitch_mm = 2 * longest / count
        blurs = [BLUR_PX / scale / pitch_mm * FINE for scale in (across, down)]
        border = math.ceil(MOST_MODULES / 2 * self.module_mm / pitch_mm) + 1
        drawn, counts = [], []
        for patch, reach in zip(self.patches, reaches, strict=True):
            picture = patch.print(*(_fine_offsets(half, pitch_mm) for half in reach))
            drawn.append(tuple(_phases(one, border) for one in _blurred(picture, blurs, pitch_mm / FINE)))
            counts.append((picture.shape[0] // FINE, picture.shape[1] // FINE))
            self.work_ns += DRAWN_NS * picture.size
        pictures, along_x, along_y = zip(*drawn, strict=True)
        return PatchDrawing(pitch_mm, tuple(counts), border, pictures, along_x, along_y)


def _blurred(picture: Single, blurs: Sequence[float], pitch_mm: float) -> tuple[Single, Single, Single]:
    """A print of rectangles, blurred, and its gradients along x and y, per mm, at whole and half samples.

    Parameters: blurs: standard deviations across and down, fine samples; pitch_mm: of the fine samples.
    Source: a print has few different rows and columns, and a Gaussian blur is one along each axis, so what shows each
        of these is blurred, and no picture.
    """
    down, rows = _distinct(picture)
    across, cells = _distinct(rows.T)
    (by_column, turns_column), (by_row, turns_row) = (
        _blurred_line(which, blur, pitch_mm) for which, blur in zip((across, down), blurs, strict=True)
    )
    by_cell, turns_cell = by_row @ cells.T, turns_row @ cells.T
    products = (by_cell @ by_column.T, by_cell @ turns_column.T, turns_cell @ by_column.T)
    shown, along_x, along_y = (np.asarray(product, np.float32) for product in products)
    return shown, along_x, along_y


def _distinct(picture: Single) -> tuple[NDArray[np.int64], Single]:
    """For each row, which of the rows that differ from the one before it shows; and these rows."""
    begins = np.concatenate([[True], np.any(picture[1:] != picture[:-1], axis=1)])
    return np.cumsum(begins) - 1, picture[begins]


def _blurred_line(which: NDArray[np.int64], blur: float, pitch_mm: float) -> tuple[Single, Single]:
    """Share (n, K) of each of K parts in a blurred line, at whole and half samples, and its change per mm.

    Parameters: which: the part that each fine sample shows.
    """
    shares = (which == np.arange(which[-1] + 1)[:, None]).astype(np.float32)
    # As many samples as OpenCV takes for a blur of floating point numbers.
    kernel = cv2.getGaussianKernel(round(8 * blur + 1) | 1, blur, cv2.CV_32F)
    shares = np.asarray(
        cv2.sepFilter2D(shares, -1, kernel, np.ones((1, 1), np.float32), borderType=cv2.BORDER_REPLICATE)
    )
    halves = slice(None, None, FINE // 2)
    return shares[:, halves].T, np.gradient(shares, pitch_mm, axis=1)[:, halves].T


def _phases(halves: Single, border: int) -> Single:
    """A drawing at whole and half samples down and across, (2, 2, rows, columns), with a border around it, which
    goes on as the drawing ends.

    Convention: whole samples are the fine ones of number `FINE` / 2 and every `FINE`-th from there.
    """
    before, behind = 2 * border - 1, 2 * border + 1
    wide = np.asarray(
        cv2.copyMakeBorder(
            np.ascontiguousarray(halves, np.float32), before, behind, before, behind, cv2.BORDER_REPLICATE
        )
    )
    rows, columns = (size // 2 for size in wide.shape)
    return np.ascontiguousarray(wide.reshape(rows, 2, columns, 2).transpose(1, 3, 0, 2))


def _first_and_end(places: list[float], limit: float) -> tuple[int, int]:
    """Number of the first of some rising places less than a limit away from 0, and of the first beyond them."""
    return bisect_right(places, -limit), bisect_left(places, limit)


def _fine_offsets(half_mm: float, pitch_mm: float) -> Array:
    """Places of the fine samples along a side of half that length, from its middle, mm; a whole number of pitches."""
    count = max(round(2 * half_mm / pitch_mm), 1)
    whole = count * pitch_mm / 2
    # Rounding must move no sample over the edge of a module.
    begin = half_mm if math.isclose(whole, half_mm) else whole
    return np.asarray((np.arange(count * FINE) + 0.5) / FINE * pitch_mm - begin)


def _gradient(drawing: PatchDrawing, samples: Samples, smears: Array) -> Single:
    """Gradient (2, N) of smeared brightness along x and y, per mm."""
    both = drawing.along_x, drawing.along_y
    return np.stack([np.concatenate(_all_smeared(planes, drawing, samples, smears)) for planes in both])


def _all_smeared(planes: Sequence[Single], drawing: PatchDrawing, samples: Samples, smears: Array) -> list[Single]:
    """Means (n,) of each patch's drawing at its samples over the page's motion during the exposure."""
    found = []
    for phases, corner, shape, smear in zip(planes, samples.corners, samples.shapes, smears.tolist(), strict=True):
        across, down = (part / drawing.pitch_mm for part in smear)
        steps = _smear_steps(math.hypot(*smear), drawing.pitch_mm)
        found.append(smeared_means(phases, corner, shape, (across, down), steps))
    return found


def _smear_steps(smear_mm: float, pitch_mm: float) -> int:
    """Places at which a smeared print is drawn."""
    # The print is blurred already by most of a sample, so a step of a sample leaves no steps to be seen.
    return max(1, math.ceil(smear_mm / pitch_mm))


def warp_jacobian(place: NDArray[Any], gradient: NDArray[Any]) -> NDArray[Any]:
    """Change of printed brightness with each of the eight warp parameters, (8, N); place, gradient (2, N)."""
    (x, y), (gx, gy) = place, gradient
    inward = gx * x + gy * y
    return np.stack([gx * x, gx * y, gx, gy * x, gy * y, gy, -inward * x, -inward * y])


def without_gains(rows: NDArray[Any], parts: Sequence[slice], printed: NDArray[Any]) -> NDArray[Any]:
    """What of some rows (K, N) no patch's own gain and offset of brightness could make.

    Parameters: parts: samples of each patch, none of them empty.
    """
    free = np.empty_like(rows)
    for here in parts:
        mine, shown = rows[:, here], printed[here] - printed[here].mean()
        mine = mine - mine.mean(axis=1, keepdims=True)
        power = float(shown @ shown)
        if power > 0:
            mine -= np.outer(mine @ (shown / power), shown)
        free[:, here] = mine
    return free
