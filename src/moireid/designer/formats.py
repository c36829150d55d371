"""Formats of badges that common holders fit: the board's size, the sheet that suits it, and its reading distances.

Each has a sheet that is sold (`materials.toml`).  Small boards have finer sheets: a cell is then still covered by
enough lenses, and a thin sheet fits the holder.  Its fringes move less, so a film needs a little more motion.

The frame of a format gives the width of its white margin and the size of its markers.  The heights of head and foot are
set by a template (`moireid.artwork`), within what markers and fringes need.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from moireid.designer.design import design_badge
from moireid.designer.request import FringeBorder, Request
from moireid.errors import DesignError, SpecError
from moireid.sheets import DEFAULT_LENS

Orientation = Literal["landscape", "portrait"]
ORIENTATIONS: tuple[Orientation, ...] = ("landscape", "portrait")
#: A range may be too wide for several reasons, and each attempt reports only one of them.
MOST_CUTS = 4
#: The shortest identity of a code family, bytes.
_TRIAL_BYTES = {"spacing": 8, "pitch": 3}


@dataclass(frozen=True)
class BadgeFormat:
    """One format.

    size_mm: width and height as it is named; lens: label of the sheet; range_m: from where to where it is to be read;
    corner_mm: radius of the corners as cut, 0 for a board of its own; words: for people, with the holder that fits.
    """

    size_mm: tuple[float, float]
    lens: str
    range_m: tuple[float, float]
    frame: FringeBorder
    corner_mm: float
    words: str


#: Sizes: cards by ISO/IEC 7810, paper by ISO 216, and the pouch of 4 x 3 inches that conferences buy.  Markers have
#: 19 px or more at the far end in 1080p.  Ranges are those of a verdict by eight seconds of swaying
#: (`reach.verdict_reach_m`); only the board, as the one that was first, states how far it is read.
FORMATS = {
    "cr80": BadgeFormat((85.6, 54.0), "75lpi-18mil", (0.3, 0.6), FringeBorder(3.0, 8.5), 3.18, "a card holder"),
    "a7": BadgeFormat((105.0, 74.0), "75lpi-18mil", (0.3, 0.75), FringeBorder(4.0, 11.0), 3.0, "an A7 pouch"),
    "4x3in": BadgeFormat(
        (101.6, 76.2), "75lpi-18mil", (0.3, 0.75), FringeBorder(4.0, 11.0), 3.0, "a pouch of 4 x 3 inches"
    ),
    "a6": BadgeFormat((148.0, 105.0), DEFAULT_LENS, (0.4, 1.05), FringeBorder(5.0, 15.0), 4.0, "an A6 pouch"),
    "a5": BadgeFormat(
        (210.0, 148.0), DEFAULT_LENS, (0.6, 1.5), FringeBorder(6.0, 20.0), 4.0, "an A5 pouch, or a sign on a desk"
    ),
    # For a laptop's camera of 720p, which has two thirds of the pixels that designs count on: all must suffice for
    # half as far again, and such cameras are soft and slow: markers of 14 px are lost there, of 22 px followed.
    "webcam": BadgeFormat(
        (150.0, 120.0), DEFAULT_LENS, (0.4, 0.9), FringeBorder(4.0, 22.0), 4.0, "a hand or a stand, for calls"
    ),
    "board": BadgeFormat(
        (146.0, 160.0), DEFAULT_LENS, (0.8, 2.5), FringeBorder(), 0.0, "a board of its own, for cameras farther away"
    ),
}


def format_named(name: str) -> BadgeFormat:
    """The format of that name.  Raises: SpecError, with the known names, if there is none."""
    if name.lower() not in FORMATS:
        raise SpecError(f"format {name!r} is not known; choose one of {', '.join(FORMATS)}")
    return FORMATS[name.lower()]


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


def in_format(
    request: Request,
    name: str,
    *,
    orientation: str | None = None,
    lens: str | None = None,
    range_m: tuple[float, float] | None = None,
    payload_bytes: int | None = None,
) -> Request:
    """The request in a format.

    Parameters: lens, range_m: what the user gave; None for the format's own, the range as far as this board can be read
        with this sheet and paper; payload_bytes: as for `within_reach`.
    Raises: SpecError for an unknown format or orientation; DesignError where no range works.
    """
    form = format_named(name)
    request = replace(request, size_mm=turned(form.size_mm, orientation), lens=lens or form.lens)
    request = replace(request, frame=replace(form.frame, head=request.frame.head, foot=request.frame.foot))
    if range_m is not None:
        return replace(request, range_m=range_m)
    return within_reach(replace(request, range_m=form.range_m), payload_bytes)


def within_reach(request: Request, payload_bytes: int | None = None) -> Request:
    """The request with its range cut to what the design allows.

    Parameters: payload_bytes: for an identity of that length; None for the shortest one.
    Raises: DesignError where no part of the range works.
    """
    payload = bytes(payload_bytes or _TRIAL_BYTES.get(request.family or "spacing", 8))
    for _ in range(MOST_CUTS):
        try:
            design_badge(request, payload)
        except DesignError as error:
            near_m, far_m = error.details.get("near_m", request.range_m[0]), error.details.get("far_m")
            if not isinstance(near_m, float) or not isinstance(far_m, float):
                raise
            near_m, far_m = max(request.range_m[0], near_m), min(request.range_m[1], math.floor(100 * far_m) / 100)
            if near_m >= far_m or (near_m, far_m) == request.range_m:
                raise
            request = replace(request, range_m=(near_m, far_m))
        else:
            break
    return request
