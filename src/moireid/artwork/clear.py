"""The parts of a board that must stay clear, and the areas that are free.

The verifier reads the markers with the white around them, the fringes, and the white next to their borders.  At the
fringes a lens sheet covers the whole width of the board, and it is cut by hand.

Convention: page mm.  The figures are those of the verifier, which this package does not import; a test keeps them
    equal.
"""

from __future__ import annotations

from moireid.badge import Badge, CodedFrame, Rect
from moireid.errors import SpecError

#: White around a marker, in its modules (`verifier.tracking.template.FREE_MODULES`); a 4x4 marker has six a side.
MARKER_MODULES, MODULES_A_SIDE = 1.05, 6
#: White around a coded frame, in its lines and at least, mm.  Where a line is 2 px wide, its outline runs into a dark
#: ground that is 1.05 lines away, and mostly not into one 1.5 lines away (a test of coded frames holds 2).
FRAME_LINES, FRAME_LEAST_MM = 2.0, 1.5
#: White around a grating, mm (`verifier.tracking.borders.REACH_MM`).
GRATING_MM = 2.0
#: Between pieces and the white around markers; how far a ground reaches beyond the board's edge, where it is cut.
AIR_MM, BLEED_MM = 0.5, 1.5
#: An area of less height is not used, mm.
LEAST_MM = 2.0


def clear_zones(badge: Badge) -> list[tuple[str, Rect]]:
    """The rectangles that nothing may cover, each with its name for messages."""
    if isinstance(badge.markers, CodedFrame):
        return [("coded frame, its white border and what is within", _framed(badge.markers))]
    half = badge.markers.size_mm * (0.5 + MARKER_MODULES / MODULES_A_SIDE)
    names = ("upper left marker", "upper right marker", "lower right marker", "lower left marker")
    zones: list[tuple[str, Rect]] = [
        (f"{name} and its white border", (x - half, y - half, x + half, y + half))
        for name, (x, y) in zip(names, badge.markers.centers_mm, strict=True)
    ]
    left, _, right, _ = badge.outline_mm
    for grating in badge.gratings:
        x0, top, x1, bottom = badge.bounds_of(grating)
        # A sheet over upright fringes reaches from side to side of the board, where a mount holds it.
        x0, x1 = (left, right) if isinstance(grating.axis, str) else (x0 - GRATING_MM, x1 + GRATING_MM)
        zones.append(("fringes and the lens sheet over them", (x0, top - GRATING_MM, x1, bottom + GRATING_MM)))
    return zones


def areas_of(badge: Badge) -> dict[str, Rect]:
    """The free areas of a board; one without height is left out.

    head, foot: between the upper, and between the lower markers, as high as these; upper, lower: as wide as the
    fringes, between them and the markers, or head and foot where no room is left there; crown, base: between the
    markers too, but down, or up, to the fringes.  Above and below a coded frame there is one area each, as wide as it.
    """
    if isinstance(badge.markers, CodedFrame):
        return _areas_about(badge.outline_mm, badge.markers)
    half = badge.markers.size_mm / 2
    quiet = badge.markers.size_mm * MARKER_MODULES / MODULES_A_SIDE
    (left, top), (right, _), (_, bottom), _ = badge.markers.centers_mm
    x0, x1 = left + half + quiet + AIR_MM, right - half - quiet - AIR_MM
    first = min(badge.bounds_of(grating)[1] for grating in badge.gratings) - GRATING_MM
    last = max(badge.bounds_of(grating)[3] for grating in badge.gratings) + GRATING_MM
    areas: dict[str, Rect] = {
        "head": (x0, top - half, x1, min(top + half, first)),
        "upper": (left - half, top + half + quiet, right + half, first),
        "crown": (x0, top - half, x1, first),
        "foot": (x0, max(bottom - half, last), x1, bottom + half),
        "lower": (left - half, last, right + half, bottom - half - quiet),
        "base": (x0, last, x1, bottom + half),
    }
    for name, other in (("upper", "head"), ("lower", "foot")):
        if areas[name][3] - areas[name][1] < LEAST_MM:
            areas[name] = areas[other]
    return {name: rect for name, rect in areas.items() if rect[3] - rect[1] > 0 and rect[2] - rect[0] > 0}


def _framed(frame: CodedFrame) -> Rect:
    """A coded frame with its white border."""
    white = max(FRAME_LINES * frame.line_mm, FRAME_LEAST_MM)
    x0, y0, x1, y1 = frame.rect_mm
    return x0 - white, y0 - white, x1 + white, y1 + white


def _areas_about(board: Rect, frame: CodedFrame) -> dict[str, Rect]:
    """The areas of a board with a coded frame, down to the board's white margin."""
    (left, _, right, _), (_, top, _, bottom) = frame.rect_mm, _framed(frame)
    margin = left - board[0]
    head, foot = (left, board[1] + margin, right, top), (left, bottom, right, board[3] - margin)
    areas = dict.fromkeys(("head", "upper", "crown"), head) | dict.fromkeys(("foot", "lower", "base"), foot)
    return {name: rect for name, rect in areas.items() if rect[3] - rect[1] > LEAST_MM}


def check_clear(badge: Badge, rect: Rect, whose: str) -> None:
    """Check that a place does not cover what is read.  Raises: SpecError that names what is covered."""
    covered = next((name for name, zone in clear_zones(badge) if overlap(rect, zone)), None)
    if covered is not None:
        raise SpecError(f"{whose} covers the {covered}; take another area for it, or leave bleed out")


def overlap(one: Rect, other: Rect) -> bool:
    """Whether two rectangles share more than an edge."""
    return all(one[k] < other[k + 2] - 1e-6 and other[k] < one[k + 2] - 1e-6 for k in (0, 1))
