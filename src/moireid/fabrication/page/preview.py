"""preview.png: the board under its lens sheet, as a camera sees it straight on; preview.webp: it moves.

preview.webp shows the board while a camera passes from side to side.

Convention: the camera is `view_mm` away, where the badge is used, and swings to each side by `SWING`, a share of that.
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
from PIL import Image, ImageDraw

from moireid.badge import Badge, Cell, Grating, Lens, Rect
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
    (picture,) = draw_fringes(badge)
    if look_of(badge) is not None:
        picture = picture.convert("RGB")
    paint_marks(picture, marks(badge), badge.outline_mm[:2], PX_PER_MM)
    return picture


def draw_fringes(
    badge: Badge, asides_mm: Sequence[tuple[float, float]] = ((0.0, 0.0),), px_per_mm: float = PX_PER_MM
) -> list[Image.Image]:
    """Fringes alone, grey, a picture for each place of the camera.

    Parameters: asides_mm: the camera's x and y from the point in front of the board's middle.
    """
    board = badge.outline_mm
    size = [round((board[2 + k] - board[k]) * px_per_mm) for k in (0, 1)]
    pictures = np.full((len(asides_mm), size[1], size[0]), PAPER, np.uint8)
    for grating in badge.gratings:
        _draw_grating(pictures, badge, grating, asides_mm, px_per_mm)
    return [Image.fromarray(picture) for picture in pictures]


def _draw_grating(
    pictures: NDArray[np.uint8],
    badge: Badge,
    grating: Grating,
    asides_mm: Sequence[tuple[float, float]],
    px_per_mm: float,
) -> None:
    """Draw one grating's fringes: each pixel whose middle lies in a cell takes that cell's brightness there."""
    frame, board = badge.frame_of(grating), badge.outline_mm
    middle = float(frame.places(((board[0] + board[2]) / 2, (board[1] + board[3]) / 2))[0])
    asides = [float(frame.directions(aside_mm)[0]) for aside_mm in asides_mm]
    away_mm = view_mm(badge)
    parts = (replace(grating.cells[0], rect_mm=grating.rect_mm),) if is_smooth(grating) else grating.cells
    for cell in parts:
        own = own_rect(grating.axis, cell.rect_mm)
        within, first, second = _pixels_within(badge, grating, own, px_per_mm)
        pixels = math.ceil((own[2] - own[0]) * px_per_mm)
        sample = ((first - own[0]) / (own[2] - own[0]) * pixels).astype(np.int32)
        if is_smooth(grating):
            axes = _landed(badge.lens, own[0], own[2], pixels, middle, asides[0], away_mm)[0][:, 0]
            lines = lines_over(badge.lens, grating, axes[sample], second)
        for picture, aside in zip(pictures, asides, strict=True):
            if is_smooth(grating):
                rays = _landed(badge.lens, own[0], own[2], pixels, middle, aside, away_mm)[1]
                rays = rays[:, SMOOTH_STEP // 2 :: SMOOTH_STEP].astype(np.float32)
                seen = _open_share(badge.lens) * smooth_light(lines, grating, [ray[sample] for ray in rays.T])
            else:
                seen = fringe_profile(badge.lens, cell, own, pixels, middle, aside, away_mm)[sample]
            picture[within] = INK + (PAPER - INK) * seen


def _pixels_within(
    badge: Badge, grating: Grating, own: Rect, px_per_mm: float
) -> tuple[tuple[NDArray[np.int64], NDArray[np.int64]], Array, Array]:
    """Rows and columns of the pixels whose middles lie in a rectangle in own order; and their own places, mm."""
    frame, board = badge.frame_of(grating), badge.outline_mm
    around = frame.bounds_mm(own)
    x0, y0, x1, y1 = (round((v - board[k % 2]) * px_per_mm) for k, v in enumerate(around))
    x, y = ((np.arange(*ends) + 0.5) / px_per_mm + board[k] for k, ends in enumerate(((x0, x1), (y0, y1))))
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
    """Share of a lens's rays that land between the lines of a smooth grating; the counterpart of `fringe_profile`.

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


def fringe_profile(
    lens: Lens, cell: Cell, own: Rect, pixels: int, middle: float, aside_mm: float, away_mm: float
) -> NDArray[np.float64]:
    """Brightness along the grating's axis, 0 to 1, of `pixels` samples; the mean over one lens's rays at each.

    Parameters
    ----------
    own : Rect
        The cell's rectangle in own order (`moireid.frames`), mm.
    middle : float
        The board's middle along the axis, mm.
    aside_mm : float
        How far the camera is to the side along the grating's axis, mm.
    away_mm : float
        How far the camera is from the board's plane, mm.

    Notes
    -----
    Convention: the camera is in front of the board's middle; the axis of one lens is on the middle.
    Source: `lenticule.trace_mm`, or `optics.slab_shift_mm` for a mask.
    """
    axes, landed = _landed(lens, own[0], own[2], pixels, middle, aside_mm, away_mm)
    position = (axes + landed - cell.edge_mm) / cell.pitch_mm % 1.0
    return _open_share(lens) * np.asarray((position >= cell.duty).mean(axis=1))


def _open_share(lens: Lens) -> float:
    """Share of the light that a front lets through: of a mask, its openings."""
    return lens.open_fraction if lens.kind == "mask" and lens.open_fraction else 1.0


@lru_cache(maxsize=64)
def _landed(
    lens: Lens, low: float, high: float, pixels: int, middle: float, aside_mm: float, away_mm: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The lens axis at each sample, (pixels, 1), and where its rays land from there; cells of one column share it."""
    places = low + (np.arange(pixels) + 0.5) / pixels * (high - low)
    axes = np.round((places - middle) / lens.pitch_mm) * lens.pitch_mm + middle
    tangent = ((axes - middle - aside_mm) / away_mm)[:, None]
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


FRAMES, FRAME_MS, SWING = 16, 100, 0.22
#: Longer side of the board in the moving picture, px.
LONGER_PX = 360


def write_moving_board(badge: Badge, path: Path, board: Image.Image | None = None) -> None:
    """Draw the moving preview and write it as animated WebP, whole or not at all; board: as for `draw_moving_board`."""
    write_moving(draw_moving_board(badge, board=board), path, frame_ms=FRAME_MS)


def write_moving(frames: Sequence[Image.Image], path: Path, *, frame_ms: int) -> None:
    """Write pictures that follow each other without end as animated WebP without loss, whole or not at all."""
    # Pillow would else import all of its formats.
    from PIL import WebPImagePlugin  # noqa: F401

    first, *others = frames
    # The quickest: without loss, of which `quality` is the effort, and no whole frames in between.
    how: dict[str, Any] = {"lossless": True, "method": 0, "quality": 0, "kmax": 0}
    with whole_file(path) as temporary:
        first.save(temporary, format="WEBP", save_all=True, append_images=others, loop=0, duration=frame_ms, **how)


def draw_moving_board(badge: Badge, frames: int = FRAMES, board: Image.Image | None = None) -> list[Image.Image]:
    """One swing of the camera to both sides and back, in colour; board: as `draw_preview` drew it, None to draw it."""
    whole = (board or draw_preview(badge)).convert("RGB")
    scale = min(1.0, LONGER_PX / max(whole.size))
    size = (round(whole.width * scale), round(whole.height * scale))
    px_per_mm = PX_PER_MM * scale
    fields = _fields(badge, size, px_per_mm)
    still = whole.resize(size, Image.Resampling.LANCZOS)
    swing = [round(SWING * view_mm(badge) * math.sin(2 * math.pi * k / frames), 6) for k in range(frames)]
    # On the way back the camera passes the same places.
    asides, shown = list(dict.fromkeys(swing)), {}
    for aside, picture in zip(asides, draw_fringes(badge, [(x, x) for x in asides], px_per_mm), strict=True):
        shown[aside] = Image.composite(picture.convert("RGB").resize(size), still, fields)
    return [shown[aside] for aside in swing]


def _fields(badge: Badge, size: tuple[int, int], px_per_mm: float) -> Image.Image:
    """Where the fringes are in a picture of the board: 255 within its gratings, turned ones too."""
    x0, y0, _, _ = badge.outline_mm
    fields = Image.new("L", size, 0)
    for grating in badge.gratings:
        corners = (badge.corners_of(grating) - (x0, y0)) * px_per_mm
        ImageDraw.Draw(fields).polygon([(x, y) for x, y in corners.tolist()], fill=255)
    return fields
