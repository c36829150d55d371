"""preview.png: the board under its lens sheet, as a camera sees it straight on; and pictures that move.

Convention: the camera is in front of the board's middle, `view_mm` away, where the badge is used; the axis of one lens
    is on the middle.
Source: `lenticule.trace_mm`, or `optics.slab_shift_mm` for a mask.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from moireid.badge import Badge, Grating, Lens, Rect
from moireid.fabrication.page.marks import INK, PAPER, look_of, marks, paint_marks
from moireid.files import whole_file
from moireid.frames import own_rect
from moireid.layers import is_smooth
from moireid.lenticule import trace_mm
from moireid.optics import slab_shift_mm
from moireid.smooth_lines import line_field

Array = NDArray[np.float64]
PX_PER_MM = 6.0
#: Nearest and farthest camera of a badge that does not state them, m.
USUAL_RANGE_M = (0.8, 2.5)
RAYS = 48
#: In a smooth field, where each pixel has lines of its own, each fourth of them.
SMOOTH_STEP = 4


def view_mm(badge: Badge) -> float:
    """Distance from which a badge is shown, mm: the middle of the distances at which it is read."""
    near_m, far_m = badge.range_m or USUAL_RANGE_M
    return 500 * (near_m + far_m)


def write_preview(badge: Badge, path: Path) -> Image.Image:
    """Draw the board and write it as PNG, whole or not at all.  Returns: what was drawn."""
    board = draw_preview(badge)
    with whole_file(path) as temporary:
        board.save(temporary, format="PNG")
    return board


def draw_preview(badge: Badge) -> Image.Image:
    """The board, `PX_PER_MM` pixels to the millimetre: grey with name and id, or in colour with its artwork."""
    x0, y0, x1, y1 = badge.outline_mm
    fringes = np.full((round((y1 - y0) * PX_PER_MM), round((x1 - x0) * PX_PER_MM)), PAPER, np.uint8)
    for grating in badge.gratings:
        _draw_grating(fringes, badge, grating)
    picture = Image.fromarray(fringes)
    if look_of(badge) is not None:
        picture = picture.convert("RGB")
    paint_marks(picture, marks(badge), badge.outline_mm[:2], PX_PER_MM)
    return picture


def _draw_grating(picture: NDArray[np.uint8], badge: Badge, grating: Grating) -> None:
    """Draw one grating's fringes: each pixel whose middle lies in a cell takes that cell's brightness there."""
    frame, board, lens = badge.frame_of(grating), badge.outline_mm, badge.lens
    middle = float(frame.places(((board[0] + board[2]) / 2, (board[1] + board[3]) / 2))[0])
    # A mask lets light through its openings alone.
    open_share = lens.open_fraction if lens.kind == "mask" and lens.open_fraction else 1.0
    parts = (replace(grating.cells[0], rect_mm=grating.rect_mm),) if is_smooth(grating) else grating.cells
    for cell in parts:
        own = own_rect(grating.axis, cell.rect_mm)
        within, first, second = _pixels_within(badge, grating, own)
        pixels = math.ceil((own[2] - own[0]) * PX_PER_MM)
        sample = ((first - own[0]) / (own[2] - own[0]) * pixels).astype(np.int32)
        axes, rays = _landed(lens, own[0], own[2], pixels, middle, view_mm(badge))
        if is_smooth(grating):
            lines = lines_over(lens, grating, axes[:, 0][sample], second)
            few = rays[:, SMOOTH_STEP // 2 :: SMOOTH_STEP].astype(np.float32)
            seen = smooth_light(lines, grating, [ray[sample] for ray in few.T])
        else:
            seen = ((axes + rays - cell.edge_mm) / cell.pitch_mm % 1.0 >= cell.duty).mean(axis=1)[sample]
        picture[within] = INK + (PAPER - INK) * open_share * seen


def _pixels_within(
    badge: Badge, grating: Grating, own: Rect
) -> tuple[tuple[NDArray[np.int64], NDArray[np.int64]], Array, Array]:
    """Rows and columns of the pixels whose middles lie in a rectangle in own order; and their own places, mm."""
    frame, board = badge.frame_of(grating), badge.outline_mm
    around = frame.bounds_mm(own)
    x0, y0, x1, y1 = (round((v - board[k % 2]) * PX_PER_MM) for k, v in enumerate(around))
    x, y = ((np.arange(*ends) + 0.5) / PX_PER_MM + board[k] for k, ends in enumerate(((x0, x1), (y0, y1))))
    first, second = (
        along * x + down * y[:, None] + origin
        for (along, down), origin in zip(frame.rows, frame.origin_mm, strict=True)
    )
    within = (first >= own[0]) & (first < own[2]) & (second >= own[1]) & (second < own[3])
    rows, columns = np.nonzero(within)
    return (rows + y0, columns + x0), first[within], second[within]


def lines_over(lens: Lens, grating: Grating, axes: Array, across: Array) -> tuple[Array, Array]:
    """The number of the line of a smooth grating at lenses' axes, and how many lines there are to the millimetre.

    Parameters: axes, across (...): own places of lenses' axes, along the grating's axis and across it, mm.
    Source: near a lens's axis numbers of lines rise evenly.
    """
    field = line_field(grating)
    number, beyond = (field.sampled(axes + step, across) for step in (0.0, lens.pitch_mm))
    return number, (beyond - number) / lens.pitch_mm


def smooth_light(lines: tuple[Array, Array], grating: Grating, rays: Sequence[Array]) -> Array:
    """Share of a lens's rays that land between the lines of a smooth grating.

    Parameters: lines: as `lines_over`; rays: where each ray lands (...), from the axis, mm.
    """
    (number, per_mm), duty = lines, np.float32(grating.cells[0].duty)
    lit, place = np.zeros(number.shape, np.uint8), np.empty_like(number)
    for ray in rays:
        np.add(number, np.multiply(per_mm, ray, out=place), out=place)
        # What % 1.0 gives, in a third of the time.
        place -= np.floor(place)
        lit += place >= duty
    return lit / len(rays)


@lru_cache(maxsize=64)
def _landed(
    lens: Lens, low: float, high: float, pixels: int, middle: float, away_mm: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The lens axis at each sample, (pixels, 1), and where its rays land from there; cells of one column share it."""
    places = low + (np.arange(pixels) + 0.5) / pixels * (high - low)
    axes = np.round((places - middle) / lens.pitch_mm) * lens.pitch_mm + middle
    tangent = ((axes - middle) / away_mm)[:, None]
    return axes[:, None], rays_landed_mm(lens, tangent, RAYS)


def rays_landed_mm(lens: Lens, tangent: NDArray[np.float64], rays: int) -> NDArray[np.float64]:
    """Where the rays of lenses that are seen under these tangents (n, 1) land, from each lens's axis: (n, rays), mm.

    Source: `lenticule.trace_mm`, or `optics.slab_shift_mm` for a mask.
    """
    across = ((np.arange(rays) + 0.5) / rays - 0.5)[None, :] * lens.pitch_mm
    if lens.kind == "mask":
        through = across * (lens.open_fraction or 0.0)
        return np.asarray(through + slab_shift_mm(lens.thickness_mm, lens.refractive_index, tangent))
    return np.asarray(trace_mm(lens, across, tangent, np.zeros((1, 1)))[0])


def write_moving(frames: Sequence[Image.Image], path: Path, *, frame_ms: int) -> None:
    """Write pictures that follow each other without end as animated WebP without loss, whole or not at all."""
    # Pillow would else import all of its formats.
    from PIL import WebPImagePlugin  # noqa: F401

    first, *others = frames
    # The quickest: without loss, of which `quality` is the effort, and no whole frames in between.
    how: dict[str, Any] = {"lossless": True, "method": 0, "quality": 0, "kmax": 0}
    with whole_file(path) as temporary:
        first.save(temporary, format="WEBP", save_all=True, append_images=others, loop=0, duration=frame_ms, **how)
