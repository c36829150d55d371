"""The printed page in the form that the analytic renderer reads: markers as a picture, cells as a table.

Convention: board frame of `motion`, mm; "across" is the coordinate along a grating's axis (across its lenses), "along"
the other one of its own frame (`moireid.frames`), both counted from the board's centre.  The table holds the print as
it came out of the printer, so that no ray needs the print's scale.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import CodedFrame, Grating, Markers, Rect
from moireid.layers import is_smooth
from moireid.simulate.scene import Scene
from moireid.smooth_lines import LineField

Array = NDArray[np.float64]
#: The page away from the gratings (markers) as a texture, pixels to the millimetre.
TEXTURE_PX_PER_MM = 12.0
#: Side of the blocks that are checked for one even value, in pixels of the picture.
BLOCK_PX = 12
#: Edges of cells that lie nearer than this are one edge.
SAME_EDGE_MM = 1e-6


class Cells(NamedTuple):
    """All cells of a board; gratings (G, 4): own low across, low along, high across, high along.

    frames (G, 9): the page's directions across and along (x, y, then x, y); what a place along adds to across, and
    one across to along, where a print of two scales shears a turned grating; offset of the sheet, mm, cosine and sine
    of its twist, from across towards along.
    print (G, strips along, strips across, 4) float32: of the cell there, all 0 without one: the lines at the board's
    centre, lines to the millimetre, duty, and by how many lines they slant to the millimetre along.
    bins (G, 2, 4) float32, across and along: where even bins begin, bins to the millimetre, the last one's number, and
    1 where a bin is a strip; else strips, next_cut (G, 2, B) are, of each bin, the strip in which it begins, and the
    cut within it.
    """

    gratings: Array
    frames: Array
    print: NDArray[np.float32]
    bins: NDArray[np.float32]
    strips: NDArray[np.int32]
    next_cut: NDArray[np.float32]


def page_texture(scene: Scene) -> NDArray[np.float32]:
    """The board without its gratings: paper and markers, `TEXTURE_PX_PER_MM`, area-averaged."""
    badge, scale = scene.badge, TEXTURE_PX_PER_MM
    x0, y0, x1, y1 = badge.outline_mm
    picture = np.full((math.ceil((y1 - y0) * scale), math.ceil((x1 - x0) * scale)), scene.paper, np.float32)
    if scene.print_picture is not None:
        picture = _printed(scene.print_picture, picture.shape, scene)
    place_x = (np.arange(picture.shape[1]) + 0.5) / scale + x0
    place_y = (np.arange(picture.shape[0]) + 0.5) / scale + y0
    if isinstance(badge.markers, CodedFrame):
        _draw_frame(picture, badge.markers, place_x, place_y, scene)
    else:
        _draw_squares(picture, badge.markers, place_x, place_y, scene)
    return _spread(picture, scene.build.ink_um / 2000 * scale)


def _spread(picture: NDArray[np.float32], by_px: float) -> NDArray[np.float32]:
    """Dark edges moved outwards by some pixels, whole ones first, then by a share of one."""
    least = np.ones((3, 3), np.uint8)
    for step in range(math.ceil(by_px)):
        picture = picture + np.float32(min(by_px - step, 1.0)) * (cv2.erode(picture, least) - picture)
    return picture


#: Counts of ink and of bare paper in a picture of the print (`print-your-badge` writes it so).
INK_COUNT, PAPER_COUNT = 28, 250


def _printed(print_picture: NDArray[np.uint8], shape: tuple[int, ...], scene: Scene) -> NDArray[np.float32]:
    """Radiance of the board's print, of a picture in colour; what is under a sheet is not used.

    Source: counts are coded by a square root, as a camera's.
    """
    grey = cv2.resize(cv2.cvtColor(print_picture, cv2.COLOR_BGR2GRAY), shape[::-1], interpolation=cv2.INTER_LINEAR)
    share = np.clip((grey.astype(np.float32) - INK_COUNT) / (PAPER_COUNT - INK_COUNT), 0, 1)
    dark, light = math.sqrt(scene.ink), math.sqrt(scene.paper)
    return np.asarray((dark + (light - dark) * share) ** 2, np.float32)


def _draw_squares(
    picture: NDArray[np.float32], markers: Markers, place_x: NDArray[Any], place_y: NDArray[Any], scene: Scene
) -> None:
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
    modules, half = known.markerSize + 2, markers.size_mm / 2
    for identity, (cx, cy) in zip(markers.ids, markers.centers_mm, strict=True):
        bits = np.asarray(cv2.aruco.generateImageMarker(known, identity, modules)) > 127
        columns = np.flatnonzero(np.abs(place_x - cx) < half)
        rows = np.flatnonzero(np.abs(place_y - cy) < half)
        module_x = ((place_x[columns] - cx + half) / markers.size_mm * modules).astype(int)
        module_y = ((place_y[rows] - cy + half) / markers.size_mm * modules).astype(int)
        picture[np.ix_(rows, columns)] = np.where(bits[np.ix_(module_y, module_x)], scene.paper, scene.ink)


def _draw_frame(
    picture: NDArray[np.float32], frame: CodedFrame, place_x: NDArray[Any], place_y: NDArray[Any], scene: Scene
) -> None:
    for rects, light in ((frame.dark_mm, scene.ink), (frame.notches_mm, scene.paper)):
        for x0, y0, x1, y1 in rects:
            # A line is a few pixels of the texture wide, so a pixel at its border counts by its share.
            across, down = (
                np.clip(TEXTURE_PX_PER_MM * (np.minimum(place, high) - np.maximum(place, low)) + 1, 0, 1)
                for place, low, high in (
                    (place_x, x0 + 0.5 / TEXTURE_PX_PER_MM, x1 - 0.5 / TEXTURE_PX_PER_MM),
                    (place_y, y0 + 0.5 / TEXTURE_PX_PER_MM, y1 - 0.5 / TEXTURE_PX_PER_MM),
                )
            )
            picture += np.outer(down, across).astype(np.float32) * (light - picture)


def even_blocks(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """The value of each block of `BLOCK_PX` by `BLOCK_PX` pixels of a picture; NaN where the block is not even."""
    rows, columns = (-(-side // BLOCK_PX) for side in picture.shape)
    room = [(0, rows * BLOCK_PX - picture.shape[0]), (0, columns * BLOCK_PX - picture.shape[1])]
    blocks = np.pad(picture, room, mode="edge").reshape(rows, BLOCK_PX, columns, BLOCK_PX)
    lowest, highest = blocks.min(axis=(1, 3)), blocks.max(axis=(1, 3))
    return np.where(lowest == highest, lowest, np.float32(np.nan))


def cell_table(scene: Scene) -> Cells:
    """The cells of the scene's badge as printed, under sheets of their nominal rectangles; board mm."""
    rects: list[Rect] = []
    frames: list[list[float]] = []
    lines: list[list[float]] = []
    cuts: list[list[Array]] = []
    grids: list[NDArray[np.int64]] = []
    for grating in scene.badge.gratings:
        rects.append(scene.own_rect_mm(grating, grating.rect_mm))
        scale, shear = printed_scales(scene, grating)
        offset_mm, twist_rad = scene.build.lens_offset_mm, scene.build.twist_rad
        frame = scene.badge.frame_of(grating)
        frames.append(
            [*frame.rows[0], *frame.rows[1], *shear, offset_mm, math.cos(twist_rad), frame.handed * math.sin(twist_rad)]
        )
        if is_smooth(grating):
            sides, grid, own = _smooth_table(scene, grating, scale, len(lines))
            cuts.append(sides)
            grids.append(grid)
            lines += own
            continue
        placed = np.array([scene.own_rect_mm(grating, cell.rect_mm) for cell in grating.cells])
        sides = [_cuts(scale[side] * placed[:, [side, side + 2]]) for side in (0, 1)]
        cuts.append(sides)
        grids.append(_grid(placed * np.tile(scale, 2), sides, len(lines)))
        first = float(frame.places(scene.board_centre_mm)[0])
        for cell in grating.cells:
            edge_mm, duty = scene.printed_line(cell)
            lines.append([scale[0] * (edge_mm - first), 1.0 / (scale[0] * cell.pitch_mm), duty, 0.0])
    shape = [max(grid.shape[k] for grid in grids) for k in (0, 1)]
    grid = np.full((len(grids), *shape), -1, np.int64)
    for k, one in enumerate(grids):
        grid[k, : one.shape[0], : one.shape[1]] = one
    table = np.array([*lines, [0.0] * 4])
    table[:, 0] = -table[:, 0] * table[:, 1] % 1.0
    printed = table.astype(np.float32)[grid]
    return Cells(np.array(rects), np.array(frames), printed, *_bins(cuts))


#: At most so many bins over a grating: a strip may be misplaced by one's width, 0.03 mm of a large page.
MOST_BINS = 8192


def _bins(cuts: list[list[Array]]) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.float32]]:
    """`Cells.bins`, `strips` and `next_cut`, of the cuts of each grating; no bin has two cuts, unless too narrow."""
    counts = [[_bin_count(places) for places in sides] for sides in cuts]
    most = max(max(pair) for pair in counts)
    bins, strips, ends = (np.zeros((len(cuts), 2, size), np.float32) for size in (4, most, most))
    for k, sides in enumerate(cuts):
        for side, places in enumerate(sides):
            count = counts[k][side]
            even = count == len(places) + 1
            width = (places[-1] - places[0]) / (count - 2)
            # Half a bin to spare, so that the first cut is within the first bin; but even bins begin at the cuts.
            begin = places[0] - width * (1.0 if even else 0.5) + width * np.arange(count)
            first = np.searchsorted(places, begin)
            bins[k, side] = begin[0], 1 / width, count - 1, even
            strips[k, side, :count], ends[k, side, :count] = first, np.append(places, math.inf)[first]
    return bins, strips.astype(np.int32), ends


def _bin_count(places: Array) -> int:
    """How many bins hold one cut each at most; one more than there are cuts where these are even."""
    shares = (places[-1] - places[0]) / np.diff(places)
    even = np.ptp(shares) < SAME_EDGE_MM * shares.max()
    return len(places) + 1 if even else min(math.ceil(shares.max()) + 3, MOST_BINS)


#: Sides of a smooth field's patches, in which lines are straight: at most so many mm along the axis and across it,
#: and so large a share of how far cells blend.  A line is off by 0.04 of its pitch at most, a printer's dot.
PATCH_MM, PATCH_SHARES = (1.8, 0.9), (0.6, 0.3)


def _smooth_table(
    scene: Scene, grating: Grating, scale: tuple[float, float], first: int
) -> tuple[list[Array], NDArray[np.int64], list[list[float]]]:
    """Cuts, grid and lines of a smooth grating, as a table of small patches; first: number of its first patch.

    Source: the plane that is as far from a patch's corners, on one side, as from its middle, on the other, by half.
    """
    field, centre = LineField(grating), scene.badge.frame_of(grating).places(scene.board_centre_mm)
    spans = (field.low, field.high), (field.begin, field.end)
    reach = [min((one for cell in grating.cells if (one := cell.blend_mm[k])), default=math.inf) for k in (0, 1)]
    sides = [min(most, share * mm) for most, share, mm in zip(PATCH_MM, PATCH_SHARES, reach, strict=True)]
    columns, rows = (
        np.linspace(*span, math.ceil((span[1] - span[0]) / side) + 1) for span, side in zip(spans, sides, strict=True)
    )
    middle, down = (columns[:-1] + columns[1:]) / 2, ((rows[:-1] + rows[1:]) / 2)[:, None]
    corners = field.numbers(columns, rows[:, None])
    per_mm = (np.diff(corners[1:], axis=1) + np.diff(corners[:-1], axis=1)) / 2 / np.diff(columns)
    slant = (np.diff(corners[:, 1:], axis=0) + np.diff(corners[:, :-1], axis=0)) / 2 / np.diff(rows)[:, None]
    level = (corners[1:, 1:] + corners[1:, :-1] + corners[:-1, 1:] + corners[:-1, :-1]) / 4
    level = (level + 2 * field.numbers(middle, down)) / 3
    wider_mm = scene.build.ink_um / 1000
    edge = middle - centre[0] - (level - slant * (down - centre[1])) / per_mm - wider_mm / 2
    duty = np.minimum(field.duty + wider_mm * per_mm, 1.0)
    lines = np.stack([scale[0] * edge, per_mm / scale[0], duty, slant / scale[1]], axis=-1)
    grid = np.full((len(rows) + 1, len(columns) + 1), -1, np.int64)
    grid[1:-1, 1:-1] = first + np.arange(level.size).reshape(level.shape)
    cuts = [scale[0] * (columns - centre[0]), scale[1] * (rows - centre[1])]
    return cuts, grid, lines.reshape(-1, 4).tolist()


def printed_scales(scene: Scene, grating: Grating) -> tuple[tuple[float, float], tuple[float, float]]:
    """Printed over nominal size across and along a grating; and the shear (of across, of along) of its print.

    Convention: a printed place (a, b), own frame, shows what is drawn at ((a + shear b) / scale, (b + shear a) /
        scale), each with its own shear and scale.
    Source: the inverse of R S R^-1, with the page's scales S and the frame's rotation R; 0 along the page's axes.
    """
    x, y = scene.build.print_scales
    (a, b), (c, d) = scene.badge.frame_of(grating).rows
    # Where one weight is 0, the other scale is taken unchanged.
    across, along = (x if not n else y if not m else 1 / (m * m / x + n * n / y) for m, n in ((a, b), (c, d)))
    mixed = a * c / x + b * d / y
    return (across, along), (mixed * across, mixed * along)


def _cuts(spans: Array) -> Array:
    """All different edges of spans (N, 2), rising."""
    cuts = np.unique(spans)
    return np.asarray(cuts[np.concatenate([[True], np.diff(cuts) > SAME_EDGE_MM])])


def _grid(placed: Array, sides: list[Array], first: int) -> NDArray[np.int64]:
    """The cell in each strip along and across; where cells overlap, the first one counts.  placed (N, 4): of cells."""
    grid = np.full((len(sides[1]) + 1, len(sides[0]) + 1), -1, np.int64)
    for number in range(len(placed) - 1, -1, -1):
        spans = []
        for cuts, side in ((sides[1], 1), (sides[0], 0)):
            low, high = placed[number, side], placed[number, side + 2]
            # Edges of neighbours may differ in the last digits; the strip's number is that of the nearest cut.
            spans.append(slice(int(np.abs(cuts - low).argmin()) + 1, int(np.abs(cuts - high).argmin()) + 1))
        grid[spans[0], spans[1]] = first + number
    return grid
