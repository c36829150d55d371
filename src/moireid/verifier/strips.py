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

from moireid.badge import Badge

MAX_STRIP_MM = 10.0
#: Left out at a cell's border across and along the fringes' axis, mm: there the picture's blur mixes neighbours.
MARGIN_ACROSS_MM, MARGIN_ALONG_MM = 0.9, 1.5
#: Samples to the millimetre along the axis: two, which is more than the pixels of any frame at 0.7 m or beyond.
SAMPLES_PER_MM = 2.0
SAMPLES_RANGE = (48, 400)
ROW_STEP_MM = 0.8


@dataclass(frozen=True)
class Strip:
    """Part of a cell; along_mm: places along the grating's axis, (N,), page mm; across_mm: middle of the strip."""

    grating: int
    cell: int
    axis: int
    along_mm: NDArray[np.float64]
    across_mm: float

    @property
    def middle_mm(self) -> float:
        """Place along the axis at which the strip's phase is told."""
        return float(self.along_mm[0] + self.along_mm[-1]) / 2

    @property
    def length_mm(self) -> float:
        """Length read along the axis."""
        return float(self.along_mm[-1] - self.along_mm[0])


class ProfileReader:
    """Cuts a badge into strips and reads their profiles from frames."""

    def __init__(self, badge: Badge) -> None:
        self.strips: list[Strip] = []
        longest = max(
            cell.rect_mm[2 + axis] - cell.rect_mm[axis]
            for grating in badge.gratings for axis in [0 if grating.axis == "x" else 1] for cell in grating.cells
        )  # fmt: skip
        self.samples = int(np.clip(longest * SAMPLES_PER_MM, *SAMPLES_RANGE))
        rows, self._row_counts = [], []
        for g, grating in enumerate(badge.gratings):
            axis = 0 if grating.axis == "x" else 1
            for c, cell in enumerate(grating.cells):
                low, high = cell.rect_mm[axis] + MARGIN_ALONG_MM, cell.rect_mm[axis + 2] - MARGIN_ALONG_MM
                top, bottom = cell.rect_mm[1 - axis], cell.rect_mm[3 - axis]
                margin = min(MARGIN_ACROSS_MM, 0.2 * (bottom - top))
                top, bottom = top + margin, bottom - margin
                parts = max(1, math.ceil((bottom - top) / MAX_STRIP_MM))
                for part in range(parts):
                    begin, end = (top + (bottom - top) * (part + k) / parts for k in (0, 1))
                    along = np.linspace(low, high, self.samples)
                    self.strips.append(Strip(g, c, axis, along, (begin + end) / 2))
                    count = max(2, round((end - begin) / ROW_STEP_MM))
                    across = begin + (np.arange(count) + 0.5) / count * (end - begin)
                    grid = np.stack(np.meshgrid(along, across), axis=-1)
                    rows.append(grid if axis == 0 else grid[..., ::-1])
                    self._row_counts.append(count)
        self._points = np.concatenate(rows)
        self._first_rows = np.concatenate([[0], np.cumsum(self._row_counts)[:-1]])

    def read(self, luma: NDArray[np.uint8], homography: NDArray[np.float64]) -> NDArray[np.float32]:
        """Brightness profile of every strip, (S, N), in the picture's counts."""
        mapped = self._points @ homography[:, :2].T + homography[:, 2]
        places = (mapped[..., :2] / mapped[..., 2:]).astype(np.float32)
        # OpenCV's 1/32 pixel grid is fine here: a strip averages over some hundred samples a fringe.
        seen = cv2.remap(luma, places[..., 0], places[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        sums = np.add.reduceat(seen.astype(np.float32), self._first_rows, axis=0)
        return np.asarray(sums / np.array(self._row_counts, np.float32)[:, None])
