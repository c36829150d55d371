"""The figures from which the page's script draws moving fringes: traced here, interpolated there.

Convention: page mm; a camera at (Cx, Cy, Cz), Cz < 0, sees the page's point X along the tangents (X - C) / |Cz|, which
cross the lenses at x = X - g tan.  There the shown place on the page, in turns of the printed lines from a dark
line's leading edge, is

    turns = (m - edge) / p_r + (x - m) (1/p_r - 1/p_f) + s(tan) / p_r

for a lens whose axis lies at m, the middle of the board.  Where lines bend, low rows of one pitch are drawn, and
`ahead` adds by how much the number of the line at x exceeds that of the row's own.  Source:
`moireid.verifier.fringes.strip_law`, with the lenses' place, which is a constant there, fixed in this way; s is traced
by `moireid.lenticule` for the grating's pitch.
"""

from __future__ import annotations

import base64
import io
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.artwork.placing import Look
from moireid.badge import Badge, Cell, Grating, Lens
from moireid.fabrication.page.marks import lettering_places, look_of, marker_squares
from moireid.fabrication.page.preview import USUAL_RANGE_M, draw_preview, view_mm
from moireid.frames import own_rect
from moireid.layers import is_smooth
from moireid.lenticule import landing_mm, view_law
from moireid.optics import slab_shift_mm
from moireid.smooth_lines import LineField

#: The camera of the preview goes this far to each side of straight ahead, as a tangent (22 degrees).
REACH = 0.4
#: From so many of the board's longer sides away, the whole badge is still seen.
NEAREST_SIDES = 3.0
#: Steps of the table: straight lines between them are within 0.001 rad of the law (a test checks it).
STEP_X, STEP_Y = 0.02, 0.05
#: Rows of a field whose lines bend, and places along them, mm: straight lines between them are within 0.05 turns.
BENT_MM = 1.0
#: Longer side of the picture of what is worn, px, and its quality: it comes within the page.
WORN_PX, WORN_QUALITY = 900, 80
#: Number of places in a printed period with a brightness, and of rays through one lens.
PLACES, RAYS = 96, 96


def preview_law(badge: Badge, look: Look | None = None) -> dict[str, Any]:
    """What `static/fringes.js` draws `badge` from, ready for JSON; lengths in mm.

    Convention and source: module docstring.  Per grating: `shift_mm` and `contrast`, rows by tangent along the axis
    from -`reach` on, columns by tangent across from 0 on (both are even in that); `profile`: brightness at `PLACES`
    turns of a printed period, seen straight on; cells as in badge.json, and of a grating whose lines bend the rows of
    `_bent_rows`.  `worn`: the board with all that it wears, as
    the address of a picture, None where that is name and id alone; it covers markers and words.
    """
    x0, y0, x1, y1 = badge.outline_mm
    return {
        "board_mm": _rounded([x0, y0, x1, y1]),
        "lens": {"pitch_mm": badge.lens.pitch_mm, "thickness_mm": badge.lens.thickness_mm},
        "camera": _camera(badge),
        "gratings": [_grating(badge, grating) for grating in badge.gratings],
        "markers": [
            {"black": _rounded(black), "white": [_rounded(rect) for rect in white]}
            for black, white in marker_squares(badge)
        ],
        "words": _words(badge),
        "worn": _worn(badge, look),
    }


def _camera(badge: Badge) -> dict[str, float]:
    """How far the camera goes, and where it begins: over the range in which the badge is read, from its middle, mm."""
    near_m, far_m = badge.range_m or USUAL_RANGE_M
    x0, y0, x1, y1 = badge.outline_mm
    least_mm = NEAREST_SIDES * max(x1 - x0, y1 - y0)
    near_mm = max(1000 * near_m, least_mm)
    at_mm = max(view_mm(badge), near_mm)
    return {"reach": REACH, "near_mm": near_mm, "far_mm": max(1000 * far_m, at_mm), "at_mm": at_mm}


def _worn(badge: Badge, look: Look | None) -> str | None:
    if look_of(badge, look) is None:
        return None
    picture, made = draw_preview(badge, look), io.BytesIO()
    picture.thumbnail((WORN_PX, WORN_PX))
    picture.save(made, format="WEBP", quality=WORN_QUALITY)
    return "data:image/webp;base64," + base64.b64encode(made.getvalue()).decode()


def _grating(badge: Badge, grating: Grating) -> dict[str, Any]:
    """One grating: its axis and frame, its law, and its cells, whose rectangles are in own order (`moireid.frames`)."""
    frame, (x0, y0, x1, y1) = badge.frame_of(grating), badge.outline_mm
    # The camera's own reach, and half the board seen from the nearest place; at an angle, both reaches add up.
    reach = (REACH + 1 / 6 + 0.02) * max(abs(a) + abs(b) for a, b in frame.rows)
    along = np.arange(-math.ceil(reach / STEP_X), math.ceil(reach / STEP_X) + 1) * STEP_X
    across = np.arange(0, math.ceil(reach / STEP_Y) + 1) * STEP_Y
    law = view_law(badge.lens, grating.pitch_mm)
    shift = law.phase_rad(along[:, None], across[None, :]) * grating.pitch_mm / (2 * math.pi)
    kept = law.contrast_kept(along[:, None], across[None, :])
    return {
        "axis": grating.axis,
        "own": [[*row, origin] for row, origin in zip(frame.rows, frame.origin_mm, strict=True)],
        "middle_mm": float(frame.places(((x0 + x1) / 2, (y0 + y1) / 2))[0]),
        "first": float(along[0]),
        "step_along": STEP_X,
        "step_across": STEP_Y,
        "shift_mm": np.round(shift, 6).tolist(),
        "contrast": np.round(kept / max(float(kept[len(along) // 2, 0]), 1e-9), 4).tolist(),
        "profile": np.round(_profile(badge.lens, grating.cells[0]), 4).tolist(),
        "bent": is_smooth(grating),
        "cells": _bent_rows(grating)
        if is_smooth(grating)
        else [
            {
                "rect_mm": _rounded(own_rect(grating.axis, cell.rect_mm)),
                "pitch_mm": cell.pitch_mm,
                "edge_mm": cell.edge_mm,
            }
            for cell in grating.cells
        ],
    }


def _bent_rows(grating: Grating) -> list[dict[str, Any]]:
    """A smooth grating as rows of about `BENT_MM`, each over its whole length, in the order of their places.

    `ahead`: turns by which the lines are ahead of a row of the grating's usual pitch, at even places from end to end.
    """
    field = LineField(grating)
    count = math.ceil((field.end - field.begin) / BENT_MM)
    borders = np.linspace(field.begin, field.end, count + 1)
    along = np.linspace(field.low, field.high, math.ceil((field.high - field.low) / BENT_MM) + 1)
    ahead = field.numbers(along, (borders[:-1, None] + borders[1:, None]) / 2) - (along - field.low) / grating.pitch_mm
    return [
        {
            "rect_mm": _rounded([field.low, top, field.high, bottom]),
            "pitch_mm": grating.pitch_mm,
            "edge_mm": field.low,
            "ahead": np.round(row, 3).tolist(),
        }
        for top, bottom, row in zip(borders[:-1], borders[1:], ahead, strict=True)
    ]


def _profile(lens: Lens, cell: Cell) -> NDArray[np.float64]:
    """Brightness of one lens, 0 to 1, against the place that its middle shows, seen straight on, (`PLACES`,).

    Source: the mean over rays through one lens, as in `fabrication.page.preview`.
    """
    across = ((np.arange(RAYS) + 0.5) / RAYS - 0.5) * lens.pitch_mm
    if lens.kind == "mask":
        light = lens.open_fraction or 0.5
        landed = across * light + slab_shift_mm(lens.thickness_mm, lens.refractive_index, 0.0)
    else:
        landed, light = landing_mm(lens, across, np.zeros(1), np.zeros(1)), 1.0
    turns = (np.arange(PLACES)[:, None] / PLACES + landed[None, :] / cell.pitch_mm) % 1.0
    return light * np.asarray((turns >= cell.duty).mean(axis=1))


def _words(badge: Badge) -> list[dict[str, Any]]:
    """Name and id, with the boxes that they are set in: between the markers, above and below the gratings."""
    centers, half = lettering_places(badge)
    label = f"moireid {badge.id}" if badge.id else "moireid"
    left, right = centers[0][0] + half + 3.0, centers[1][0] - half - 3.0
    return [
        {"text": words, "box_mm": _rounded([left, y - half, right, y + half]), "height_mm": height}
        for words, y, height in ((badge.name or label, centers[0][1], 7.0), (label, centers[3][1], 2.8))
    ]


def _rounded(values: Any) -> list[float]:
    return [round(float(value), 4) for value in values]
