"""The kernel against the same equations in NumPy and OpenCV, on films and on pictures at the edge.

Beside each test: the wrong implementation it catches.
"""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.kernel import library as kernel_library
from moireid.verifier.kernel.page import (
    PagePrint,
    PageRows,
    Points,
    correlations,
    values_at,
)
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.registration import RULES


def warps(rng):
    """Homographies of every kind: mirrored, folded, through the horizon, huge, tiny, and not finite."""
    yield from (np.zeros((3, 3)), np.full((3, 3), np.nan), np.full((3, 3), np.inf), -np.eye(3), 1e300 * np.eye(3))
    for _ in range(400):
        yield rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-6, 6, (3, 3))
    for place in ([0, 0], [-3e9, 5.0], [5.0, 4e9], [118.9999, 88.9999]):
        yield np.array([[1e-3, 0, place[0]], [0, 1e-3, place[1]], [0, 0, 1.0]])


@pytest.mark.claim("No film makes the kernel in C read outside of its memory")
def test_no_homography_makes_the_kernel_read_outside_or_return_what_is_no_number(rng):
    """Catches: a crash, or a place beyond the plane: the plane's surroundings are another count than its own."""
    surrounded = np.full((94, 130), 255, np.uint8)
    surrounded[2:92, 3:124] = 100
    picture = Picture(surrounded[2:92, 3:124])
    across, down = np.meshgrid(np.linspace(-1, 1, 50), np.linspace(-1, 1, 8))
    points = Points(np.column_stack([across.ravel(), down.ravel()]))
    for warp in warps(rng):
        rows = PageRows(points, np.array([3, 5], np.int32), 50).read(picture.struct, warp)
        assert np.array_equal(rows, np.full((2, 50), 100.0))
        values = values_at(picture.struct, warp, points)
        assert values is None or np.array_equal(values, np.full(400, 100.0))


def test_arrays_of_other_sizes_or_kinds_are_refused():
    """Catches: C that works on memory which is not there."""
    points = Points(np.random.default_rng(1).uniform(0, 1, (10, 2)))
    sizes = {"least_seen": 1, "squares": 4, "middle": np.zeros(2), "extent": 1.0, "px_per_mm": 1.0}
    sizes |= {"rules": RULES, "least_correlation": 0.7}
    for first, sides, printed in (
        ([0, 9], [-1], np.ones(10, np.float32)),
        ([0, 10, 10], [-1, -1], np.ones(10, np.float32)),
        ([0, 10], [-1], np.ones(9, np.float32)),
        (list(range(18)), [-1] * 17, np.ones(17, np.float32)),
    ):
        with pytest.raises(ValueError):
            PagePrint(points, first, sides, printed, **sizes)
    shown = PagePrint(points, [0, 10], [-1], np.ones(10, np.float32), **sizes)
    with pytest.raises(ValueError, match="prepared"):
        shown.follow(Picture(np.zeros((20, 20), np.uint8)).struct, np.eye(3))
    with pytest.raises(ValueError):
        shown.prepare(np.ones((2, 9), np.float32))
    with pytest.raises(ValueError):
        PageRows(points, np.array([3], np.int32), 4)
    with pytest.raises(ValueError):
        kernel_library.picture_struct(np.zeros((20, 20), np.float32), np.zeros(256, np.float32))


def test_nothing_is_sought_in_what_is_uniform_or_with_other_sizes():
    """Catches: a correlation of rounding errors; C that works on memory which is not there."""
    uniform, printed = Picture(np.full((60, 60), 90, np.uint8)), np.eye(9, dtype=np.float32)
    total = np.zeros((5, 5), np.float32)
    correlations(uniform.struct, np.eye(3), printed, 1, 2, total)
    assert not total.any()
    for given in ((printed, 1, 3), (printed, 10, 2), (printed, 0, 2), (printed, 1, -1), (printed.astype(float), 1, 2)):
        with pytest.raises(ValueError):
            correlations(uniform.struct, np.eye(3), *given, total)
    with pytest.raises(ValueError):
        correlations(Picture(np.zeros((1, 50), np.uint8)).struct, np.eye(3), printed, 1, 2, total)
