"""Formats of badges that common holders fit: the board's size, the sheet that suits it, and its reading distances.

Each has a sheet that is sold (`materials.toml`).  Small boards have finer sheets: a cell is then still covered by
enough lenses, and a thin sheet fits the holder.  Its fringes move less, so a film needs a little more motion.

A format gives the width of the white margin and the size of the markers.  The heights of head and foot are set by a
template (`moireid.artwork`), within what markers and fringes need.
"""

from __future__ import annotations

from dataclasses import dataclass

from moireid.designer.order import MARGIN_MM, Order, Pair
from moireid.errors import SpecError
from moireid.sheets import DEFAULT_LENS

ORIENTATIONS = ("landscape", "portrait")


@dataclass(frozen=True)
class BadgeFormat:
    """One format.

    size_mm: width and height as it is named; lens: label of the sheet; range_m: from where to where it is to be read;
    margin_mm: white at the edges; marker_mm: side of a marker's black square, None for the prototype's share of the
    board's smaller side; words: for people, with the holder that fits.
    """

    size_mm: Pair
    lens: str
    range_m: Pair
    margin_mm: float
    marker_mm: float | None
    words: str


#: Sizes: cards by ISO/IEC 7810, paper by ISO 216, and the pouch of 4 x 3 inches that conferences buy.  Markers have
#: 19 px or more at the far end in 1080p.  Ranges are those of a verdict by eight seconds of swaying
#: (`reach.verdict_reach_m`); only the board, as the one that was first, states how far it is read.
FORMATS = {
    "cr80": BadgeFormat((85.6, 54.0), "75lpi-18mil", (0.3, 0.6), 3.0, 8.5, "a card holder"),
    "a7": BadgeFormat((105.0, 74.0), "75lpi-18mil", (0.3, 0.75), 4.0, 11.0, "an A7 pouch"),
    "4x3in": BadgeFormat((101.6, 76.2), "75lpi-18mil", (0.3, 0.75), 4.0, 11.0, "a pouch of 4 x 3 inches"),
    "a6": BadgeFormat((148.0, 105.0), DEFAULT_LENS, (0.4, 1.05), 5.0, 15.0, "an A6 pouch"),
    "a5": BadgeFormat((210.0, 148.0), DEFAULT_LENS, (0.6, 1.5), 6.0, 20.0, "an A5 pouch, or a sign on a desk"),
    # For a laptop's camera of 720p, which has two thirds of the pixels that designs count on: all must suffice for
    # half as far again, and such cameras are soft and slow: markers of 14 px are lost there, of 22 px followed.
    "webcam": BadgeFormat((150.0, 120.0), DEFAULT_LENS, (0.4, 0.9), 4.0, 22.0, "a hand or a stand, for calls"),
    "board": BadgeFormat(
        (146.0, 160.0), DEFAULT_LENS, (0.8, 2.5), MARGIN_MM, None, "a board of its own, for cameras farther away"
    ),
}


#: Focal length, mm, of a camera of 36 mm of film whose angle of view is that of the camera of a design; and lenses of
#: the table of distances: that one, and what press cameras have.
PHONE_MM = 27.0
LENSES_MM = (PHONE_MM, 50.0, 85.0, 135.0)


def by_lens(range_m: Pair) -> list[str]:
    """Distances at which a film of 1080p is judged, with each lens of `LENSES_MM`, by the range with a phone's, m.

    Convention: a lens that is longer brings the badge nearer by as much, in pixels.
    """
    spans = ([round(side * lens / PHONE_MM, 2) for side in range_m] for lens in LENSES_MM)
    return ["{:g} to {:g} m".format(*span) for span in spans]


def distances() -> list[tuple[str, ...]]:
    """A table of formats: name, size, lens sheet, and the distances of `by_lens`."""
    return [
        (name, "{:g} × {:g} mm".format(*form.size_mm), form.lens, *by_lens(form.range_m))
        for name, form in FORMATS.items()
    ]


def format_named(name: str | None) -> BadgeFormat:
    """The format of that name, the board's without one.  Raises: SpecError, with the known names, if there is none."""
    form = FORMATS.get((name or "board").lower())
    if form is None:
        raise SpecError(f"format {name!r} is not known; choose one of {', '.join(FORMATS)}")
    return form


def format_of(outline_mm: tuple[float, float, float, float]) -> str | None:
    """The format that has a badge's size, upright or turned, within 0.01 mm; None for a size of its own."""
    x0, y0, x1, y1 = outline_mm
    sides = sorted((x1 - x0, y1 - y0))
    for name, form in FORMATS.items():
        if all(abs(own - side) < 0.01 for own, side in zip(sorted(form.size_mm), sides, strict=True)):
            return name
    return None


def turned(size_mm: tuple[float, float], orientation: str | None) -> tuple[float, float]:
    """The size in landscape or portrait orientation; unchanged where the orientation is None."""
    if orientation is None:
        return size_mm
    if orientation not in ORIENTATIONS:
        raise SpecError(f"orientation {orientation!r} is not known; choose landscape or portrait")
    short, long = sorted(size_mm)
    return (long, short) if orientation == "landscape" else (short, long)


def size_of(order: Order) -> Pair:
    """Width and height of the board, mm, as it is given or as its format is."""
    return order.size_mm or turned(format_named(order.format).size_mm, order.orientation)
