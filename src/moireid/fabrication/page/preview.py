"""preview.png: the board under its lens sheet, as a camera sees it straight on from 1 m."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageOps

from moireid.badge import Badge, Cell, Grating, Lens
from moireid.fabrication.page.artwork import font_file, marker_squares
from moireid.fabrication.page.lettering import name_picture, set_name
from moireid.files import whole_file
from moireid.lenticule import landing_mm
from moireid.optics import slab_shift_mm

PX_PER_MM = 6.0
DISTANCE_MM = 1000.0
RAYS = 48
INK, PAPER = 28, 250


def write_preview(badge: Badge, path: Path) -> None:
    """Draw the board and write it as PNG, whole or not at all."""
    with whole_file(path) as temporary:
        draw_preview(badge).save(temporary, format="PNG")


def draw_preview(badge: Badge) -> Image.Image:
    """The board as a grey picture, `PX_PER_MM` pixels to the millimetre."""
    board = badge.outline_mm
    size = [round((board[2 + k] - board[k]) * PX_PER_MM) for k in (0, 1)]
    picture = np.full((size[1], size[0]), PAPER, np.uint8)
    for grating in badge.gratings:
        for cell in grating.cells:
            x0, y0, x1, y1 = (round((v - board[k % 2]) * PX_PER_MM) for k, v in enumerate(cell.rect_mm))
            along = fringe_profile(badge.lens, grating, cell, x1 - x0 if grating.axis == "x" else y1 - y0, board)
            grey = (INK + (PAPER - INK) * along).astype(np.uint8)
            picture[y0:y1, x0:x1] = grey[None, :] if grating.axis == "x" else grey[:, None]
    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    for square, white in marker_squares(badge):
        for rect, grey_level in [(square, INK), *((module, PAPER) for module in white)]:
            pixels = [round((v - board[k % 2]) * PX_PER_MM) for k, v in enumerate(rect)]
            draw.rectangle((pixels[0], pixels[1], pixels[2] - 1, pixels[3] - 1), fill=grey_level)
    _write_names(image, badge)
    return image


def fringe_profile(
    lens: Lens, grating: Grating, cell: Cell, pixels: int, board: tuple[float, ...]
) -> NDArray[np.float64]:
    """Brightness along the grating's axis, 0 to 1, of `pixels` samples; the mean over one lens's rays at each.

    Convention: the camera stands `DISTANCE_MM` in front of the board's middle; a lens's axis lies on the middle.
    Source: `lenticule.landing_mm`, or `optics.slab_shift_mm` for a mask.
    """
    k = 0 if grating.axis == "x" else 1
    low, high = cell.rect_mm[k], cell.rect_mm[k + 2]
    middle = (board[k] + board[k + 2]) / 2
    places = low + (np.arange(pixels) + 0.5) / pixels * (high - low)
    axes = np.round((places - middle) / lens.pitch_mm) * lens.pitch_mm + middle
    tangent = ((axes - middle) / DISTANCE_MM)[:, None]
    across = ((np.arange(RAYS) + 0.5) / RAYS - 0.5) * lens.pitch_mm
    if lens.kind == "mask":
        assert lens.open_fraction is not None
        through = across * lens.open_fraction
        landed = through + slab_shift_mm(lens.thickness_mm, lens.refractive_index, tangent)
        light = lens.open_fraction
    else:
        landed, light = landing_mm(lens, across[None, :], tangent, np.zeros((1, 1))), 1.0
    position = (axes[:, None] + landed - cell.edge_mm) / cell.pitch_mm % 1.0
    return light * np.asarray((position >= cell.duty).mean(axis=1))


def _write_names(picture: Image.Image, badge: Badge) -> None:
    """The name and id at the places where `pdf.py` sets them."""
    board, centers, half = badge.outline_mm, badge.markers.centers_mm, badge.markers.size_mm / 2
    room_mm = (centers[1][0] - centers[0][0] - 2 * half - 6.0, 2 * half)
    label = f"moireid {badge.id}" if badge.id else "moireid"
    name = set_name(badge.name)
    for words, center, points, font in (
        (name.words, centers[0], 20.0, name.font or font_file(bold=True)),
        (label, centers[3], 8.0, font_file()),
    ):
        if not words:
            continue
        letters = name_picture(words, font, room_mm, points, PX_PER_MM * 25.4)
        corner = [
            round(place - size / 2)
            for place, size in zip(
                ((board[2] - board[0]) / 2 * PX_PER_MM, (center[1] - board[1]) * PX_PER_MM), letters.size, strict=True
            )
        ]
        picture.paste(INK, (corner[0], corner[1]), ImageOps.invert(letters))
