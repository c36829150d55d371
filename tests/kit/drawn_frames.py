"""Pictures of a page with a coded frame whose homography is known, drawn from its rectangles: no template of ours."""

from __future__ import annotations

import cv2
import numpy as np

from moireid.badge import CodedFrame

FINE = 4
#: A frame of 120 x 90 mm whose line is 3 mm wide.  Notches: three at the top, two on the right, one at the bottom.
FRAME = CodedFrame(
    (20.0, 30.0, 140.0, 120.0),
    3.0,
    (
        (30.5, 31.2, 39.5, 33.0),
        (60.5, 31.2, 69.5, 33.0),
        (90.5, 31.2, 99.5, 33.0),
        (137.0, 37.9, 138.8, 44.6),
        (137.0, 82.9, 138.8, 89.6),
        (90.5, 117.0, 99.5, 118.8),
    ),
)
BOARD = (12.0, 10.0, 148.0, 140.0)
#: Stripes within, as fringes show.
FIELD = (27.0, 37.0, 133.0, 113.0)


def draw_frame(page: np.ndarray, shape: tuple[int, int], frame: CodedFrame = FRAME) -> np.ndarray:
    """A white board before grey, with the frame and stripes in it, each pixel averaged over its area; counts."""
    offset = (np.arange(FINE) + 0.5) / FINE - 0.5
    back, total = np.linalg.inv(page), np.zeros(shape)
    rows, columns = np.mgrid[: shape[0], : shape[1]].astype(float)
    for dy in offset:
        for dx in offset:
            x, y, w = np.tensordot(back, np.stack([columns + dx, rows + dy, np.ones(shape)]), axes=1)
            total += _printed(x / w, y / w, frame)
    return total / FINE**2


def _printed(x: np.ndarray, y: np.ndarray, frame: CodedFrame) -> np.ndarray:
    def inside(rect):
        return (x >= rect[0]) & (y >= rect[1]) & (x < rect[2]) & (y < rect[3])

    x0, y0, x1, y1 = frame.rect_mm
    line = frame.line_mm
    shown = np.where(inside(BOARD), 215.0, 110.0)
    shown[inside(frame.rect_mm) & ~inside((x0 + line, y0 + line, x1 - line, y1 - line))] = 60.0
    for notch in frame.notches_mm:
        shown[inside(notch)] = 215.0
    shown[inside(FIELD) & (x % 20 < 9)] = 60.0
    return shown


def corners_apart_px(one: np.ndarray, other: np.ndarray, frame: CodedFrame = FRAME) -> float:
    """The most by which two pages differ at the frame's corners."""
    x0, y0, x1, y1 = frame.rect_mm
    points = np.array([[[x0, y0]], [[x1, y0]], [[x1, y1]], [[x0, y1]]])
    return float(np.abs(cv2.perspectiveTransform(points, one) - cv2.perspectiveTransform(points, other)).max())
