"""What somebody sees who lays the sheet well, turned, or of another pitch: small pictures by the project's own optics.

Each pixel takes the brightness of the lens that it lies under: the mean over that lens's rays of the printed lines on
which they land.  Codes and plain rows are drawn as they are printed, so a picture looks as the badge does.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from moireid.badge import Badge, Grating
from moireid.fabrication.page.preview import DISTANCE_MM, INK, PAPER
from moireid.frames import own_rect
from moireid.lenticule import landing_mm
from moireid.optics import slab_shift_mm

PX_PER_MM, RAYS = 1.2, 8
Array = NDArray[np.float64]
#: A sheet that was laid on by eye: turned so far, its fringes lean clearly.
LEANING_DEG = 0.5
#: Fringes of a sheet whose pitch is not the label's: so many times as many, and so many times as few.
NARROWER, WIDER = 1.7, 0.5


def fringe_picture(badge: Badge, *, turned_deg: float = 0.0, beats: float = 1.0) -> Image.Image:
    """The first grating under its sheet, grey, its axis across: as it looks from `DISTANCE_MM` before its middle.

    Parameters: turned_deg: how far the sheet is turned on the page; beats: how many times as many fringes as designed
        the sheet shows, because its pitch is not the label's.
    Source: `lenticule.landing_mm`, or `optics.slab_shift_mm` for a mask.
    """
    first = badge.gratings[0]
    x0, y0, x1, y1 = own_rect(first.axis, first.rect_mm)
    # A picture of a whole A5 sheet is as large as one of a card.
    scale = PX_PER_MM * min(1.0, 140.0 / (x1 - x0))
    size = (max(2, round((y1 - y0) * scale)), max(2, round((x1 - x0) * scale)))
    rows, columns = np.meshgrid(*(np.arange(n) + 0.5 for n in size), indexing="ij")
    own = np.stack([x0 + columns / scale, y0 + rows / scale], axis=-1)
    page, angle = badge.frame_of(first).on_page(own), math.radians(turned_deg)
    light = np.ones(size)
    # Under a lens array light must pass both gratings, which share a field.
    for grating in badge.gratings if badge.lens.kind == "array" else (first,):
        frame = badge.frame_of(grating)
        turn = angle * frame.handed * badge.frame_of(first).handed
        light *= _light(badge, grating, frame.places(page), turn, _pitch_mm(badge, grating, beats))
    return Image.fromarray((INK + (PAPER - INK) * light).astype(np.uint8))


def _light(badge: Badge, grating: Grating, own: Array, turn_rad: float, pitch_mm: float) -> Array:
    """Brightness, 0 to 1, of pixels at own places (..., 2) of a grating, its sheet turned about the field's middle."""
    x0, y0, x1, y1 = own_rect(grating.axis, grating.rect_mm)
    across, along = own[..., 0], own[..., 1]
    # Across the lenses, from the middle; and the axis of the lens above each pixel.
    over = (across - (x0 + x1) / 2) * math.cos(turn_rad) + (along - (y0 + y1) / 2) * math.sin(turn_rad)
    lens_axis = np.round(over / pitch_mm) * pitch_mm
    place, rays = across + (lens_axis - over) * math.cos(turn_rad), _landed_mm(badge, lens_axis)
    light = np.ones(across.shape)
    for cell in grating.cells:
        cx0, cy0, cx1, cy1 = own_rect(grating.axis, cell.rect_mm)
        within = (across >= cx0) & (across < cx1) & (along >= cy0) & (along < cy1)
        phase = (place[within][:, None] + rays[within] - cell.edge_mm) / cell.pitch_mm % 1.0
        light[within] = (phase >= cell.duty).mean(axis=1)
    return light


def _pitch_mm(badge: Badge, grating: Grating, beats: float) -> float:
    """The lens pitch that shows so many times as many fringes."""
    lines, lenses = 1 / grating.pitch_mm, 1 / badge.lens.pitch_mm
    # Lines may be nearly as many as the lenses, or nearly twice as many.
    order = max(1, round(lines / lenses))
    return order / (lines - beats * (lines - order * lenses))


def _landed_mm(badge: Badge, lens_axis: Array) -> Array:
    """Where the rays of each pixel's lens land, from that lens's axis, mm: (rows, columns, rays)."""
    lens = badge.lens
    axes, index = np.unique(lens_axis, return_inverse=True)
    tangent = (axes / DISTANCE_MM)[:, None]
    start = ((np.arange(RAYS) + 0.5) / RAYS - 0.5)[None, :] * lens.pitch_mm
    if lens.kind == "mask":
        share = lens.open_fraction or 0.0
        landed = start * share + slab_shift_mm(lens.thickness_mm, lens.refractive_index, tangent)
    else:
        landed = landing_mm(lens, start, tangent, np.zeros((1, 1)))
    return np.asarray(landed[index.reshape(lens_axis.shape)], dtype=float)
