"""fringes.webp: how the fringes look, and which way they run, as a head moves: a badge as it should be, and three not.

Convention: the head at the foot of the picture is where the eye is, as seen from behind it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from moireid.badge import Badge
from moireid.fabrication.assembly.sketches import GOOD, LEANING, MIRRORED, WIDE, fringe_pictures
from moireid.fabrication.page.canvas import font_file
from moireid.fabrication.page.preview import view_mm, write_moving

LOOKS = (
    ("right", GOOD),
    ("the other way: wrong size or sheet", MIRRORED),
    ("leaning: turn the sheet a little", LEANING),
    ("too wide: wrong size or sheet", WIDE),
)
#: Width of a picture, white around it, height of a caption and of the head's strip, px.
WIDE_PX, GAP_PX, CAPTION_PX, HEAD_PX = 240, 14, 20, 40
PAPER, INK, FRAMES, FRAME_MS = 250, 28, 12, 130
#: How far a head swings to each side, over its distance.
SWING = 0.22


def write_looks(badge: Badge, path: Path) -> None:
    """Draw the moving picture and write it as animated WebP, whole or not at all."""
    swing = [round(math.sin(2 * math.pi * k / FRAMES), 6) for k in range(FRAMES)]
    # On the way back the head passes the same places.
    asides = list(dict.fromkeys(swing))
    asides_mm = [aside * SWING * view_mm(badge) for aside in asides]
    looks = zip(*(fringe_pictures(badge, asides_mm, **look) for _, look in LOOKS), strict=True)
    shown = {aside: _frame(aside, pictures) for aside, pictures in zip(asides, looks, strict=True)}
    write_moving([shown[aside] for aside in swing], path, frame_ms=FRAME_MS)


def _frame(aside: float, pictures: Sequence[Image.Image]) -> Image.Image:
    """The four looks, two a row, from a head that is aside by that share of its swing."""
    high = round(WIDE_PX * pictures[0].height / pictures[0].width)
    across, down = WIDE_PX + GAP_PX, CAPTION_PX + high + GAP_PX
    frame = Image.new("L", (2 * across + GAP_PX, 2 * down + HEAD_PX), PAPER)
    draw, font = ImageDraw.Draw(frame), ImageFont.truetype(str(font_file()), 13)
    for k, ((words, _), picture) in enumerate(zip(LOOKS, pictures, strict=True)):
        x, y = GAP_PX + k % 2 * across, k // 2 * down
        draw.text((x, y + 3), words, INK, font)
        frame.paste(picture.resize((WIDE_PX, high), Image.Resampling.NEAREST), (x, y + CAPTION_PX))
    reach = 0.4 * WIDE_PX
    middle, level = frame.width / 2, frame.height - HEAD_PX / 2
    head = middle + reach * aside
    draw.line((middle - reach, level, middle + reach, level), 170)
    draw.ellipse((head - 9, level - 11, head + 9, level + 11), INK)
    draw.text((GAP_PX, level - 8), "your head", INK, font)
    return frame
