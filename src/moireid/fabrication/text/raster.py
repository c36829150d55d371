"""Glyphs in a picture, by HarfBuzz's own rasteriser: what the page shows, at any resolution.

Convention: pixels, x to the right and y down, from the picture's upper left corner.
"""

from __future__ import annotations

import numpy as np
import uharfbuzz
from PIL import Image

from moireid.fabrication.text.shaping import ShapedLine, hb_font


def line_mask(
    line: ShapedLine, size_px: float, x: float, baseline: float
) -> tuple[Image.Image, tuple[int, int]] | None:
    """The letters of a line, 255 in a letter, and where the mask's upper left corner goes; None for spaces alone.

    Parameters
    ----------
    line : ShapedLine
        What is drawn.
    size_px : float
        Size of the letters (em), px.
    x, baseline : float
        Place of the line's start, px.
    """
    draw = uharfbuzz.RasterDraw()
    for run in line.runs:
        font = hb_font(run.font)
        scale = size_px / font.face.upem
        for glyph in run.glyphs:
            draw.transform = (scale, 0.0, 0.0, scale, x + glyph.x_em * size_px, glyph.y_em * size_px - baseline)
            draw.draw_glyph(font, glyph.number)
    image = draw.render()
    extents = None if image is None else image.extents
    if extents is None or not extents.width or not extents.height:
        return None
    rows = np.frombuffer(image.buffer, np.uint8).reshape(extents.height, extents.stride)[:, : extents.width]
    # Its rows are from below to above.
    return Image.fromarray(rows[::-1].copy()), (extents.x_origin, -(extents.y_origin + extents.height))
