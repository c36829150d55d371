"""The badge's artwork, drawn in a picture of the board: the same pieces as `dress.py` draws on the page."""

from __future__ import annotations

from PIL import Image, ImageDraw, ImageFont

from moireid.artwork.colours import Colour
from moireid.artwork.placing import ArtPiece, Look, pieces_of
from moireid.badge import Badge, Rect
from moireid.fabrication.page.artwork import font_file
from moireid.fabrication.page.dress import corner_of, mask_of, qr_rects
from moireid.fabrication.page.lettering import PICTURE_DPI
from moireid.fabrication.page.page_words import SetWords, set_words

ANCHORS = {"left": "ls", "center": "ms", "right": "rs"}


def dress_picture(picture: Image.Image, badge: Badge, look: Look, px_per_mm: float) -> None:
    """Draw all pieces into a colour picture of the board, whose corner is the board's."""
    for piece in pieces_of(badge, look):
        paint_piece(picture, badge, piece, px_per_mm)


def paint_piece(picture: Image.Image, badge: Badge, piece: ArtPiece, px_per_mm: float) -> None:
    """Draw one piece."""
    if piece.kind in ("words", "id"):
        for line in set_words(piece, badge.id):
            _write(picture, badge, line, piece.colour, px_per_mm)
    elif piece.kind == "picture":
        assert piece.picture is not None
        _paste(picture, piece.picture, _pixels(badge, piece.rect_mm, px_per_mm))
    else:
        draw = ImageDraw.Draw(picture)
        for rect in [piece.rect_mm] if piece.kind == "ground" else qr_rects(badge, piece.rect_mm):
            x0, y0, x1, y1 = _pixels(badge, rect, px_per_mm)
            draw.rectangle((x0, y0, max(x1 - 1, x0), max(y1 - 1, y0)), fill=_counts(piece.colour))


def _write(picture: Image.Image, badge: Badge, line: SetWords, colour: Colour, px_per_mm: float) -> None:
    if line.picture is not None:
        left, top = corner_of(line)
        wide, high = (side / PICTURE_DPI * 25.4 for side in line.picture.size)
        x0, y0, x1, y1 = _pixels(badge, (left, top, left + wide, top + high), px_per_mm)
        mask = mask_of(line).resize((max(x1 - x0, 1), max(y1 - y0, 1)), Image.Resampling.LANCZOS)
        picture.paste(_counts(colour), (x0, y0), mask)
        return
    font = ImageFont.truetype(str(font_file(bold=line.bold)), line.points / 72 * 25.4 * px_per_mm)
    x, y = ((place - badge.outline_mm[k]) * px_per_mm for k, place in enumerate((line.x_mm, line.baseline_mm)))
    ImageDraw.Draw(picture).text((x, y), line.words, fill=_counts(colour), font=font, anchor=ANCHORS[line.align])


def _paste(picture: Image.Image, piece: Image.Image, pixels: tuple[int, int, int, int]) -> None:
    x0, y0, x1, y1 = pixels
    fitted = piece.resize((max(x1 - x0, 1), max(y1 - y0, 1)), Image.Resampling.LANCZOS)
    picture.paste(fitted, (x0, y0), fitted)


def _pixels(badge: Badge, rect: Rect, px_per_mm: float) -> tuple[int, int, int, int]:
    x0, y0, x1, y1 = (round((value - badge.outline_mm[k % 2]) * px_per_mm) for k, value in enumerate(rect))
    return x0, y0, x1, y1


def _counts(colour: Colour) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
