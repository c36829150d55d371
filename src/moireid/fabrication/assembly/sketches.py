"""The small pictures next to the steps: line drawings of what hands do, in proportion to the badge, and its fringes.

The pictures of fringes show how the badge looks when the sheet is placed well, is turned, or has another pitch.  The
project's own optics compute them: each pixel takes the brightness of the lens above it, which is the mean over that
lens's rays of the printed lines on which they land.  Codes and plain rows are drawn as they are printed, so a picture
looks like the badge.

Convention: each takes an area of the page (x0, y0, x1, y1), mm, y down, and draws within it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from moireid.badge import Badge, Grating, Point, Rect
from moireid.fabrication.assembly.exploded import box_loop, lines_across
from moireid.fabrication.page.canvas import PdfPage
from moireid.fabrication.page.marks import INK, PAPER
from moireid.fabrication.page.pitch_bands import look_m, pitch_bands
from moireid.fabrication.page.preview import lines_over, rays_landed_mm, smooth_light, view_mm
from moireid.fabrication.sight import corners_in_frame, half_board_mm, has_turned, in_frame, sheet_pieces
from moireid.frames import own_rect
from moireid.layers import is_smooth

PX_PER_MM, RAYS = 1.2, 8
Array = NDArray[np.float64]
#: Turn of a sheet that was placed by eye: its fringes lean clearly.
LEANING_DEG = 0.5
#: Fringes of a sheet whose pitch is not the label's, over those of the design; below 0 they run the other way.
WIDER, OTHER_WAY = 0.45, -1.0
Draw = Callable[[PdfPage, Rect], None]
#: A picture's gap to the next one, and the reach of an arrow's head, mm.
GAP_MM, HEAD_MM = 3.0, 1.6
#: Room for the arrow below a picture of fringes; paper above a board where bands have all their height, mm.
ARROW_MM, ROOM_ABOVE_MM = 3.5, 50.0


def fringe_pictures(
    badge: Badge, asides_mm: Sequence[float] = (0.0,), /, turned_deg: float = 0.0, beats: float = 1.0
) -> list[Image.Image]:
    """The first grating under its sheet, grey, its axis across: as it looks from `view_mm` before its middle.

    Parameters: asides_mm: how far the eye is from there along the axis, a picture each; turned_deg: how far the sheet
        is turned on the page, about the field's middle; beats: how many times as many fringes as designed the sheet
        shows, because its pitch is not the label's.
    Source: `lenticule.trace_mm`, or `optics.slab_shift_mm` for a mask.
    """
    first, pitch_mm, turn_rad = badge.gratings[0], _pitch_mm(badge, badge.gratings[0], beats), math.radians(turned_deg)
    x0, y0, x1, y1 = own_rect(first.axis, first.rect_mm)
    # A picture of a whole A5 sheet is as large as one of a card.
    scale = PX_PER_MM * min(1.0, 140.0 / (x1 - x0))
    size = (max(2, round((y1 - y0) * scale)), max(2, round((x1 - x0) * scale)))
    rows, columns = np.meshgrid(*(np.arange(n) + 0.5 for n in size), indexing="ij")
    across, along = x0 + columns / scale, y0 + rows / scale
    # Across the lenses, from the middle; and the number of the lens above each pixel, from the first.
    over = (across - (x0 + x1) / 2) * math.cos(turn_rad) + (along - (y0 + y1) / 2) * math.sin(turn_rad)
    lens = np.round(over / pitch_mm).astype(int)
    place = across + (lens * pitch_mm - over) * math.cos(turn_rad)
    lens_axes, lens = np.arange(lens.min(), lens.max() + 1) * pitch_mm, lens - lens.min()
    lines = lines_over(badge.lens, first, place, along) if is_smooth(first) else None
    pictures = []
    for aside_mm in asides_mm:
        rays = rays_landed_mm(badge.lens, ((lens_axes - aside_mm) / view_mm(badge))[:, None], RAYS)
        if lines:
            light = smooth_light(lines, first, [ray[lens] for ray in rays.T.astype(np.float32)])
        else:
            light = _light_of_cells(first, (across, along), place[..., None] + rays[lens])
        pictures.append(Image.fromarray((INK + (PAPER - INK) * light).astype(np.uint8)))
    return pictures


def _light_of_cells(grating: Grating, own: tuple[Array, Array], landed: Array) -> Array:
    """Brightness, 0 to 1, of pixels at own places (rows, columns), whose rays land at places (rows, columns, rays)."""
    (across, along), light = own, np.ones(own[0].shape)
    for cell in grating.cells:
        cx0, cy0, cx1, cy1 = own_rect(grating.axis, cell.rect_mm)
        within = (across >= cx0) & (across < cx1) & (along >= cy0) & (along < cy1)
        light[within] = ((landed[within] - cell.edge_mm) / cell.pitch_mm % 1.0 >= cell.duty).mean(axis=1)
    return light


def _pitch_mm(badge: Badge, grating: Grating, beats: float) -> float:
    """The lens pitch that shows so many times as many fringes."""
    lines, lenses = 1 / grating.pitch_mm, 1 / badge.lens.pitch_mm
    # Lines may be nearly as many as the lenses, or nearly twice as many.
    order = max(1, round(lines / lenses))
    return order / (lines - beats * (lines - order * lenses))


class BadgeSketch:
    """The badge drawn small: places of its frame (`fabrication.sight`) on the page."""

    def __init__(self, badge: Badge, area: Rect, *, spare: float = 1.0) -> None:
        """Parameters: spare: share of the area that the board fills."""
        self.badge, self.half = badge, half_board_mm(badge)
        self.scale = spare * min((area[2 + k] - area[k]) / 2 / self.half[k] for k in (0, 1))
        self.middle = ((area[0] + area[2]) / 2, (area[1] + area[3]) / 2)

    def at(self, place: Point) -> Point:
        """Where a place of the frame is drawn."""
        return self.middle[0] + place[0] * self.scale, self.middle[1] - place[1] * self.scale

    def box(self, x0: float, y0: float, x1: float, y1: float) -> list[Point]:
        """A rectangle of the frame, as it is drawn."""
        return [self.at(place) for place in box_loop((x0, y0, x1, y1))]

    def draw(self, sheet: PdfPage, *, dash_mm: float | None = None) -> None:
        """The outline, the markers, and the striped fields."""
        half_x, half_y = self.half
        sheet.path(self.box(-half_x, -half_y, half_x, half_y), 1.0, 0.2, dash_mm=dash_mm)
        for dark in self.badge.markers.dark_mm:
            sheet.path(self.box(*in_frame(dark, self.badge)), 0.25, None)
        for grating in self.badge.gratings:
            corners = [self.at(place) for place in corners_in_frame(self.badge, grating, grating.rect_mm)]
            sheet.path(corners, 0.9, None)
            stripes(sheet, corners, 1.1, 0.55)

    def pieces(self, sheet: PdfPage, moved: Point = (0.0, 0.0)) -> None:
        """The pieces of sheet, lenses sketched, moved on the page by mm."""
        for _, corners in sheet_pieces(self.badge):
            drawn = [(x + moved[0], y + moved[1]) for x, y in (self.at(corner) for corner in corners)]
            sheet.path(drawn, 0.97, 0.1)
            stripes(sheet, drawn, 2.2, 0.75)


def stripes(sheet: PdfPage, corners: Sequence[Point], step_mm: float, grey: float) -> None:
    """Lines across the first side of a rectangle."""
    for ends in lines_across(corners, step_mm):
        sheet.path(ends, None, grey, closed=False)


def arrow(sheet: PdfPage, start: Point, end: Point, *, both: bool = False) -> None:
    """A straight arrow; both: with a head at either end."""
    sheet.path([start, end], None, 0.0, closed=False)
    for tip, tail in ((end, start), (start, end))[: 2 if both else 1]:
        way = math.atan2(tip[1] - tail[1], tip[0] - tail[0])
        wings = [
            (tip[0] - HEAD_MM * math.cos(way + turn), tip[1] - HEAD_MM * math.sin(way + turn)) for turn in (0.4, -0.4)
        ]
        sheet.path([tip, *wings], 0.0, None)


def measure(sheet: PdfPage, area: Rect) -> None:
    """A ruler on a scale bar."""
    x0, x1, y = area[0] + 3, area[2] - 3, (area[1] + area[3]) / 2
    for k in range(16):
        x = x0 + (x1 - x0) * k / 15
        sheet.stroke(x, y, x, y - (3.0 if k % 5 == 0 else 1.6), 0.15)
    sheet.stroke(x0, y, x1, y, 0.3)
    sheet.path(box_loop((x0 - 2, y + 0.8, x1 + 2, y + 7)), 0.92, 0.3)
    for k in range(16):
        x = x0 + (x1 - x0) * k / 15
        sheet.stroke(x, y + 0.8, x, y + (3.4 if k % 5 == 0 else 2.2), 0.15)
    sheet.text(x0, y + 6, "0", points=6, align="center")
    sheet.text(x1, y + 6, "150", points=6, align="center")
    sheet.text((x0 + x1) / 2, y - 4.5, "150.0 mm", points=7)


def cut(badge: Badge, sheet: PdfPage, area: Rect) -> None:
    """The board among its crop marks."""
    board = BadgeSketch(badge, area, spare=0.78)
    board.draw(sheet, dash_mm=1.0)
    for side_x in (-1, 1):
        for side_y in (-1, 1):
            x, y = board.at((side_x * board.half[0], side_y * board.half[1]))
            sheet.stroke(x + side_x, y, x + 3 * side_x, y, 0.25)
            sheet.stroke(x, y - side_y, x, y - 3 * side_y, 0.25)


def lay(badge: Badge, sheet: PdfPage, area: Rect) -> None:
    """The sheet on its way to the board."""
    board = BadgeSketch(badge, area, spare=0.8)
    board.middle = (board.middle[0] - 5, board.middle[1] + 1)
    board.draw(sheet)
    board.pieces(sheet, (9.0, -3.5))
    x, y = board.at((board.half[0], -board.half[1]))
    arrow(sheet, (x + 8.5, y - 6), (x + 2, y - 3.5))


def runs_right(badge: Badge, beats: float = 1.0) -> bool:
    """Whether the fringes of the first grating run to the right, along its axis, as the eye moves to the right.

    Source: x where the phase of `optics.fringe_phase_rad` stays: dx/dCx = (g_eff / (p_r Cz)) / f_b, f_b as `_pitch_mm`.
    """
    lines, lenses = 1 / badge.gratings[0].pitch_mm, 1 / badge.lens.pitch_mm
    return beats * (lines - max(1, round(lines / lenses)) * lenses) > 0


def fringes(badge: Badge, looks: Sequence[dict[str, float]], sheet: PdfPage, area: Rect) -> None:
    """The fringes that are seen, one picture a look (`fringe_pictures`'s parameters), and which way they run."""
    wide = (area[2] - area[0] - GAP_MM * (len(looks) - 1)) / len(looks)
    for k, look in enumerate(looks):
        left = area[0] + k * (wide + GAP_MM)
        _place(sheet, fringe_pictures(badge, **look)[0], (left, area[1], wide, area[3] - area[1] - ARROW_MM))
        middle, y, half = left + wide / 2, area[3] - ARROW_MM / 2, wide / 5
        way = 1 if runs_right(badge, look.get("beats", 1.0)) else -1
        arrow(sheet, (middle - way * half, y), (middle + way * half, y))


def bands(badge: Badge, sheet: PdfPage, area: Rect) -> None:
    """The pitch bands under the sheet of the design, from `look_m`."""
    x0, _, x1, _ = badge.outline_mm
    found = pitch_bands(badge, (x0, ROOM_ABOVE_MM, x1, ROOM_ABOVE_MM))
    assert found is not None
    (seen,) = fringe_pictures(replace(badge, gratings=(found,), range_m=(look_m(badge), look_m(badge))))
    _place(sheet, seen, (area[0], area[1], area[2] - area[0], area[3] - area[1]))


#: The looks that a builder meets: as it should be; turned; running the other way; of too few fringes.
GOOD: dict[str, float] = {}
LEANING: dict[str, float] = {"turned_deg": LEANING_DEG}
MIRRORED: dict[str, float] = {"beats": OTHER_WAY}
WIDE: dict[str, float] = {"beats": WIDER}


def _place(sheet: PdfPage, picture: Image.Image, room: tuple[float, float, float, float]) -> None:
    """A picture in the middle of a room (x, y, width, height), as large as fits."""
    dot_mm = min(room[2] / picture.width, room[3] / picture.height)
    x = room[0] + (room[2] - picture.width * dot_mm) / 2
    y = room[1] + (room[3] - picture.height * dot_mm) / 2
    # A raster may count a dot that the picture's border merely touches, and stretch the picture over it.
    inset = 0.05 * dot_mm
    right, low = x + picture.width * dot_mm, y + picture.height * dot_mm
    sheet.picture(picture, (x + inset, y + inset, right - inset, low - inset))


def held(badge: Badge, sheet: PdfPage, area: Rect, *, taped: bool) -> None:
    """Sheet on the board, held at its left and right edges: by tape, or by a mount that goes over them."""
    board = BadgeSketch(badge, area, spare=0.85)
    board.draw(sheet)
    board.pieces(sheet)
    half_x, half_y = board.half
    strip = max(2.0, 1.2 / board.scale)
    if has_turned(badge):
        for _, corners in sheet_pieces(badge):
            for k in (1, 3):
                sheet.path([board.at(place) for place in _along(corners, k, strip)], 0.7, 0.2)
        if taped:
            return
    rows = [y for _, corners in sheet_pieces(badge) for _, y in corners]
    low, high = (min(rows), max(rows)) if taped else (-half_y, half_y)
    for side in (-1, 1):
        out = half_x + (0.0 if taped else strip)
        left, right = sorted((side * (half_x - strip), side * out))
        sheet.path(board.box(left, low, right, high), 0.7, 0.2)
    if not taped:
        sheet.path(board.box(-half_x - strip, -half_y - strip, half_x + strip, -half_y), 0.7, 0.2)
        x, y = board.at((0, half_y))
        arrow(sheet, (x, y - 2.5), (x, y + 4))
        x, y = board.at((half_x, 0))
        arrow(sheet, (x + 4, y), (x - 5, y))


def _along(corners: Sequence[Point], side: int, wide: float) -> list[Point]:
    """A strip that lies about a side of a rectangle, the side that begins at that corner."""
    (ax, ay), (bx, by) = corners[side], corners[(side + 1) % 4]
    length = math.dist((ax, ay), (bx, by))
    x, y = (ay - by) / length * wide / 2, (bx - ax) / length * wide / 2
    return [(ax + x, ay + y), (bx + x, by + y), (bx - x, by - y), (ax - x, ay - y)]


def carried(badge: Badge, kind: str, slots: int, sheet: PdfPage, area: Rect) -> None:
    """The badge as it is worn, or on its stand; slots: lanyard slots of a mount."""
    if kind == "stand":
        x, y = (area[0] + area[2]) / 2, area[3] - 2
        sheet.path([(x - 12, y), (x + 12, y)], None, 0.0, closed=False)
        sheet.path([(x + 4, y - 1), (x + 8, y - 1), (x + 2, y - 12), (x + 1, y - 12)], 0.75, 0.2)
        sheet.path([(x + 5, y - 1.5), (x + 6.2, y - 1.5), (x + 2, y - 20), (x + 0.8, y - 20)], 1.0, 0.0)
        return
    board = BadgeSketch(badge, (area[0], area[1] + 6, area[2], area[3]), spare=0.95)
    board.draw(sheet)
    board.pieces(sheet)
    for share in (-0.6, 0.6) if slots == 2 else (0.0,):
        x, y = board.at((share * board.half[0], board.half[1]))
        if kind == "clip":
            # The clip from the front, its hook through the slot, its jaws above.
            sheet.path([(x - 2, y - 6), (x + 2, y - 6), (x + 1.4, y), (x - 1.4, y)], 0.6, 0.0)
            arrow(sheet, (x + 6, y - 4), (x + 2.6, y - 3))
        else:
            sheet.path([(x, y), (x + (0.4 * (x - board.middle[0])), area[1])], None, 0.0, closed=False)
        sheet.path(box_loop((x - 1.6, y, x + 1.6, y - 1.2)), 0.75, 0.2)


def film(badge: Badge, look_m: float, sheet: PdfPage, area: Rect) -> None:
    """A phone before the badge, which moves to and fro."""
    wide = (area[2] - area[0]) / 2
    board = BadgeSketch(badge, (area[0], area[1] + 2, area[0] + wide, area[3] - 6), spare=0.95)
    board.draw(sheet)
    board.pieces(sheet)
    x, y = board.middle[0], area[3] - 1.5
    arrow(sheet, (x - 9, y), (x + 9, y), both=True)
    sheet.text(x, y - 1.2, "20 cm", points=6)
    phone = (area[2] - 11, area[1] + 4, area[2] - 3, area[3] - 6)
    sheet.path(box_loop(phone), 0.4, 0.0)
    sheet.path(box_loop((phone[0] + 0.8, phone[1] + 1.6, phone[2] - 0.8, phone[3] - 1.6)), 1.0, None)
    middle = (phone[1] + phone[3]) / 2
    start = area[0] + wide + 1
    sheet.path([(start, middle), (phone[0] - 1, middle)], None, 0.5, closed=False, dash_mm=0.8)
    sheet.text((start + phone[0] - 1) / 2, middle - 1.2, f"{look_m:g} m", points=6)
