"""The strips of the grating that are read, and their brightness profiles in a frame.

A cell is read in strips across which the fringes are averaged.  A strip is at most 10 mm high: a twist of 0.3 degrees
between sheet and page turns the phase by 0.065 rad/mm, so a taller one would wash its own fringes out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.errors import SpecError
from moireid.frames import OwnFrame, own_rect
from moireid.layers import is_smooth
from moireid.smooth_lines import cell_rows, rims_mm
from moireid.verifier.kernel.page import PageRows, Points
from moireid.verifier.picture import Picture, as_picture
from moireid.verifier.tracking.edge_spread import EdgeReader

MAX_STRIP_MM = 10.0
#: Margin left out at a cell's border, across and along the fringes' axis, mm: blur mixes neighbours there.
MARGIN_ACROSS_MM, MARGIN_ALONG_MM = 0.9, 1.5
#: Samples per millimetre along the axis: more than the pixels per millimetre of any frame at 0.7 m or beyond.
SAMPLES_PER_MM = 2.0
SAMPLES_RANGE = (48, 400)
ROW_STEP_MM = 0.8
MIN_ROW_MM = 0.5


@dataclass(frozen=True)
class Strip:
    """A row of cells, or part of one.

    cells: indices in the grating, one for a uniform strip, several for a row of phase cells; frame: the grating's own;
    along_mm: places along its axis, (N,), and across_mm: middle of the strip along its lines, own mm.
    """

    grating: int
    cells: tuple[int, ...]
    frame: OwnFrame
    along_mm: NDArray[np.float64]
    across_mm: float

    @property
    def uniform(self) -> bool:
        """Whether the strip has one pitch, so that its fringes can be read frame by frame."""
        return len(self.cells) == 1

    @property
    def middle_mm(self) -> float:
        """Place along the axis to which the strip's phase refers."""
        return float(self.along_mm[0] + self.along_mm[-1]) / 2

    @property
    def length_mm(self) -> float:
        """Length read along the axis."""
        return float(self.along_mm[-1] - self.along_mm[0])


class ProfileReader:
    """Cuts a badge into strips and reads their profiles from frames."""

    def __init__(self, badge: Badge) -> None:
        self.strips: list[Strip] = []
        self.edges = EdgeReader(badge.markers)
        rows = [(g, cells) for g, grating in enumerate(badge.gratings) for cells in cell_rows(grating)]
        spans = [_span(badge.gratings[g], cells) for g, cells in rows]
        longest = max(high - low for low, high, _, _ in spans)
        self.samples = int(np.clip(longest * SAMPLES_PER_MM, *SAMPLES_RANGE))
        points, counts = [], []
        for (g, cells), (low, high, top, bottom) in zip(rows, spans, strict=True):
            frame = badge.frame_of(badge.gratings[g])
            if high - low <= 4 * MARGIN_ALONG_MM or bottom - top <= MIN_ROW_MM:
                raise SpecError(
                    f"a row of grating {g} is {high - low:g} x {bottom - top:g} mm, too small to be read; it needs "
                    f"more than {4 * MARGIN_ALONG_MM:g} x {MIN_ROW_MM:g} mm"
                )
            along = np.linspace(low + MARGIN_ALONG_MM, high - MARGIN_ALONG_MM, self.samples)
            top, bottom = read_across_mm(badge.gratings[g], cells[0])
            parts = max(1, math.ceil((bottom - top) / MAX_STRIP_MM)) if len(cells) == 1 else 1
            for part in range(parts):
                begin, end = (top + (bottom - top) * (part + k) / parts for k in (0, 1))
                self.strips.append(Strip(g, cells, frame, along, (begin + end) / 2))
                count = max(2, round((end - begin) / ROW_STEP_MM))
                across = begin + (np.arange(count) + 0.5) / count * (end - begin)
                grid = np.stack(np.meshgrid(along, across), axis=-1)
                points.append(frame.on_page(grid))
                counts.append(count)
        places, self._row_counts = Points(np.concatenate(points).reshape(-1, 2)), np.array(counts, np.int32)
        #: The strips' rows, as the kernel takes them.
        self.rows = PageRows(places, self._row_counts, self.samples)

    def read(self, luma: Picture | NDArray[np.uint8], homography: NDArray[np.float64]) -> NDArray[np.float32]:
        """Brightness profile of every strip in a coded picture, (S, N), in `LINEAR_COUNTS`."""
        # Coded values are sampled first, as the points are far fewer than the pixels.
        return self.rows.read(as_picture(luma).in_light.struct, homography)

    def read_light(self, light: NDArray[np.float32], homography: NDArray[np.float64]) -> NDArray[np.float32]:
        """As `read`, but from a picture that is light already, (height, width), in its own unit."""
        places = cv2.perspectiveTransform(self.rows.points.page[None], homography).astype(np.float32)
        x, y = np.moveaxis(places.reshape(-1, self.samples, 2), -1, 0)
        seen = cv2.remap(light, x.copy(), y.copy(), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        first_rows = np.concatenate([[0], np.cumsum(self._row_counts)[:-1]])
        return np.asarray(np.add.reduceat(seen, first_rows, axis=0) / self._row_counts[:, None], np.float32)


def read_across_mm(grating: Grating, cell: int) -> tuple[float, float]:
    """From where to where along its lines a cell is read, own mm."""
    _, top, _, bottom = own_rect(grating.axis, grating.cells[cell].rect_mm)
    margin = max(min(MARGIN_ACROSS_MM, 0.2 * (bottom - top)), rims_of(grating)[cell][1])
    return top + margin, bottom - margin


def rims_of(grating: Grating) -> tuple[tuple[float, float], ...]:
    """How much of each cell, from its borders, also shows its neighbours' lines: along and across the axis, mm."""
    return rims_mm(grating) if is_smooth(grating) else ((0.0, 0.0),) * len(grating.cells)


def _span(grating: Grating, cells: tuple[int, ...]) -> tuple[float, float, float, float]:
    """Extent of a row: lowest and highest along the axis, then across it."""
    rects = [own_rect(grating.axis, grating.cells[k].rect_mm) for k in cells]
    _, top, _, bottom = rects[0]
    return min(low for low, *_ in rects), max(high for _, _, high, _ in rects), top, bottom
