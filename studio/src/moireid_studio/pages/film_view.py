"""What the page *Verify* draws a chosen film with, in the visitor's browser: geometry of the claimed badge.

The browser registers the page with the same kernel as the verifier, and reads one row of it.  It is given what is
printed in plain sight and the same for all badges of a layout: the squares, where a row of one pitch is, and how far
fringes move.  Lines are those of the layout's specimen, and no line of the badge; the browser finds the spacing of the
fringes in the film.

Convention: places in units of the squares' extent about their middle, as `tracking.print_template`; single precision in
    the order of bytes of this machine's and every browser's memory, lowest first.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Query, Request
from fastapi.responses import JSONResponse, Response

from moireid.badge import Badge, Markers
from moireid.idcodes import specimen_of
from moireid.names import CLAIM_LIMIT
from moireid.optics import page_plane_slope_rad, paraxial_effective_gap_mm
from moireid.verifier.fringes.all_strips import search_band_per_mm
from moireid.verifier.tracking.brightness_profiles import MAX_STRIP_MM, ROW_STEP_MM, ProfileReader, Strip
from moireid.verifier.tracking.patches import module_of, patches_of
from moireid.verifier.tracking.print_template import printer_of
from moireid.verifier.tracking.registration import MARKER_CORRELATION, MIN_SHARE, RULES, SQUARES
from moireid_studio.auth.guard import POLICY, Visitor, require
from moireid_studio.jobs.claims import find_claimed
from moireid_studio.problems import Refusal
from moireid_studio.studio import Studio, studio_of

#: The page's policy: as all pages', and it may run the kernel.
VIEW_POLICY = {
    "Content-Security-Policy": POLICY.replace("script-src 'self'", "script-src 'self' 'wasm-unsafe-eval'"),
}
#: Scales of which a print is drawn, px per mm.
LEAST_SCALE, MOST_SCALE = 0.01, 100.0

router = APIRouter(prefix="/verify/view", include_in_schema=False)
Verifier = Annotated[Visitor, require("verifier")]
Claim = Annotated[str, Query(min_length=1, max_length=CLAIM_LIMIT)]


@router.get("")
def view(request: Request, visitor: Verifier, claim: Claim) -> Response:
    """Geometry of a claimed badge; null where the claim means no one badge, or its page is not found by squares."""
    badge = _claimed_layout(studio_of(request), visitor, claim)
    return JSONResponse(badge and view_geometry(badge))


@router.get("/print")
def print_samples(
    request: Request, visitor: Verifier, claim: Claim, px_per_mm: Annotated[float, Query(ge=LEAST_SCALE, le=MOST_SCALE)]
) -> Response:
    """The print at a scale, as `print_bytes`."""
    badge = _claimed_layout(studio_of(request), visitor, claim)
    if badge is None:
        raise Refusal(404, "no_view", "There is no such badge whose page a browser can find.")
    return Response(print_bytes(badge, px_per_mm), media_type="application/octet-stream")


def _claimed_layout(studio: Studio, visitor: Visitor, claim: str) -> Badge | None:
    """The specimen of a claimed badge's layout; None as `view`."""
    try:
        badge = find_claimed(studio.registry, claim, ids=visitor.may("issuer")).badge
    except Refusal:
        return None
    return specimen_of(badge) if isinstance(badge.markers, Markers) else None


def view_geometry(badge: Badge) -> dict[str, Any]:
    """Geometry of a badge with squares, ready for JSON.

    Parameters
    ----------
    badge : Badge
        Its squares, outline, one row, and lens are used.

    Returns
    -------
    dict
        middle_mm, extent_mm: of the places; outline: its corners as places; squares: centers_mm, size_mm and cells of
        each, row by row, 1 for white; rules, least_seen, most_squares, least_correlation: of the registration; row: as
        `_row`.

    Notes
    -----
    Convention: module docstring; squares in the order of their ids.
    Source: `tracking.registration`, `fringes.strip_law`.
    """
    squares, printer = badge.squares, printer_of(badge.markers)
    count = round(squares.size_mm / module_of(squares))
    offsets = (np.arange(count) + 0.5) / count * squares.size_mm - squares.size_mm / 2
    x0, y0, x1, y1 = badge.outline_mm
    outline = (np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]) - printer.middle) / printer.extent
    return {
        "middle_mm": printer.middle.tolist(),
        "extent_mm": printer.extent,
        "outline": outline.tolist(),
        "squares": {
            "size_mm": squares.size_mm,
            "centers_mm": squares.centers_mm,
            "cells": [patch.print(offsets, offsets).astype(int).ravel().tolist() for patch in patches_of(squares)],
        },
        "rules": [getattr(RULES, each[0]) for each in RULES._fields_],
        "least_seen": int(np.ceil(MIN_SHARE * len(printer.patches))),
        "most_squares": SQUARES,
        "least_correlation": MARKER_CORRELATION,
        "row": _row(badge),
    }


def _row(badge: Badge) -> dict[str, Any]:
    """A row of one pitch: begin_mm, along_mm, across_mm: its corner on the page, and the steps to the next sample and
    the next line of samples; samples, lines; axis: own coordinate along it = x axis[0] + y axis[1] + axis[2];
    middle_mm: of it; band_per_mm: of the fringes' frequency; slope_rad: of their phase, to the parallax there.

    Convention: the phase falls with the parallax (camera along the axis less the middle, over its distance).
    """
    strip = _widest(badge, ProfileReader(badge).strips)
    grating, first, last = badge.gratings[strip.grating], strip.along_mm[0], strip.along_mm[-1]
    lines = round(MAX_STRIP_MM / 2 / ROW_STEP_MM)
    top = strip.across_mm - (lines - 1) / 2 * ROW_STEP_MM
    step = (last - first) / (len(strip.along_mm) - 1)
    corners = strip.frame.on_page([(first, top), (first + step, top), (first, top + ROW_STEP_MM)])
    gap_mm = paraxial_effective_gap_mm(badge.lens)
    return {
        "begin_mm": corners[0].tolist(),
        "along_mm": (corners[1] - corners[0]).tolist(),
        "across_mm": (corners[2] - corners[0]).tolist(),
        "samples": len(strip.along_mm),
        "lines": lines,
        "step_mm": step,
        "axis": [*strip.frame.rows[0], strip.frame.origin_mm[0]],
        "middle_mm": strip.middle_mm,
        "band_per_mm": search_band_per_mm(badge, grating, strip.cells[0]),
        "slope_rad": page_plane_slope_rad(badge.lens, gap_mm, grating.pitch_mm),
    }


def _widest(badge: Badge, strips: list[Strip]) -> Strip:
    """The longest strip of one pitch, nearest to the badge's middle where several are as long."""
    _, y0, _, y1 = badge.outline_mm
    return max(
        (strip for strip in strips if strip.uniform),
        key=lambda strip: (round(strip.length_mm), -abs(strip.across_mm - (y0 + y1) / 2)),
    )


def print_bytes(badge: Badge, px_per_mm: float) -> bytes:
    """The print of a badge's squares at a scale, for the kernel.

    Parameters
    ----------
    badge : Badge
        With squares.
    px_per_mm : float
        Scale, px per mm, > 0.

    Returns
    -------
    bytes
        (5, N) of single precision: x and y of each sample place, its brightness about the mean of its square, and its
        gradient along x and y, per unit of the places.  All squares have as many samples, one after another.

    Notes
    -----
    Convention: module docstring.  Source: `tracking.print_template`.
    """
    template = printer_of(badge.markers).draw(px_per_mm)
    gradient = template.gradient() * np.float32(template.extent)
    rows = np.vstack([template.samples.points.T, np.concatenate(template.printed), gradient])
    return np.ascontiguousarray(rows, "<f4").tobytes()
