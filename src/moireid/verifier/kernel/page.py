"""Registration of a page, and brightness along its strips, by the kernel, for NumPy arrays.

Convention: places (N, 2) in the unit of a homography `warp` (3, 3) from them to pixels; the kernel counts them from the
    middle of their bounding box, in single precision.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.kernel.library import PictureStruct, PlacesStruct, address, library

Array = NDArray[np.float64]
Single = NDArray[np.float32]
#: As `MOST_PATCHES` of kernel.h.
MOST_PATCHES = 16


class PrintStruct(ctypes.Structure):
    """`Print` of registration.c."""

    _fields_ = (
        ("places", PlacesStruct),
        ("patches", ctypes.c_int32),
        ("least_seen", ctypes.c_int32),
        ("squares", ctypes.c_int32),
        ("first", ctypes.c_void_p),
        ("side", ctypes.c_void_p),
        ("printed", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
        ("power", ctypes.c_void_p),
        ("normal", ctypes.c_void_p),
        ("extent_px", ctypes.c_double),
        ("least_correlation", ctypes.c_double),
    )


class RulesStruct(ctypes.Structure):
    """`Rules` of registration.c."""

    _fields_ = (
        *((name, ctypes.c_int32) for name in ("max_steps", "hopeless_steps", "bent_seen_steps", "bent_steps")),
        *((name, ctypes.c_double) for name in ("stop_px", "left_share", "min_correlation", "min_gain")),
        *((name, ctypes.c_double) for name in ("covered_left", "covered_left_ratio")),
    )


class ComparisonStruct(ctypes.Structure):
    """`Comparison` of registration.c."""

    _fields_ = (
        ("correlation", ctypes.c_double),
        ("contrast", ctypes.c_double),
        ("gain", ctypes.c_double * MOST_PATCHES),
        ("mean", ctypes.c_double * MOST_PATCHES),
        ("steps", ctypes.c_int32),
        ("seen", ctypes.c_int32 * MOST_PATCHES),
    )


class Points:
    """Places of the page as the kernel takes them."""

    def __init__(self, points: Array) -> None:
        """Parameters: points (N, 2), N > 0."""
        #: The places, (N, 2).
        self.page = points
        low, high = points.min(axis=0), points.max(axis=0)
        middle = (low + high) / 2
        self.centred = np.ascontiguousarray((points - middle).T, np.float32)
        (x0, y0), (x1, y1) = low, high
        start, count = address(self.centred, np.float32), len(points)
        hull = (ctypes.c_double * 8)(x0, y0, x1, y0, x1, y1, x0, y1)
        self.struct = PlacesStruct(start, start + 4 * count, (ctypes.c_double * 2)(*middle), hull, count)


@dataclass(frozen=True)
class PatchComparison:
    """Picture and print, patch by patch: its gain (K,), counts; which patches are visible; the correlation over those;
    the contrast of the clearest, counts; how many steps of registration were taken.

    A hidden patch is left out, as its cover has edges of its own.
    """

    gain: tuple[float, ...]
    seen: tuple[bool, ...]
    correlation: float
    contrast: float
    steps: int


class PagePrint:
    """A print to register pictures with."""

    def __init__(
        self,
        points: Points,
        first: Sequence[int],
        sides: Sequence[int],
        printed: Single,
        *,
        least_seen: int,
        squares: int,
        extent_px: float,
        least_correlation: float,
    ) -> None:
        """Parameters: first (K + 1,): where each patch's samples begin; sides (K,): the frame's side of each, -1 for a
        square; printed (N,): about each patch's mean; squares: patches up to which none is left out as covered;
        extent_px: a unit of the places.
        """
        self.points, self.samples, self.patches = points, points.struct.count, len(sides)
        if self.patches > MOST_PATCHES or first[-1] != self.samples or min(np.diff(first)) < 1:
            raise ValueError(f"{self.patches} patches of {self.samples} samples, at most {MOST_PATCHES} of one or more")
        self._first, self._sides = np.array(first, np.int32), np.array(sides, np.int32)
        self._printed = np.ascontiguousarray(printed, np.float32)
        self.power = np.array([float(part @ part) for part in np.split(self._printed, self._first[1:-1])], np.float64)
        self._room = np.empty(self.samples, np.float32)
        self._free: Single | None = None
        self._normal = np.zeros((self.patches, 8, 8))
        self._struct = PrintStruct(
            points.struct,
            self.patches,
            least_seen,
            squares,
            address(self._first, np.int32, self.patches + 1),
            address(self._sides, np.int32),
            address(self._printed, np.float32, self.samples),
            None,
            address(self.power, np.float64),
            address(self._normal, np.float64),
            extent_px,
            least_correlation,
        )
        self._found = ComparisonStruct()

    @property
    def is_prepared(self) -> bool:
        """Whether `prepare` was called."""
        return self._free is not None

    def prepare(self, gradient: Single) -> None:
        """Make it ready to register with.  Parameters: gradient (2, N): of the print, per unit of the places."""
        free = np.empty((8, self.samples), np.float32)
        gradient = np.ascontiguousarray(gradient, np.float32)
        library().kernel_free(
            ctypes.byref(self._struct),
            ctypes.c_void_p(address(gradient, np.float32, 2 * self.samples)),
            ctypes.c_void_p(address(free, np.float32)),
            ctypes.c_void_p(address(self._normal, np.float64)),
        )
        self._free, self._struct.free = free, address(free, np.float32)

    @property
    def free(self) -> Single:
        """Change of the print with each of the warp's eight parameters that no gain or offset could make, (8, N)."""
        if self._free is None:
            raise ValueError("a print must be prepared before it is registered")
        return self._free

    def normal(self, seen: Sequence[bool]) -> Array:
        """Products of the rows of `free` over the visible patches, (8, 8)."""
        return np.asarray(self._normal[np.array(seen)].sum(axis=0))

    def register(
        self, picture: PictureStruct, rules: RulesStruct, warp: Array
    ) -> tuple[Array, PatchComparison, bool] | None:
        """Refine a warp on a picture.

        Returns: the warp, the comparison there, and whether the visible patches hold the page; None if the page does
            not match, or is not in the picture.
        """
        warp = np.array(warp, np.float64, order="C")
        if self._free is None:
            raise ValueError("a print must be prepared before it is registered")
        state = library().kernel_register(
            ctypes.byref(picture),
            ctypes.byref(self._struct),
            ctypes.byref(rules),
            ctypes.c_void_p(address(warp, np.float64, 9)),
            ctypes.c_void_p(address(self._room, np.float32)),
            ctypes.byref(self._found),
        )
        return (warp, self._comparison(), state == 1) if state else None

    @property
    def steps(self) -> int:
        """Steps of the last registration."""
        return int(self._found.steps)

    def compare(self, picture: PictureStruct, rules: RulesStruct, warp: Array) -> tuple[PatchComparison, Single] | None:
        """The comparison at a warp, and picture less print (N,), in units of print contrast, with each patch's own gain
        and offset; None where the page is not within the picture.
        """
        warp, left = np.array(warp, np.float64, order="C"), np.empty(self.samples, np.float32)
        within = library().kernel_compare(
            ctypes.byref(picture),
            ctypes.byref(self._struct),
            ctypes.byref(rules),
            ctypes.c_void_p(address(warp, np.float64, 9)),
            ctypes.c_void_p(address(left, np.float32)),
            ctypes.byref(self._found),
        )
        return (self._comparison(), left) if within else None

    def _comparison(self) -> PatchComparison:
        found, count = self._found, self.patches
        seen = tuple(map(bool, found.seen[:count]))
        return PatchComparison(tuple(found.gain[:count]), seen, found.correlation, found.contrast, found.steps)


def values_at(picture: PictureStruct, warp: Array, points: Points) -> Single | None:
    """Brightness at places, bilinear, (N,); None if their bounding box is not within the picture."""
    warp, values = np.array(warp, np.float64, order="C"), np.empty(points.struct.count, np.float32)
    within = library().kernel_values(
        ctypes.byref(picture),
        ctypes.byref(points.struct),
        ctypes.c_void_p(address(warp, np.float64, 9)),
        ctypes.c_void_p(address(values, np.float32)),
    )
    return values if within else None


def row_means(picture: PictureStruct, warp: Array, points: Points, counts: NDArray[np.int32], samples: int) -> Single:
    """Mean of the rows of places of each strip, (S, samples).

    Parameters: points: row by row, one strip's rows after another's; counts (S,): rows of each strip, one or more.
    """
    warp = np.array(warp, np.float64, order="C")
    if int(counts.sum()) * samples != points.struct.count or counts.min() < 1:
        raise ValueError(f"{points.struct.count} places are not {counts.sum()} rows of {samples}")
    if min(picture.width, picture.height) < 2:
        raise ValueError(f"a picture of {picture.width} x {picture.height} has no four pixels around a place")
    profiles = np.empty((len(counts), samples), np.float32)
    library().kernel_rows(
        ctypes.byref(picture),
        ctypes.byref(points.struct),
        ctypes.c_void_p(address(warp, np.float64, 9)),
        ctypes.c_void_p(address(counts, np.int32)),
        ctypes.c_int32(len(counts)),
        ctypes.c_int32(samples),
        ctypes.c_void_p(address(profiles, np.float32)),
    )
    return profiles
