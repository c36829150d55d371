"""What a camera must see of the badge, and whether a part of a mount hides it.

An edge of height h above a layer hides a strip of it that is h tan(angle) wide.  Fringes are in the plane of the
lenses, markers in the plane of the card.

Convention: a mount's frame has x right, y up and z towards the viewer, in mm; its origin is the board's centre on the
plane that carries the board.  Page coordinates turn into it by x = page_x - centre_x, y = centre_y - page_y.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from moireid.badge import Badge, CodedFrame, Grating, Point, Rect
from moireid.errors import FabricationError
from moireid.frames import own_rect

#: A mount must hide no fringes from a camera up to this far to the side ...
GRATING_SIGHT_DEG = 60.0
#: ... and no markers up to this angle, since a camera that sees the markers sharply is never farther to the side.
MARKER_SIGHT_DEG = 45.0
FRAME_SIDES = ("top of the frame", "right side of the frame", "bottom of the frame", "left side of the frame")
#: Between two pieces of lens sheet that are cut to meet.
SEAM_MM = 0.1
#: A piece over a turned grating is cut larger by this on each side, because it is placed by hand.
OVERLAP_MM = 1.0


@dataclass(frozen=True)
class Obstacle:
    """A part next to the badge that may hide it: its name, its rectangle from the front, and its top's height, mm."""

    name: str
    rect: Rect
    top_mm: float


def half_board_mm(badge: Badge) -> tuple[float, float]:
    """Half the board's width and height."""
    x0, y0, x1, y1 = badge.outline_mm
    return (x1 - x0) / 2, (y1 - y0) / 2


def front_mm(badge: Badge, film_mm: float) -> float:
    """Thickness of all that lies on the card: the lens sheet, or a mask's spacer with its film."""
    return badge.lens.thickness_mm + (film_mm if badge.lens.kind == "mask" else 0.0)


def front_word(badge: Badge) -> str:
    """The word for what lies on the card, with the option that chooses it, for messages."""
    return "spacer (lens_thickness_mm)" if badge.lens.kind == "mask" else "lens sheet (lens)"


def in_frame(rect: Rect, badge: Badge) -> Rect:
    """A page rectangle in the mount's frame, its lower corner first again, since y changes its sign."""
    x0, y0, x1, y1 = badge.outline_mm
    centre_x, centre_y = (x0 + x1) / 2, (y0 + y1) / 2
    return (rect[0] - centre_x, centre_y - rect[3], rect[2] - centre_x, centre_y - rect[1])


def on_page(rect: Rect, badge: Badge) -> Rect:
    """The inverse of `in_frame`."""
    x0, y0, x1, y1 = badge.outline_mm
    centre_x, centre_y = (x0 + x1) / 2, (y0 + y1) / 2
    return (rect[0] + centre_x, centre_y - rect[3], rect[2] + centre_x, centre_y - rect[1])


def sheet_spans(badge: Badge) -> tuple[tuple[float, float], ...]:
    """Rows (low, high) that sheets cover, from bottom to top; gratings that share rows share a pair of lips."""
    spans: list[tuple[float, float]] = []
    bounds = (in_frame(badge.bounds_of(g), badge) for g in badge.gratings)
    for _, low, _, high in sorted(bounds, key=lambda rect: rect[1]):
        if spans and low <= spans[-1][1]:
            spans[-1] = (spans[-1][0], max(spans[-1][1], high))
        else:
            spans.append((low, high))
    return tuple(spans)


def sheet_rects(badge: Badge) -> tuple[Rect, ...]:
    """The rectangles of lens sheet, each from edge to edge of the board so that lips can hold it.

    Gratings that share rows have one each, parted half-way between them by `SEAM_MM`.  Turned ones have pieces of their
    own (`sheet_pieces`), which are taped to the card; they share the rectangle that holds them all.
    """
    half_x, _ = half_board_mm(badge)
    if has_turned(badge):
        return tuple((-half_x, low, half_x, high) for low, high in sheet_spans(badge))
    pieces: list[Rect] = []
    for low, high in sheet_spans(badge):
        here = sorted(rect for g in badge.gratings if low <= (rect := in_frame(g.rect_mm, badge))[1] < high)
        seams = [(one[2] + other[0]) / 2 for one, other in itertools.pairwise(here)]
        lefts = [-half_x, *(seam + SEAM_MM / 2 for seam in seams)]
        rights = [*(seam - SEAM_MM / 2 for seam in seams), half_x]
        pieces += [(left, low, right, high) for left, right in zip(lefts, rights, strict=True)]
    return tuple(pieces)


def sheet_pieces(badge: Badge) -> tuple[tuple[Grating, tuple[Point, ...]], ...]:
    """Each piece of lens sheet to cut: its grating, and its corners in the frame, the side across the lenses first."""
    pieces = []
    if has_turned(badge):
        for grating in badge.gratings:
            x0, y0, x1, y1 = grating.rect_mm
            covering = (x0 - OVERLAP_MM, y0 - OVERLAP_MM, x1 + OVERLAP_MM, y1 + OVERLAP_MM)
            pieces.append((grating, corners_in_frame(badge, grating, covering)))
        return tuple(pieces)
    for rect in sheet_rects(badge):
        x, y = (rect[0] + rect[2]) / 2, (rect[1] + rect[3]) / 2
        bounds = ((g, in_frame(g.rect_mm, badge)) for g in badge.gratings)
        grating = next(g for g, (x0, y0, x1, y1) in bounds if x0 <= x <= x1 and y0 <= y <= y1)
        pieces.append((grating, corners_in_frame(badge, grating, on_page(rect, badge))))
    return tuple(pieces)


def piece_sizes(badge: Badge) -> Counter[Point]:
    """How many pieces of lens sheet there are of each size: width across the lenses and length along them, mm."""
    return Counter(
        (round(math.dist(corners[0], corners[1]), 3), round(math.dist(corners[1], corners[2]), 3))
        for _, corners in sheet_pieces(badge)
    )


def has_turned(badge: Badge) -> bool:
    """Whether a grating's axis is an angle."""
    return any(not isinstance(grating.axis, str) for grating in badge.gratings)


def corners_in_frame(badge: Badge, grating: Grating, rect_mm: Rect) -> tuple[Point, ...]:
    """Corners of a rectangle, given as the grating's own is, in the frame; the first two lie along its axis."""
    x0, y0, x1, y1 = badge.outline_mm
    corners = badge.frame_of(grating).corners_mm(own_rect(grating.axis, rect_mm)).tolist()
    return tuple((x - (x0 + x1) / 2, (y0 + y1) / 2 - y) for x, y in corners)


def sight_fault(
    badge: Badge, obstacles: Iterable[Obstacle], *, card_top: float, sheet_top: float, play_mm: float, advice: str
) -> FabricationError | None:
    """What hides a fringe or a marker, wherever the board may slide; None where nothing does.

    Parameters
    ----------
    card_top, sheet_top : float
        Heights of page and lenses in the frame, mm.
    play_mm : float
        How far the board may slide along each axis, mm.
    advice : str
        The next step of the message, "take …".

    Returns
    -------
    FabricationError or None
        It names the worst obstacle and what it hides, with `have_mm` and `need_mm`; for markers `over_mm` is how much
        lower the obstacle must be.
    """
    obstacles = list(obstacles)
    worst, fault = 0.0, None
    for target, rect, level, angle_deg in _targets(badge, card_top, sheet_top):
        slope = math.tan(math.radians(angle_deg))
        for obstacle in obstacles:
            have_mm = gap_mm(rect, obstacle.rect, play_mm=play_mm)
            need_mm = (obstacle.top_mm - level) * slope
            if need_mm - have_mm <= worst:
                continue
            worst = need_mm - have_mm
            fault = FabricationError(
                f"the mount's {obstacle.name} leaves {have_mm:.2f} mm next to {target}, but {need_mm:.2f} mm are "
                f"needed to see it from {angle_deg:g} degrees; {advice}",
                have_mm=have_mm,
                need_mm=need_mm,
                **({"over_mm": worst / slope} if level == card_top else {}),
            )
    return fault


def gap_mm(one: Rect, other: Rect, *, play_mm: float) -> float:
    """Least distance of two rectangles when one moves up to play_mm along each axis; below 0 they may overlap."""
    gaps = [max(other[k] - one[k + 2], one[k] - other[k + 2]) - play_mm for k in (0, 1)]
    return math.hypot(*gaps) if min(gaps) > 0 else max(gaps)


def _targets(badge: Badge, card_top: float, sheet_top: float) -> list[tuple[str, Rect, float, float]]:
    """What must stay in sight: name, rectangle in the frame, height, and the angle it is seen from, degrees."""
    targets = [
        (f"grating {g}", in_frame(badge.bounds_of(grating), badge), sheet_top, GRATING_SIGHT_DEG)
        for g, grating in enumerate(badge.gratings)
    ]
    names = FRAME_SIDES if isinstance(badge.markers, CodedFrame) else [f"marker {id_}" for id_ in badge.markers.ids]
    for name, rect in zip(names, badge.markers.dark_mm, strict=True):
        targets.append((name, in_frame(rect, badge), card_top, MARKER_SIGHT_DEG))
    half_x, half_y = half_board_mm(badge)
    for name, (x0, y0, x1, y1), _, _ in targets:
        if x0 < -half_x or y0 < -half_y or x1 > half_x or y1 > half_y:
            raise FabricationError(f"{name} reaches beyond the board that the mount holds; correct board.rect_mm")
    return targets
