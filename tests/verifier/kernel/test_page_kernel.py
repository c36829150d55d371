"""The kernel against the same equations in NumPy and OpenCV, on films and on pictures at the edge.

Beside each test: the wrong implementation it catches.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import cv2
import numpy as np
import pytest

from kit import numpy_kernel
from kit.drawn_pages import MARKERS, apart_px, draw, filmed, nudged, seen_from
from moireid.badge import load_badge
from moireid.errors import MoireIdError
from moireid.verifier.kernel import library as kernel_library
from moireid.verifier.kernel.page import (
    OTHER_SCALE,
    PagePrint,
    PageRows,
    Points,
    correlations,
    expected_page,
    values_at,
)
from moireid.verifier.picture import Picture, as_picture
from moireid.verifier.tracking.brightness_profiles import ProfileReader
from moireid.verifier.tracking.registration import MIN_SHARE, RULES, KeptTemplate, PageRegistrar, scale_px_per_mm
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.video import VIDEO_RANGE, Film

FILMS = Path(__file__).parents[2] / "data" / "films"
NAMES = {path.stem: "badge_mask" if "path" in path.stem else "badge" for path in sorted(FILMS.glob("*.mp4"))}
#: One frame in so many of a film is compared.
EVERY = 12


def enough(seen):
    return sum(seen) >= MIN_SHARE * len(seen)


def both(registrar, picture, start, template):
    """Registration by the kernel, and the homography page mm -> px and the comparison by NumPy; None if neither is."""
    warp = start @ registrar._to_page
    one = registrar.register(picture, start, template)
    other = numpy_kernel.registered(picture, warp, template, enough)
    assert (one is None) == (other is None)
    if one is None:
        return None
    page = other[0] @ registrar._from_page
    return one, page / page[2, 2], other[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_pages_and_rows_of_films_are_those_of_numpy(name):
    """Catches: a step, a rule or a rounding of the kernel that differs: 1e-4 px of the page, 0.02 of light."""
    badge = load_badge(FILMS / f"{NAMES[name]}.json")
    scene, compared = SceneTracker(badge), 0
    registrar, reader = scene._registrar, scene._reader
    for frame in Film(FILMS / f"{name}.mp4").frames():
        expected = scene.trackers[0].ends.expected(frame.index)
        found = scene.push(frame)
        if not found or expected is None or frame.index % EVERY:
            continue
        template = registrar.printer.draw(scale_px_per_mm(expected, registrar.printer.middle))
        pair = both(registrar, frame.picture, expected, template)
        if pair is None:
            continue
        one, page, other = pair
        assert apart_px(one.homography, page) < 1e-4
        assert one.correlation == pytest.approx(other.correlation, abs=1e-6)
        rows = numpy_kernel.row_means(
            frame.picture.in_light, page, reader.rows.points.page, reader._row_counts, reader.samples
        )
        # A value that is half way between two counts may be rounded to either.
        assert np.abs(reader.read(frame.picture, page) - rows).max() < 0.3
        assert np.abs(reader.read(frame.picture, page) - rows).mean() < 0.001
        compared += 1
    assert compared >= 5


@pytest.mark.parametrize("noise", [0.0, 6.0])
def test_a_drawn_page_is_registered_where_numpy_registers_it(rng, noise):
    """Catches: a wrong step of the kernel, as in the slow test, in a second."""
    truth = seen_from()
    picture, registrar = as_picture(filmed(draw(truth), rng, noise=noise)), PageRegistrar(MARKERS)
    start = nudged(truth, 1.2, -0.8, 1.004)
    one, page, other = both(registrar, picture, start, registrar.printer.draw(scale_px_per_mm(start, np.zeros(2))))
    assert apart_px(one.homography, page) < 1e-4
    assert one.correlation == pytest.approx(other.correlation, abs=1e-6)
    assert one.contrast == pytest.approx(other.contrast, rel=1e-5)


def test_the_prepared_rows_and_their_products_are_those_of_numpy():
    """Catches: a patch's gain or offset left in the rows; products of the wrong patch."""
    registrar = PageRegistrar(MARKERS)
    template = registrar.printer.draw(3.0)
    shown = registrar._print_of(template)
    shown.prepare(template.gradient() * np.float32(template.extent))
    free = numpy_kernel.free_rows(template)
    assert np.abs(shown.free - free).max() < 1e-5 * np.abs(free).max()
    seen = [True, False, True, True]
    used = free * np.array(seen)[template.samples.patch]
    assert shown.normal(seen) == pytest.approx(used @ used.T, rel=1e-4, abs=1e-4 * np.abs(used @ used.T).max())


def test_rows_are_read_from_padded_planes_and_go_on_beyond_the_picture(rng):
    """Catches: a stride taken for a width; a read before the first or after the last pixel of the picture."""
    plane = np.full((90, 160), 255, np.uint8)
    plane[:, :121] = rng.integers(16, 236, (90, 121))
    across, down = np.meshgrid(np.linspace(-30, 150, 64), np.linspace(-25, 110, 12))
    points = np.column_stack([across.ravel(), down.ravel()])
    warp = np.array([[0.9, 0.1, 2.0], [-0.1, 1.1, 3.0], [1e-4, -2e-4, 1.0]])
    picture, counts = Picture(plane[:, :121], VIDEO_RANGE).in_light, np.array([5, 7], np.int32)
    found = PageRows(Points(points), counts, 64, 0.9).read(picture.struct, warp)
    assert np.abs(found - numpy_kernel.row_means(picture, warp, points, counts, 64)).max() < 0.3


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
        rows = PageRows(points, np.array([3, 5], np.int32), 50, 0.9).read(picture.struct, warp)
        assert np.array_equal(rows, np.full((2, 50), 100.0))
        values = values_at(picture.struct, warp, points)
        assert values is None or np.array_equal(values, np.full(400, 100.0))


def test_a_picture_of_one_row_or_column_holds_no_place():
    """Catches: a second row that is read below the only one."""
    for shape in ((1, 50), (50, 1)):
        assert values_at(Picture(np.zeros(shape, np.uint8)).struct, np.eye(3), Points(np.zeros((1, 2)))) is None


def test_arrays_of_other_sizes_or_kinds_are_refused():
    """Catches: C that works on memory which is not there."""
    points = Points(np.random.default_rng(1).uniform(0, 1, (10, 2)))
    sizes = {"least_seen": 1, "squares": 4, "middle": np.zeros(2), "extent": 1.0, "px_per_mm": 1.0, "scale_step": 1.2}
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
        PageRows(points, np.array([3], np.int32), 4, 0.9)
    with pytest.raises(ValueError, match="no rows"):
        PageRows(points, np.array([5], np.int32), 2, 0.9).taken()
    with pytest.raises(ValueError):
        kernel_library.picture_struct(np.zeros((20, 20), np.float32), np.zeros(256, np.float32))


def test_a_library_that_is_missing_or_of_another_version_is_one_sentence(monkeypatch):
    """Catches: a traceback, or a wrong structure handed to an old library."""
    monkeypatch.setattr(kernel_library, "VERSION", kernel_library.VERSION + 1)
    with pytest.raises(MoireIdError, match=r"has version \d+, \d+ is needed; build it by `make setup`"):
        kernel_library.library.__wrapped__()
    monkeypatch.setattr(kernel_library, "NAME", "_none.so")
    with pytest.raises(MoireIdError, match="cannot be loaded"):
        kernel_library.library.__wrapped__()
    assert isinstance(kernel_library.library(), ctypes.CDLL)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0, 2.0])
def test_a_motion_is_repeated_as_by_numpy(rng, share):
    """Catches: a cofactor of the wrong sign or place; a motion undone; a share of the wrong page."""
    before, last = (nudged(seen_from(), *rng.uniform(-9, 9, 2), 1 + rng.uniform(-0.05, 0.05)) for _ in range(2))
    last = last + rng.normal(0, 1e-6, (3, 3)) * [[0, 0, 0], [0, 0, 0], [1, 1, 0]]
    found = expected_page(before, last, share)
    assert found == pytest.approx(numpy_kernel.expected_page(before, last, share), rel=1e-9)
    assert np.array_equal(expected_page(np.zeros((3, 3)), last, share), last)


def test_rows_are_read_with_the_page_only_where_it_is_certain(rng, ada):
    """Catches: rows of the expected place in place of the page's; rows of a page that must still be judged; a kept room
    that the next frame overwrites; a print of another scale that is used.
    """
    badge_page = np.array([[3.0, 0.02, 40.0], [-0.02, 3.0, 30.0], [0, 0, 1.0]])
    reader = ProfileReader(ada)
    registrar = PageRegistrar(ada.markers)
    size = tuple(int(3.0 * side) + 80 for side in reversed(ada.page_mm))
    page = filmed(draw(badge_page, ada.markers, shape=size), rng, noise=1.0)
    kept = KeptTemplate(registrar.printer)
    start = nudged(badge_page, 1.0, -0.7)
    found, rows = registrar.follow(as_picture(page), start, kept, reader.rows)
    assert rows is not None and np.array_equal(rows, reader.read(page, found.homography))
    again, more = registrar.follow(as_picture(page), start, kept, reader.rows)
    assert np.array_equal(again.homography, found.homography) and np.array_equal(more, rows) and more is not rows
    dark = filmed(np.where(draw(badge_page, ada.markers, shape=size) > 100, 60, 50).astype(float), rng, noise=6.0)
    unsure, none = registrar.follow(as_picture(dark), start, kept, reader.rows)
    assert unsure is None or (unsure.correlation < 0.9 and none is None)
    shown = registrar._prepared(kept.at(start))
    twice = np.array([[6.0, 0, 40.0], [0, 6.0, 30.0], [0, 0, 1.0]])
    assert shown.follow(as_picture(page).struct, twice, any_scale=False)[0] == OTHER_SCALE


@pytest.mark.parametrize(("fewer", "reach"), [(1, 3), (3, 2), (4, 5)])
def test_a_print_is_sought_as_by_opencv(rng, fewer, reach):
    """Catches: a shift down for one across; blocks half a sample off; a sum that is not started anew for each row; a
    correlation with the opposite of the print.
    """
    plane = cv2.GaussianBlur(rng.integers(0, 256, (150, 190)).astype(np.float32), (0, 0), 2.0)
    picture = as_picture(np.clip(4 * (plane - 128) + 128, 0, 255).astype(np.uint8))
    warp = np.array([[0.9, 0.1, 60.0], [-0.1, 1.1, 50.0], [1e-4, -2e-4, 1.0]])
    printed = values_at(
        picture.struct,
        warp,
        Points(np.column_stack([grid.ravel() for grid in np.meshgrid(range(33), range(29))]) + 0.0),
    ).reshape(29, 33)
    moved = warp @ np.array([[1, 0, -fewer], [0, 1, 2.0 * fewer], [0, 0, 1]])
    total = np.full((2 * reach + 1, 2 * reach + 1), 0.25, np.float32)
    correlations(picture.struct, moved, printed, fewer, reach, total)
    expected = numpy_kernel.correlations(picture, moved, printed, fewer, reach)
    assert total - 0.25 == pytest.approx(expected, abs=2e-3)
    assert np.unravel_index(int(total.argmax()), total.shape) == (reach - 2, reach + 1)


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
