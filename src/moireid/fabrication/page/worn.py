"""preview.webp: the finished badge as worn, cut out and in its cord, while a camera passes from side to side.

Convention: the camera is `preview.DISTANCE_MM` away and swings to each side by `SWING`, a share of that.
"""

from __future__ import annotations

import math
from pathlib import Path

from PIL import Image, ImageChops, ImageDraw, ImageFilter

from moireid.artwork.placing import Look
from moireid.badge import Badge
from moireid.fabrication.page.preview import DISTANCE_MM, PX_PER_MM, draw_fringes, draw_preview
from moireid.files import whole_file

FRAMES, FRAME_MS, SWING = 16, 100, 0.22
#: Longer side of the board in the moving picture, px.
LONGER_PX = 360
CLOTH, CORD, SHADOW = (203, 208, 214), (58, 66, 76), (150, 156, 164)
#: Around the board, above it for the cord, mm; a board without a radius of its own is cut square.
ROOM_MM, ABOVE_MM, CORD_MM, CLIP_MM = 9.0, 22.0, 9.0, (13.0, 4.0)


def write_worn(badge: Badge, path: Path, look: Look | None = None) -> None:
    """Draw the moving preview and write it as animated WebP, whole or not at all."""
    frames = draw_worn(badge, look)
    with whole_file(path) as temporary:
        first, *others = frames
        first.save(
            temporary,
            format="WEBP",
            save_all=True,
            append_images=others,
            duration=FRAME_MS,
            loop=0,
            quality=70,
            method=0,
        )


def draw_worn(badge: Badge, look: Look | None = None, frames: int = FRAMES) -> list[Image.Image]:
    """One swing of the camera to both sides and back, in colour."""
    whole = draw_preview(badge, look).convert("RGB")
    scale = min(1.0, LONGER_PX / max(whole.size))
    size = (round(whole.width * scale), round(whole.height * scale))
    px_per_mm = PX_PER_MM * scale
    fields = _fields(badge, size, px_per_mm)
    board = whole.resize(size, Image.Resampling.LANCZOS)
    cut = _cut_out(size, (look.corner_mm if look else 0.0) * px_per_mm)
    ground, corner = _ground(size, px_per_mm, cut)
    shown: dict[float, Image.Image] = {}
    swing = [round(SWING * DISTANCE_MM * math.sin(2 * math.pi * k / frames), 6) for k in range(frames)]
    # On the way back the camera passes the same places.
    for aside in dict.fromkeys(swing):
        fringes = draw_fringes(badge, (aside, aside), px_per_mm).convert("RGB").resize(size)
        frame = ground.copy()
        frame.paste(Image.composite(fringes, board, fields), corner, cut)
        shown[aside] = frame
    return [shown[aside] for aside in swing]


def _fields(badge: Badge, size: tuple[int, int], px_per_mm: float) -> Image.Image:
    """Where the fringes are in a picture of the board: 255 within its gratings, turned ones too."""
    x0, y0, _, _ = badge.outline_mm
    fields = Image.new("L", size, 0)
    for grating in badge.gratings:
        corners = (badge.corners_of(grating) - (x0, y0)) * px_per_mm
        ImageDraw.Draw(fields).polygon([(x, y) for x, y in corners.tolist()], fill=255)
    return fields


def _cut_out(size: tuple[int, int], radius_px: float) -> Image.Image:
    """The board's shape: 255 within, its corners rounded."""
    fine = Image.new("L", (4 * size[0], 4 * size[1]), 0)
    ImageDraw.Draw(fine).rounded_rectangle((0, 0, fine.width - 1, fine.height - 1), 4 * radius_px, fill=255)
    return fine.resize(size, Image.Resampling.LANCZOS)


def _ground(size: tuple[int, int], px_per_mm: float, cut: Image.Image) -> tuple[Image.Image, tuple[int, int]]:
    """The background: cloth, cord, clip and the badge's shadow; and where the board's corner goes, px."""
    room, above = round(ROOM_MM * px_per_mm), round(ABOVE_MM * px_per_mm)
    ground = Image.new("RGB", (size[0] + 2 * room, size[1] + above + room), CLOTH)
    corner, middle = (room, above), ground.width // 2
    draw = ImageDraw.Draw(ground)
    half, reach = round(CORD_MM * px_per_mm / 2), round(0.3 * ground.width)
    for side in (-1, 1):
        top = middle + side * reach
        draw.polygon([(top - half, 0), (top + half, 0), (middle + half, above), (middle - half, above)], fill=CORD)
    shadow = Image.new("L", ground.size, 0)
    shadow.paste(cut, (corner[0], corner[1] + round(1.2 * px_per_mm)))
    shadow = shadow.filter(ImageFilter.GaussianBlur(2.0 * px_per_mm))
    ground.paste(SHADOW, (0, 0), ImageChops.multiply(shadow, Image.new("L", ground.size, 170)))
    wide, high = (round(side * px_per_mm) for side in CLIP_MM)
    draw.rounded_rectangle(
        (middle - wide // 2, above - high, middle + wide // 2, above + 1), round(0.8 * px_per_mm), fill=(120, 126, 134)
    )
    return ground, corner
