"""The printed patches by which a page is registered: four squares, or the parts of a frame's four sides.

A patch is a rectangle of the page with what is printed in it and a white border, drawn at any scale.  Each patch has
its own brightness and contrast, and is in sight or hidden as a whole.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import CodedFrame, Fiducial, Markers, Point, Rect

Array = NDArray[np.float64]
#: Parts of each side of a frame: a hand over one corner leaves three quarters of them.
SIDE_PARTS = 2
#: A frame gives the pose as well as four markers of this many of its lines would.  Source:
#: Films of our own simulator: a line of 3 mm errs as squares of 18 mm do, at 0.5 to 2 m.
FRAME_MODULES = 6


@dataclass(frozen=True)
class Patch:
    """A printed patch.

    center_mm; half_mm: half its width and height, without white border; print: brightness (rows, columns), 0 to 1, at
    offsets along x, and along y, from its middle, mm; side: of a frame, clockwise from its top, None for a square.
    """

    center_mm: Point
    half_mm: tuple[float, float]
    print: Callable[[Array, Array], NDArray[np.float32]]
    side: int | None = None


def patches_of(fiducial: Fiducial) -> tuple[Patch, ...]:
    """The patches of a fiducial; squares in the order of their ids, a frame's side by side, clockwise from its top."""
    return _squares(fiducial) if isinstance(fiducial, Markers) else _sides(fiducial)


def module_of(fiducial: Fiducial) -> float:
    """Width of the finest printed detail that counts, mm: a square's module, or a frame's line."""
    if isinstance(fiducial, CodedFrame):
        return fiducial.line_mm
    return fiducial.size_mm / (_dictionary(fiducial).markerSize + 2)


def marker_corners_mm(fiducial: Fiducial) -> Array:
    """Sixteen points at the corners of the page's print, (4, 4, 2).

    Convention: top left, top right, bottom right, bottom left; of each square its corners in the same order.  A frame's
        are squares within its corners, `FRAME_MODULES` lines wide.
    """
    if isinstance(fiducial, Markers):
        half, centers = fiducial.size_mm / 2, fiducial.centers_mm
    else:
        x0, y0, x1, y1 = fiducial.rect_mm
        half = FRAME_MODULES * fiducial.line_mm / 2
        centers = ((x0 + half, y0 + half), (x1 - half, y0 + half), (x1 - half, y1 - half), (x0 + half, y1 - half))
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return np.asarray(np.array(centers)[:, None, :] + square)


def _dictionary(markers: Markers) -> cv2.aruco.Dictionary:
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))


def _squares(markers: Markers) -> tuple[Patch, ...]:
    known, half = _dictionary(markers), markers.size_mm / 2
    modules = known.markerSize + 2
    each = [np.asarray(cv2.aruco.generateImageMarker(known, identity, modules)) > 127 for identity in markers.ids]
    return tuple(
        Patch(center, (half, half), partial(_modules_at, bits, markers.size_mm))
        for bits, center in zip(each, markers.centers_mm, strict=True)
    )


def _modules_at(bits: NDArray[np.bool_], size_mm: float, across: Array, down: Array) -> NDArray[np.float32]:
    modules, module_mm = len(bits), size_mm / len(bits)
    # One module of white paper around it.
    printed = np.pad(bits, 1, constant_values=True).astype(np.float32)
    column, row = (
        np.clip(np.floor((offsets + size_mm / 2) / module_mm).astype(int), -1, modules) + 1
        for offsets in (across, down)
    )
    return np.asarray(printed[:, column].take(row, axis=0))


def _sides(frame: CodedFrame) -> tuple[Patch, ...]:
    printed, patches = (frame.dark_mm, frame.notches_mm), []
    for side, (x0, y0, x1, y1) in enumerate(frame.dark_mm):
        cuts = np.linspace((x0, y0)[side % 2], (x1, y1)[side % 2], SIDE_PARTS + 1).tolist()
        for begin, end in itertools.pairwise(cuts):
            left, top, right, bottom = (begin, y0, end, y1) if side % 2 == 0 else (x0, begin, x1, end)
            center, half = ((left + right) / 2, (top + bottom) / 2), ((right - left) / 2, (bottom - top) / 2)
            patches.append(Patch(center, half, partial(_frame_at, printed, center), side))
    return tuple(patches)


def _frame_at(
    printed: tuple[Sequence[Rect], Sequence[Rect]], center: Point, across: Array, down: Array
) -> NDArray[np.float32]:
    picture = np.ones((len(down), len(across)), np.float32)
    for rects, value in zip(printed, (0.0, 1.0), strict=True):
        for rect in rects:
            columns, rows = (
                (offsets + middle >= low) & (offsets + middle < high)
                for offsets, middle, low, high in zip((across, down), center, rect[:2], rect[2:], strict=True)
            )
            picture[np.ix_(rows, columns)] = value
    return picture
