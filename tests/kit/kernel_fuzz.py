"""Calls of the kernel with hostile figures: run as `python -m kit.kernel_fuzz LIBRARY SEED CALLS`.

The library is one that traps where C is undefined.  Each picture and drawing ends where a page begins that may not be
read, or begins where one ends, so that a read outside ends the process.
"""

from __future__ import annotations

import ctypes
import mmap
import sys

import numpy as np

from moireid.verifier.kernel import fitting, page, squares
from moireid.verifier.kernel.library import picture_struct
from moireid.verifier.kernel.page import PagePrint, PageRows, Points, correlations, values_at
from moireid.verifier.tracking.registration import RULES

PAGE = mmap.PAGESIZE
#: Bytes of the widest picture.
MOST = 64 * 96


class Fenced:
    """Memory between two pages that may not be touched."""

    def __init__(self) -> None:
        self._pages = -(-4 * MOST // PAGE)
        self._whole = mmap.mmap(-1, (self._pages + 2) * PAGE)
        start = ctypes.addressof(ctypes.c_char.from_buffer(self._whole))
        libc = ctypes.CDLL(None, use_errno=True)
        for at in (0, self._pages + 1):
            if libc.mprotect(ctypes.c_void_p(start + at * PAGE), ctypes.c_size_t(PAGE), 0):
                raise OSError(ctypes.get_errno(), "mprotect")

    def array(self, shape, kind, *, at_end: bool) -> np.ndarray:
        """An array that ends at the last byte, or begins at the first."""
        size = int(np.prod(shape)) * np.dtype(kind).itemsize
        start = PAGE + (self._pages * PAGE - size if at_end else 0)
        return np.frombuffer(self._whole, kind, int(np.prod(shape)), start).reshape(shape)


def hostile_warp(rng):
    """A homography of any kind, or what is none."""
    way = rng.integers(5)
    if way == 0:
        return rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-8, 8, (3, 3))
    if way == 1:
        return rng.choice([0.0, -0.0, 1.0, -1.0, 1e300, -1e300, 1e-300, np.nan, np.inf, -np.inf], (3, 3))
    scale, shift = rng.uniform(0, (40, 30)), rng.uniform(-10, (70, 50))
    near = np.array([[scale[0], 0, shift[0]], [0, scale[1], shift[1]], [0, 0, 1.0]])
    return near + rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-6, 0)


def find_squares(rng, picture, room):
    """Squares of any code, in memory of the least size."""
    side, classes = int(rng.integers(1, squares.MOST_CELLS + 1)), int(rng.integers(1, 5))
    words = rng.integers(0, 2 ** min(side**2, 62), (classes, 4)).astype(np.uint64)
    codes = squares.SquareCodes(words, side, int(rng.integers(0, 65)), int(rng.integers(0, 40)))
    squares.memory_for = lambda width: room.array((squares_room(width),), np.uint8, at_end=bool(rng.integers(2)))
    least_px = float(rng.choice([-1.0, 0.0, 2.0, 9.0, np.nan, np.inf]))
    window, steps = int(rng.choice([1, 3, 5, 7, 9, 11, 13, 15])), int(rng.integers(1, squares.MOST_STEPS + 1))
    codes.find(picture, window=window, steps=steps, least_px=least_px, most=int(rng.integers(1, 4)))


def squares_room(width):
    size = squares.library().kernel_squares_room
    size.restype = ctypes.c_int64
    return size(ctypes.c_int32(width))


def fuzz(seed: int, calls: int) -> None:
    """Call everything, with figures drawn by the seed."""
    rng, fence, room = np.random.default_rng(seed), Fenced(), Fenced()
    for _ in range(calls):
        height, width = int(rng.integers(2, 64)), int(rng.integers(2, 90))
        stride, at_end = width + int(rng.integers(0, 6)), bool(rng.integers(2))
        # The last row of a padded plane may end with its last pixel.
        flat = fence.array((height * stride,), np.uint8, at_end=at_end)
        coded = flat.reshape(height, stride)[:, stride - width :] if at_end else flat.reshape(height, stride)[:, :width]
        # Blocks of all sizes, as noise alone has no quadrangles.
        block = int(rng.choice([1, 2, 5, 9]))
        blocks = rng.choice([0, 30, 200, 255], (height // block + 1, width // block + 1)).astype(np.uint8)
        coded[...] = (
            blocks.repeat(block, 0).repeat(block, 1)[:height, :width]
            if block > 1
            else rng.integers(0, 256, coded.shape)
        )
        levels = rng.choice([np.arange(256), rng.uniform(0, 255, 256), np.zeros(256)]).astype(np.float32)
        picture = picture_struct(coded, levels)
        find_squares(rng, picture, room)
        patches = int(rng.integers(1, 9))
        first = np.concatenate([[0], np.cumsum(rng.integers(1, 90, patches))]).tolist()
        points = Points(rng.uniform(-1.2, 1.2, (first[-1], 2)))
        printed = rng.normal(size=first[-1]).astype(np.float32) * rng.choice([0.0, 1.0, 1e30])
        sides = rng.integers(-1, 4, patches).tolist()
        sizes = {"least_seen": patches, "squares": 4, "middle": rng.normal(size=2)}
        sizes |= {"extent": float(rng.choice([0, 1.0])), "px_per_mm": float(rng.choice([0.0, 50.0, np.nan]))}
        sizes |= {"rules": RULES}
        prints = [
            PagePrint(points, first, sides, printed, least_correlation=float(rng.uniform(-1, 1)), **sizes)
            for _ in range(2)
        ]
        coarse, shown = prints
        gradient = (rng.normal(size=(2, first[-1])) * rng.choice([0.0, 1.0, 1e30])).astype(np.float32)
        coarse.prepare(gradient)
        shown.prepare(gradient, coarse if rng.integers(2) else None, float(rng.choice([0.0, 9.0, np.inf, np.nan])))
        for _ in range(4):
            warp = hostile_warp(rng)
            values_at(picture, warp, points)
            shown.compare(picture, warp)
            counts = rng.integers(1, 5, 3).astype(np.int32)
            rows = PageRows(Points(rng.uniform(-1, 1, (int(counts.sum()) * 70, 2))), counts, 70)
            rows.read(picture, warp)
            shown.follow(picture, warp)
            printed = rng.normal(size=rng.integers(1, 20, 2)).astype(np.float32)
            fewer, reach = int(rng.integers(1, min(printed.shape) + 1)), int(rng.integers(0, 7))
            correlations(picture, warp, printed, fewer, reach, np.zeros((2 * reach + 1,) * 2, np.float32))
        height, width = height // 2 + 1, width // 2 + 1
        drawing = room.array((2, 2, height, width), np.float32, at_end=at_end)
        drawing[...] = 1.0
        shape = tuple(int(rng.integers(1, size)) for size in (height, width))
        corner = tuple(int(rng.integers(0, size - part)) for size, part in zip((height, width), shape, strict=True))
        motion = tuple(float(part) for part in rng.choice([0.0, 3.0, -1e9, 1e300, np.nan], 2))
        means = fitting.smeared_means(drawing, corner, shape, motion, int(rng.integers(1, 5)))
        assert np.abs(means - 1).max() < 1e-5
        frames, corners = int(rng.integers(0, 4)), int(rng.integers(0, 20))
        fitting.refined_poses(
            rng.normal(size=(corners, 3)) * rng.choice([0.0, 1.0, 1e200]),
            rng.normal(size=(frames, corners, 2)),
            rng.normal(size=(frames, corners)) if rng.integers(2) else None,
            rng.normal(size=(frames, 2, 3, 3)),
            rng.normal(size=(frames, 2, 3)) * rng.choice([0.0, 1.0, np.nan, 1e300]),
            steps=3,
            damping=1e-6,
            most_turn=0.5,
        )


if __name__ == "__main__":
    trapping = ctypes.CDLL(sys.argv[1])
    page.library = fitting.library = squares.library = lambda: trapping
    fuzz(int(sys.argv[2]), int(sys.argv[3]))
