"""Registration of a page, and brightness along its strips, by the kernel, for NumPy arrays.

Convention: places (N, 2) in the unit of a homography `warp` (3, 3) from them to pixels; the kernel counts them from the
    middle of their bounding box, in single precision.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.kernel.library import PictureStruct, PlacesStruct, address, library

Array = NDArray[np.float64]
Single = NDArray[np.float32]
#: As `MOST_PATCHES` of kernel.h.
MOST_PATCHES = 16
#: Most blocks around which a print is sought, and most of its samples down or across.
MOST_REACH, MOST_SAMPLES = 1000, 4096


class PrintStruct(ctypes.Structure):
    """`Print` of kernel.h."""

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
    """`Rules` of kernel.h."""

    _fields_ = (
        *((name, ctypes.c_int32) for name in ("max_steps", "hopeless_steps", "bent_seen_steps", "bent_steps")),
        *((name, ctypes.c_double) for name in ("stop_px", "left_share", "min_correlation", "min_gain")),
        *((name, ctypes.c_double) for name in ("covered_left", "covered_left_ratio")),
    )


class ComparisonStruct(ctypes.Structure):
    """`Comparison` of kernel.h."""

    _fields_ = (
        ("correlation", ctypes.c_double),
        ("contrast", ctypes.c_double),
        ("gain", ctypes.c_double * MOST_PATCHES),
        ("mean", ctypes.c_double * MOST_PATCHES),
        ("steps", ctypes.c_int32),
        ("seen", ctypes.c_int32 * MOST_PATCHES),
    )


class DrawingStruct(ctypes.Structure):
    """`Drawing` of following.c."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("print", "coarse", "rules", "values", "found")),
        ("middle", ctypes.c_double * 2),
        *((name, ctypes.c_double) for name in ("extent", "near_px")),
        ("coarse_steps", ctypes.c_int32),
    )


#: What `kernel_follow` returns: 0 or one of the first two, and a flag.
HELD, LOOSE, ALL_SEEN = 1, 2, 4


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


class PageRows:
    """Rows of the page, one strip's after another's."""

    def __init__(self, points: Points, counts: NDArray[np.int32], samples: int) -> None:
        """Parameters: counts (S,): rows of each strip, one or more, of so many samples."""
        if int(counts.sum()) * samples != points.struct.count or counts.min() < 1:
            raise ValueError(f"{points.struct.count} places are not {counts.sum()} rows of {samples}")
        self.points, self._counts, self._shape = points, counts, (len(counts), samples)

    def read(self, picture: PictureStruct, warp: Array) -> Single:
        """Mean of the rows of each strip under a warp, (S, samples)."""
        if min(picture.width, picture.height) < 2:
            raise ValueError(f"a picture of {picture.width} x {picture.height} has no four pixels around a place")
        warp, profiles = np.array(warp, np.float64, order="C"), np.empty(self._shape, np.float32)
        library().kernel_rows(
            ctypes.byref(picture),
            ctypes.byref(self.points.struct),
            ctypes.c_void_p(address(warp, np.float64, 9)),
            ctypes.c_void_p(address(self._counts, np.int32)),
            *(ctypes.c_int32(size) for size in self._shape),
            ctypes.c_void_p(address(profiles, np.float32)),
        )
        return profiles


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
        middle: Array,
        extent: float,
        px_per_mm: float,
        rules: RulesStruct,
        least_correlation: float,
    ) -> None:
        """Parameters: first (K + 1,): where each patch's samples begin; sides (K,): the frame's side of each, -1 for a
        square; printed (N,): about each patch's mean; squares: patches up to which none is left out as covered;
        middle (2,), extent: the places are page mm less `middle`, over `extent`; px_per_mm: scale of the print.
        """
        self.points, self.samples, self.patches = points, points.struct.count, len(sides)
        if self.patches > MOST_PATCHES or first[-1] != self.samples or min(np.diff(first)) < 1:
            raise ValueError(f"{self.patches} patches of {self.samples} samples, at most {MOST_PATCHES} of one or more")
        self._first, self._sides = np.array(first, np.int32), np.array(sides, np.int32)
        self._printed = np.ascontiguousarray(printed, np.float32)
        self.power = np.array([float(part @ part) for part in np.split(self._printed, self._first[1:-1])], np.float64)
        self._room = np.empty(self.samples, np.float32)
        self._free: Single | None = None
        self._coarse: PagePrint | None = None
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
            extent * px_per_mm,
            least_correlation,
        )
        self._found = ComparisonStruct()
        self._rules, self._middle, self._extent = rules, middle, extent
        self._drawing = DrawingStruct(
            ctypes.addressof(self._struct),
            None,
            ctypes.addressof(rules),
            address(self._room, np.float32),
            ctypes.addressof(self._found),
            (ctypes.c_double * 2)(*middle),
            extent,
        )

    @property
    def is_prepared(self) -> bool:
        """Whether `prepare` was called."""
        return self._free is not None

    def prepare(self, gradient: Single, coarse: PagePrint | None = None, near_px: float = 0.0) -> None:
        """Make it ready to register with.

        Parameters: gradient (2, N): of the print, per unit of the places; coarse: a prepared print of some of its
            samples, with which a page comes within about `near_px` first.
        """
        free = np.empty((8, self.samples), np.float32)
        gradient = np.ascontiguousarray(gradient, np.float32)
        library().kernel_free(
            ctypes.byref(self._struct),
            ctypes.c_void_p(address(gradient, np.float32, 2 * self.samples)),
            ctypes.c_void_p(address(free, np.float32)),
            ctypes.c_void_p(address(self._normal, np.float64)),
        )
        self._free, self._struct.free = free, address(free, np.float32)
        if coarse is not None:
            if coarse.patches != self.patches or coarse.samples > self.samples or not coarse.is_prepared:
                raise ValueError(
                    f"a coarse print of {coarse.patches} patches and {coarse.samples} samples does not fit"
                )
            self._coarse, self._drawing.near_px = coarse, near_px
            self._drawing.coarse = ctypes.addressof(coarse._struct)

    @property
    def free(self) -> Single:
        """Change of the print with each of the warp's eight parameters that no gain or offset could make, (8, N)."""
        if self._free is None:
            raise ValueError("a print must be prepared before it is registered")
        return self._free

    def normal(self, seen: Sequence[bool]) -> Array:
        """Products of the rows of `free` over the visible patches, (8, 8)."""
        return np.asarray(self._normal[np.array(seen)].sum(axis=0))

    def follow(self, picture: PictureStruct, expected: Array) -> tuple[int, Array]:
        """Register the page where it is expected.

        Parameters: expected: homography page mm -> px.
        Returns: one of `HELD` and `LOOSE` (whether the visible patches hold the page) and 0 (nothing that matches),
            with the flag `ALL_SEEN`; and the page, h33 = 1.
        """
        if self._free is None:
            raise ValueError("a print must be prepared before it is registered")
        page = np.empty((3, 3))
        state = library().kernel_follow(
            ctypes.byref(picture),
            ctypes.byref(self._drawing),
            ctypes.c_void_p(address(expected, np.float64, 9)),
            ctypes.c_void_p(address(page, np.float64)),
        )
        return state, page

    @property
    def compared(self) -> int:
        """Samples that the last registration compared, in all its steps."""
        coarse = 0 if self._coarse is None else self._coarse.samples * self._drawing.coarse_steps
        return int(coarse + self.samples * self._found.steps)

    @property
    def correlation(self) -> float:
        """Correlation of picture and print over the visible patches, at the end of the last registration."""
        return float(self._found.correlation)

    @property
    def contrast(self) -> float:
        """Contrast of the clearest patch there, counts."""
        return float(self._found.contrast)

    @property
    def seen(self) -> tuple[bool, ...]:
        """The patches that were visible there, (K,)."""
        return tuple(map(bool, self._found.seen[: self.patches]))

    def compare(self, picture: PictureStruct, warp: Array) -> Single | None:
        """Picture less print at a warp, (N,), in units of print contrast, with each patch's own gain and offset; None
        where the page is not within the picture.  `seen`, `correlation` and `contrast` are then those at the warp.

        A hidden patch is left out of the last two, as its cover has edges of its own.
        """
        warp, left = np.array(warp, np.float64, order="C"), np.empty(self.samples, np.float32)
        within = library().kernel_compare(
            ctypes.byref(picture),
            ctypes.byref(self._struct),
            ctypes.byref(self._rules),
            ctypes.c_void_p(address(warp, np.float64, 9)),
            ctypes.c_void_p(address(left, np.float32)),
            ctypes.byref(self._found),
        )
        return left if within else None


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


def correlations(picture: PictureStruct, warp: Array, printed: Single, fewer: int, reach: int, total: Single) -> None:
    """Add the correlation of a print with a picture at each shift, or 0 where it is opposite.

    Parameters: warp: from samples of the print to px; printed (rows, columns); total (2 reach + 1, 2 reach + 1): down
        and across, in blocks of `fewer` x `fewer` samples, whose means are compared.
    """
    (rows, columns), side = printed.shape, 2 * reach + 1
    if not (1 <= fewer <= min(rows, columns) and 0 <= reach <= MOST_REACH and max(rows, columns) <= MOST_SAMPLES):
        raise ValueError(f"{rows} x {columns} samples cannot be compared {reach} blocks of {fewer} around")
    if min(picture.width, picture.height) < 2:
        raise ValueError(f"a picture of {picture.width} x {picture.height} has no four pixels around a place")
    height, width = rows // fewer, columns // fewer
    wide = width + 2 * reach
    room = np.empty(height * width + (height + 2 * reach + 2) * wide + 3 * side, np.float32)
    library().kernel_correlations(
        ctypes.byref(picture),
        ctypes.c_void_p(address(warp, np.float64, 9)),
        ctypes.c_void_p(address(printed, np.float32)),
        *(ctypes.c_int32(size) for size in (rows, columns, fewer, reach)),
        ctypes.c_void_p(address(room, np.float32)),
        ctypes.c_void_p(address(total, np.float32, side * side)),
    )
