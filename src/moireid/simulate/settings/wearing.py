"""What belongs to the badge: its print in colour, holder and cord; and the person who wears it.

Convention: board frame of `motion`, mm; the badge hangs on the middle of the chest.
"""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError
from moireid.simulate.settings.drawn_layers import Canvas, Layer

#: Picture of the board that `print-your-badge` writes next to badge.json.
PRINT_FILE = "preview.png"
#: Its pixels, at most; `print-your-badge` writes fewer, and a film shows none of more.
MOST_PIXELS = 50_000_000
#: Rim of the holder, its rounding, and width of the cord, mm; depths of holder, cord and person behind the page.
RIM_MM, ROUND_MM, CORD_MM = 4.0, 5.0, 16.0
HOLDER_MM, CORD_DEPTH_MM, PERSON_MM = 1.5, 8.0, 22.0
#: Where the cord passes over the shoulders, from the badge's middle, mm.
NECK_MM = (73.0, -246.0)
CORD, JACKET, SHIRT, SKIN, HAIR, TIE = "#0f4c81", "#39424f", "#e9edf1", "#c99873", "#3a2a20", "#7b2d3b"


def load_print(badge_json: Path) -> NDArray[np.uint8] | None:
    """The board's print in colour, of the picture next to the badge's file; None where there is none.

    Raises
    ------
    MediaError
        For a file of that name that is no picture, or of more than `MOST_PIXELS`.
    """
    from PIL import Image

    path = badge_json.with_name(PRINT_FILE)
    if not path.is_file():
        return None
    try:
        with Image.open(path) as picture:
            if picture.width * picture.height > MOST_PIXELS:
                raise Image.DecompressionBombError
            return np.asarray(picture.convert("RGB"))[..., ::-1].copy()
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise MediaError(f"{path} is no picture of the badge; print the badge again, or move that file away") from error


def board_layer(print_picture: NDArray[np.uint8], half_mm: tuple[float, float]) -> Layer:
    """The board's colours at the page's depth; its brightness comes from the renderer."""
    per_mm = 3.0
    size = [math.ceil(2 * side * per_mm) for side in half_mm]
    small = cv2.resize(print_picture, (size[0], size[1]), interpolation=cv2.INTER_AREA)
    opaque = np.full((*small.shape[:2], 1), 255, np.uint8)
    return Layer(np.concatenate([small, opaque], axis=-1), 0.0, (-half_mm[0], -half_mm[1]), per_mm)


def holder(half_mm: tuple[float, float]) -> Layer:
    """A dark plastic frame around the board with a slot, a clip above it, and a soft shadow behind."""
    x, y = half_mm[0] + RIM_MM, half_mm[1] + RIM_MM
    canvas = Canvas((-x - 14, -y - 34, x + 14, y + 16), 3.0)
    canvas.rect((-x - 1, -y + 3, x + 3, y + 5), "#00000070", ROUND_MM, 4.0)
    canvas.rect((-x, -y, x, y), "#20252b", ROUND_MM)
    canvas.rect((-x + 0.6, -y + 0.6, x - 0.6, y - 0.6), "#343b44", ROUND_MM)
    canvas.rect((-14, -y - 11, 14, -y + 3), "#20252b", 4.0)
    canvas.rect((-8, -y - 7.5, 8, -y - 3.5), "#11141a", 2.0)
    canvas.rect((-3.2, -y - 24, 3.2, -y - 4), "#9aa3ad", 2.0)
    canvas.rect((-1.8, -y - 22, 0.2, -y - 6), "#d3d8de", 1.0, 0.4)
    return canvas.layer(HOLDER_MM)


def cord(half_mm: tuple[float, float]) -> Layer:
    """The cord from the shoulders to the clip, with a mark that is repeated along it."""
    bottom = -half_mm[1] - RIM_MM - 22
    canvas = Canvas((-NECK_MM[0] - 20, NECK_MM[1] - 8, NECK_MM[0] + 20, bottom + 8), 2.0)
    for side in (-1, 1):
        top, foot = np.array([side * NECK_MM[0], NECK_MM[1]]), np.array([side * 3.0, bottom])
        along = (foot - top) / np.linalg.norm(foot - top)
        out = np.array([along[1], -along[0]]) * CORD_MM / 2
        shadow = np.array([2.0, 4.0])
        canvas.polygon([tuple(p + shadow) for p in (top - out, top + out, foot + out, foot - out)], "#00000060", 2.5)
        canvas.polygon([tuple(p) for p in (top - out, top + out, foot + out, foot - out)], CORD)
        length = float(np.linalg.norm(foot - top))
        for place in np.arange(18.0, length - 12, 30.0):
            middle = top + along * place
            canvas.ellipse((float(middle[0]), float(middle[1])), (3.6, 3.6), "#f2f6fa")
            canvas.ellipse((float(middle[0]), float(middle[1])), (2.0, 2.0), CORD)
    canvas.rect((-7, bottom - 8, 7, bottom + 4), "#7d8791", 2.0)
    return canvas.layer(CORD_DEPTH_MM)


def person(seed: int) -> Layer:
    """Head, shoulders and chest of a person in a jacket, from the front, with the cord's turn about the neck."""
    canvas = Canvas((-420.0, -610.0, 420.0, 700.0), 1.5)
    canvas.curve([(-62, -300), (-60, -210), (0, -170), (60, -210), (62, -300), (0, -330)], SKIN, 1.5)
    canvas.curve([(-60, -300), (-40, -268), (0, -258), (40, -268), (60, -300), (0, -310)], "#5a341c48", 7.0)
    body = [(-70, -262), (-150, -228), (-262, -190), (-318, -90), (-345, 160), (-372, 700), (372, 700), (345, 160)]
    body += [(318, -90), (262, -190), (150, -228), (70, -262)]
    canvas.curve([*body, (0, -185)], JACKET, 1.0)
    canvas.polygon([(-72, -264), (0, 210), (72, -264), (0, -178)], SHIRT, 1.2)
    canvas.polygon([(-66, -258), (-84, -212), (-24, -150), (0, -182)], "#f6f8fa", 0.8)
    canvas.polygon([(66, -258), (84, -212), (24, -150), (0, -182)], "#f6f8fa", 0.8)
    canvas.polygon([(-14, -180), (14, -180), (9, -152), (-9, -152)], TIE, 0.8)
    canvas.polygon([(-9, -152), (9, -152), (24, 150), (0, 190), (-24, 150)], TIE, 0.8)
    for side in (-1, 1):
        lapel = [(70, -266), (118, -236), (150, -120), (112, -102), (132, -78), (4, 220), (40, -60)]
        canvas.polygon([(side * x + 3, y + 5) for x, y in lapel], "#00000050", 5.0)
        canvas.polygon([(side * x, y) for x, y in lapel], "#434d5b", 0.8)
        canvas.curve(
            [(side * x, y) for x, y in [(262, 20), (246, 260), (266, 700), (284, 700), (262, 250)]], "#00000050", 9.0
        )
    for height in (285.0, 400.0):
        canvas.ellipse((0.0, height), (8.0, 8.0), "#1f252d", 0.6)
    canvas.grain(seed, (0.5, 0.9), 0.02)
    canvas.grain(seed + 1, (60.0, 90.0), 0.05)
    _head(canvas)
    x = np.abs(2 * canvas.across() - 1)
    canvas.shade((1.04 - 0.5 * x**2.2) * (1.04 - 0.12 * canvas.down()))
    return canvas.layer(PERSON_MM)


def _head(canvas: Canvas) -> None:
    """A face with few features, so that it is no real person's."""
    canvas.ellipse((0.0, -425.0), (92.0, 126.0), HAIR, 2.5)
    for side in (-1, 1):
        canvas.ellipse((side * 80.0, -405.0), (10.0, 24.0), "#b98862", 1.5)
    canvas.curve(
        [(-78, -470), (-84, -395), (-62, -318), (0, -288), (62, -318), (84, -395), (78, -470), (0, -520)], SKIN, 1.5
    )
    canvas.curve(
        [(-84, -440), (-90, -520), (-30, -560), (40, -556), (92, -510), (84, -440), (60, -500), (-20, -510)], HAIR, 2.0
    )
    for side in (-1, 1):
        canvas.ellipse((side * 33.0, -404.0), (13.0, 6.5), "#f3efe9", 1.0)
        canvas.ellipse((side * 33.0, -404.0), (6.0, 6.2), "#3b2b22", 0.8)
        canvas.curve([(side * 14, -424), (side * 34, -432), (side * 54, -424), (side * 34, -426)], HAIR, 1.0)
        canvas.ellipse((side * 52.0, -362.0), (22.0, 18.0), "#c9745a28", 8.0)
    canvas.curve([(-8, -400), (-14, -362), (0, -352), (14, -362), (8, -400)], "#a9764f50", 4.0)
    canvas.curve([(-26, -330), (0, -336), (26, -330), (0, -318)], "#a35f52", 1.6)
    canvas.curve([(30, -520), (92, -450), (80, -330), (20, -290), (62, -390)], "#00000030", 12.0)
