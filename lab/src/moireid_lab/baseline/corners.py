"""The striped region's corners, given by hand at some frames and tracked between them.

Generated videos often lose their markers.  The published protocol then marks the region's four corners in the first
frame, tracks them by pyramidal Lucas-Kanade, and corrects them by hand when they slip.  Our own pipeline uses markers
only: a page whose corners are given by hand could never be accepted.

Convention: corners in the order top left, top right, bottom right, bottom left of the first grating, picture px with
(0, 0) at the centre of the top left pixel.
Source: Lucas and Kanade, with the pyramid of Bouguet, in OpenCV.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.files import MOST_TABLE_BYTES, read_regular
from moireid.verifier.reasons import Reason, worst
from moireid.verifier.session.result import Report

Array = NDArray[np.float64]
#: Frame number -> corners (4, 2), px.
Corners = Mapping[int, Array]
COLUMNS = ("frame", "x1", "y1", "x2", "y2", "x3", "y3", "x4", "y4")
LEAST_AREA_PX2 = 16
WINDOW_PX, LEVELS = (31, 31), 4
#: A corner has slipped if tracking it forward and back ends further away than this.
MOST_RETURN_PX = 2.0


def read_corners(path: Path) -> dict[int, Array]:
    """Corners by frame from a CSV file with the columns `COLUMNS`.

    Raises: SpecError if the file cannot be read, lacks a column or frame 0, or has corners of no quadrilateral.
    """
    example = f"give a CSV file with the columns {','.join(COLUMNS)} and a row for frame 0"
    try:
        text = read_regular(path, MOST_TABLE_BYTES).decode("utf-8-sig")
        rows = list(csv.DictReader(io.StringIO(text, newline="")))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SpecError(f"corners {path} cannot be read ({error}); {example}") from error
    found: dict[int, Array] = {}
    for number, row in enumerate(rows, start=2):
        try:
            values = [float(row[name]) for name in COLUMNS]
        except (KeyError, TypeError, ValueError) as error:
            raise SpecError(f"line {number} of corners {path} has no number in each column; {example}") from error
        if not all(map(math.isfinite, values)) or values[0] != int(values[0]) or values[0] < 0:
            raise SpecError(f"line {number} of corners {path} names no frame, or a corner that is no place; {example}")
        found[int(values[0])] = _four_sided(values[1:], f"line {number} of corners {path}")
    if 0 not in found:
        raise SpecError(f"corners {path} hold no frame 0; {example}")
    return found


def _four_sided(values: list[float], source: str) -> Array:
    """Corners (4, 2) px.  Raises: SpecError, which names the source, if they are no quadrilateral."""
    corners = np.array(values).reshape(4, 2)
    flat = corners.astype(np.float32)
    if not np.all(np.isfinite(flat)) or not cv2.isContourConvex(flat) or cv2.contourArea(flat) < LEAST_AREA_PX2:
        raise SpecError(
            f"{source} spans no four-sided figure; give the region's corners in order: top left, top right, bottom "
            "right, bottom left"
        )
    return corners


def without_corners(report: Report) -> Report:
    """Our report on a film with given corners: inconclusive if markers were seen in less than half of its frames.

    Policy: most of such a film was not examined, so it cannot be accepted; if its markers reject it, it stays rejected.
    """
    read, tracked = report.frames["read"], report.frames["tracked"]
    if 2 * tracked >= read:
        return report
    text = (
        f"The badge was followed by its markers in {tracked} of {read} frames, and our method does not follow a badge "
        "by corners given by hand; the published one does, and scores such a film as the paper does."
    )
    reasons = (*report.reasons, Reason("corners", "undecided", float(tracked), read / 2, "frames", text))
    return replace(report, verdict=worst(list(reasons)), reasons=reasons)


class CornerFollower:
    """Tracks four corners from frame to frame, and replaces them where they are given."""

    def __init__(self, corners: Corners) -> None:
        self._given = dict(corners)
        self._luma: NDArray[np.uint8] | None = None
        self._corners: Array | None = None

    def follow(self, index: int, luma: NDArray[np.uint8]) -> Array | None:
        """Corners in this frame, (4, 2) px; None after one has slipped, until the next correction."""
        if index in self._given:
            self._corners = self._given[index]
        elif self._corners is not None and self._luma is not None:
            self._corners = _moved(self._luma, luma, self._corners)
        self._luma = luma
        return self._corners


def _moved(before: NDArray[np.uint8], after: NDArray[np.uint8], corners: Array) -> Array | None:
    """The corners one frame later; None if one of them is lost."""
    start = corners.astype(np.float32).reshape(-1, 1, 2)
    how: dict[str, Any] = {"winSize": WINDOW_PX, "maxLevel": LEVELS}
    there, seen, _ = cv2.calcOpticalFlowPyrLK(before, after, start, start.copy(), **how)
    back, seen_back, _ = cv2.calcOpticalFlowPyrLK(after, before, there, start.copy(), **how)
    if not (np.all(seen) and np.all(seen_back)):
        return None
    if np.linalg.norm(back - start, axis=-1).max() > MOST_RETURN_PX:
        return None
    return np.asarray(there.reshape(4, 2), float)
