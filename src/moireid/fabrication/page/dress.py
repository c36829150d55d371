"""The badge's artwork, on its page and in a picture of the board: grounds, words, pictures and the QR code.

Convention: page mm, origin top left; placed by `moireid.artwork.placing`, which keeps it away from what is read.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PIL import Image, ImageDraw

from moireid.artwork.colours import Colour
from moireid.artwork.content import Artwork, lines_of
from moireid.artwork.pictures import modules_of
from moireid.artwork.placing import ArtPiece, Look, pieces_of, unworn
from moireid.artwork.template import template_named
from moireid.badge import Badge, CodedFrame, Rect
from moireid.errors import SpecError
from moireid.fabrication.page.canvas import POINTS_PER_MM, PdfPage
from moireid.fabrication.page.lettering import line_note
from moireid.fabrication.page.page_words import MM_PER_POINT, SetWords, set_words
from moireid.fabrication.text.raster import line_mask

#: Longer sides at which a picture is searched for markers, px: from near, and far away.
SEEN_PX = (640, 320, 160, 80)


def look_of(badge: Badge, look: Look | None) -> Look | None:
    """The look, the plain one for a badge with lines and no look, and None for one of name and id alone."""
    return Look(template_named("plain"), Artwork()) if look is None and lines_of(badge) else look


def writer_of(badge: Badge, look: Look | None) -> Callable[[PdfPage, Badge], None] | None:
    """What `pdf.draw_board` calls to write that badge's board; None for name and id alone."""
    worn = look_of(badge, look)
    if worn is None:
        return None

    def write(sheet: PdfPage, badge: Badge) -> None:
        for piece in pieces_of(badge, worn):
            draw_piece(sheet, badge, piece)

    return write


def check_look(badge: Badge, look: Look | None) -> None:
    """Check before anything is made that all pieces have room, and that none is taken for a marker.

    Raises: SpecError as `pieces_of` and `set_words`, and for a picture that holds a marker of the badge's kind.
    """
    worn = look_of(badge, look)
    for piece in pieces_of(badge, worn) if worn else ():
        if piece.kind in ("words", "id"):
            set_words(piece, badge.id)
        elif piece.kind == "picture" and piece.picture is not None and _holds_marker(badge, piece.picture):
            raise SpecError(
                "the logo or portrait shows a square that is read as a marker, so the badge would not be found; take "
                "the square out of the picture"
            )


def look_notes(badge: Badge, look: Look | None) -> list[str]:
    """One sentence for each given thing that is not printed: letters of lines, and what the template leaves out."""
    worn = look_of(badge, look)
    if worn is None:
        return []
    lines = [line_note(line) for line in lines_of(badge)]
    return [note for note in lines if note] + unworn(badge, worn)


def _holds_marker(badge: Badge, picture: Image.Image) -> bool:
    """Whether a picture on white is read as a marker at any size at which a camera may see it."""
    import cv2

    if isinstance(badge.markers, CodedFrame):
        # A frame is recognised by the notches of a line around the whole board, which no picture on it has.
        return False
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, badge.markers.dictionary))
    detector = cv2.aruco.ArucoDetector(known)
    small = picture.copy()
    for side in SEEN_PX:
        # Each from the one before, because the whole picture is large.
        small.thumbnail((side, side))
        page = Image.new("L", (small.width + side // 4, small.height + side // 4), 255)
        page.paste(small.convert("L"), (side // 8, side // 8), small)
        _, found, _ = detector.detectMarkers(np.asarray(page))
        if found is not None:
            return True
    return False


def draw_piece(sheet: PdfPage, badge: Badge, piece: ArtPiece) -> None:
    """Draw one piece on a sheet."""
    if piece.kind == "ground":
        sheet.fill([piece.rect_mm], colour=piece.colour)
    elif piece.kind == "qr":
        sheet.fill(qr_rects(badge, piece.rect_mm), colour=piece.colour)
    elif piece.kind == "picture":
        assert piece.picture is not None
        _picture(sheet, piece.picture, piece.rect_mm)
    else:
        for line in set_words(piece, badge.id):
            write_line(sheet, line, piece.colour)


def qr_rects(badge: Badge, rect: Rect) -> list[Rect]:
    """The dark modules of the identity's code in a square, each row's runs as one rectangle."""
    modules = modules_of(badge.id or "none")
    size = (rect[2] - rect[0]) / len(modules)
    rects: list[Rect] = []
    for row, line in enumerate(modules):
        top = rect[1] + row * size
        begin = None
        for k, dark in enumerate([*line, False]):
            if dark and begin is None:
                begin = k
            elif not dark and begin is not None:
                rects.append((rect[0] + begin * size, top, rect[0] + k * size, top + size))
                begin = None
    return rects


def _picture(sheet: PdfPage, picture: Image.Image, rect: Rect) -> None:
    from reportlab.lib.utils import ImageReader

    (x0, y0), (x1, y1) = sheet.place(rect[0], rect[1]), sheet.place(rect[2], rect[3])
    place = (x0 * POINTS_PER_MM, (sheet.height_mm - y1) * POINTS_PER_MM)
    size = ((x1 - x0) * POINTS_PER_MM, (y1 - y0) * POINTS_PER_MM)
    sheet.canvas.drawImage(ImageReader(picture), *place, *size, mask="auto")


def write_line(sheet: PdfPage, line: SetWords, colour: Colour | None = None) -> None:
    """Write one row on a sheet, as text; black, if no colour is given."""
    sheet.line(line.x_mm, line.baseline_mm, line.line, points=line.points, colour=colour)


def dress_picture(picture: Image.Image, badge: Badge, look: Look, px_per_mm: float) -> None:
    """Draw all pieces into a colour picture of the board, whose corner is the board's."""
    for piece in pieces_of(badge, look):
        paint_piece(picture, badge, piece, px_per_mm)


def paint_piece(picture: Image.Image, badge: Badge, piece: ArtPiece, px_per_mm: float) -> None:
    """Draw one piece."""
    if piece.kind in ("words", "id"):
        for line in set_words(piece, badge.id):
            paint_line(picture, badge, line, _counts(piece.colour), px_per_mm)
    elif piece.kind == "picture":
        assert piece.picture is not None
        _paste_picture(picture, piece.picture, _pixels(badge, piece.rect_mm, px_per_mm))
    else:
        draw = ImageDraw.Draw(picture)
        for rect in [piece.rect_mm] if piece.kind == "ground" else qr_rects(badge, piece.rect_mm):
            x0, y0, x1, y1 = _pixels(badge, rect, px_per_mm)
            draw.rectangle((x0, y0, max(x1 - 1, x0), max(y1 - 1, y0)), fill=_counts(piece.colour))


def paint_line(
    picture: Image.Image, badge: Badge, line: SetWords, fill: tuple[int, int, int] | int, px_per_mm: float
) -> None:
    """Draw one row into a picture of the board; fill: the colour of its letters."""
    x, y = ((place - badge.outline_mm[k]) * px_per_mm for k, place in enumerate((line.x_mm, line.baseline_mm)))
    found = line_mask(line.line, line.points * MM_PER_POINT * px_per_mm, x, y)
    if found is not None:
        mask, corner = found
        picture.paste(fill, (*corner, corner[0] + mask.width, corner[1] + mask.height), mask)


def _paste_picture(picture: Image.Image, piece: Image.Image, pixels: tuple[int, int, int, int]) -> None:
    x0, y0, x1, y1 = pixels
    fitted = piece.resize((max(x1 - x0, 1), max(y1 - y0, 1)), Image.Resampling.LANCZOS)
    picture.paste(fitted, (x0, y0), fitted)


def _pixels(badge: Badge, rect: Rect, px_per_mm: float) -> tuple[int, int, int, int]:
    x0, y0, x1, y1 = (round((value - badge.outline_mm[k % 2]) * px_per_mm) for k, value in enumerate(rect))
    return x0, y0, x1, y1


def _counts(colour: Colour) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
