"""What a board shows besides its lines: rectangles, rows of glyphs and pictures, as one list for page and preview.

Convention: page mm, origin top left; a colour of None is the printer's black, or the paper where `paper` says so.  The
artwork is placed by `moireid.artwork.placing`, which keeps it away from what is read.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from moireid.artwork.colours import Colour
from moireid.artwork.content import Artwork, lines_of
from moireid.artwork.pictures import modules_of
from moireid.artwork.placing import ArtPiece, Look, pieces_of, unworn
from moireid.artwork.template import template_named
from moireid.badge import Badge, CodedFrame, Point, Rect
from moireid.errors import SpecError
from moireid.fabrication.page.canvas import PdfPage
from moireid.fabrication.page.lettering import line_note, name_note
from moireid.fabrication.page.page_words import MM_PER_POINT, SetWords, set_words
from moireid.fabrication.text.raster import line_mask

#: White between words and a frame or the board's edge, and the least room for words, mm.
LETTERING_GAP_MM, LEAST_LETTERING_MM = 1.0, 2.0
NAME_POINTS = 20.0
#: Longer sides at which a picture is searched for markers, px: from near, and far away.
SEEN_PX = (640, 320, 160, 80)
#: Counts of black and of paper in a picture of the board.
INK, PAPER = 28, 250
#: The 16 modules of the markers of our own badges, row by row; OpenCV, which has all, takes as long to load as a page
#: to draw.
OWN_MARKERS = {"DICT_4X4_50": (0xB532, 0x0F9A, 0x332D, 0x9946)}


@dataclass(frozen=True)
class Fill:
    """Rectangles, filled as one, so that those that touch leave no seam; paper: white, as if nothing were printed."""

    rects_mm: tuple[Rect, ...]
    colour: Colour | None = None
    paper: bool = False


@dataclass(frozen=True)
class Pasted:
    """A picture, RGBA, stretched over a rectangle."""

    picture: Image.Image
    rect_mm: Rect


Mark = Fill | SetWords | Pasted


def marks(badge: Badge) -> list[Mark]:
    """All that the board shows besides its lines, in the order in which it is drawn.

    Raises: FabricationError for a name of which nothing can be printed; SpecError as `pieces_of` and `set_words`.
    """
    found = marker_marks(badge)
    worn = look_of(badge)
    if worn is None:
        return [*found, *_name_and_id(badge)]
    return found + [mark for piece in pieces_of(badge, worn) for mark in _marks_of(badge, piece)]


def marker_marks(badge: Badge) -> list[Mark]:
    """The markers, or the coded frame."""
    pairs = ((Fill((square,)), Fill(tuple(white), paper=True)) for square, white in marker_squares(badge))
    return [fill for pair in pairs for fill in pair]


def draw_marks(sheet: PdfPage, found: Iterable[Mark]) -> None:
    """Draw marks on a sheet."""
    for mark in found:
        if isinstance(mark, Fill):
            sheet.fill(list(mark.rects_mm), grey=float(mark.paper), colour=mark.colour)
        elif isinstance(mark, SetWords):
            sheet.line(mark.x_mm, mark.baseline_mm, mark.line, points=mark.points, colour=mark.colour)
        else:
            sheet.picture(mark.picture, mark.rect_mm)


def paint_marks(picture: Image.Image, found: Iterable[Mark], corner_mm: Point, px_per_mm: float) -> None:
    """Draw marks into a picture, grey or in colour, whose upper left corner is at a place of the page."""
    draw = ImageDraw.Draw(picture)

    def pixels(rect: Rect) -> list[int]:
        return [round((value - corner_mm[k % 2]) * px_per_mm) for k, value in enumerate(rect)]

    def fill(colour: Colour | None, *, paper: bool = False) -> tuple[int, ...] | int:
        counts = [PAPER if paper else INK] * 3 if colour is None else [round(255 * part) for part in colour]
        return counts[0] if picture.mode == "L" else tuple(counts)

    for mark in found:
        if isinstance(mark, Fill):
            for x0, y0, x1, y1 in map(pixels, mark.rects_mm):
                box = (x0, y0, max(x1 - 1, x0), max(y1 - 1, y0))
                draw.rectangle(box, fill=fill(mark.colour, paper=mark.paper))
        elif isinstance(mark, SetWords):
            x, y = ((place - corner_mm[k]) * px_per_mm for k, place in enumerate((mark.x_mm, mark.baseline_mm)))
            if (masked := line_mask(mark.line, mark.points * MM_PER_POINT * px_per_mm, x, y)) is not None:
                mask, (left, top) = masked
                picture.paste(fill(mark.colour), (left, top, left + mask.width, top + mask.height), mask)
        else:
            x0, y0, x1, y1 = pixels(mark.rect_mm)
            fitted = mark.picture.resize((max(x1 - x0, 1), max(y1 - y0, 1)), Image.Resampling.LANCZOS)
            picture.paste(fitted, (x0, y0), fitted)


def look_of(badge: Badge) -> Look | None:
    """The badge's look, the plain one for a badge with lines and no look, and None for one of name and id alone."""
    plain = badge.look is None and lines_of(badge)
    look: Look | None = Look(template_named("plain"), Artwork()) if plain else badge.look
    return look


def check_look(badge: Badge) -> None:
    """Check before anything is made that all pieces have room, and that none is taken for a marker.

    Raises: SpecError as `pieces_of` and `set_words`, and for a picture that holds a marker of the badge's kind.
    """
    if look_of(badge) is None:
        return
    for mark in marks(badge):
        if isinstance(mark, Pasted) and _holds_marker(badge, mark.picture):
            raise SpecError(
                "the logo or portrait shows a square that is read as a marker, so the badge would not be found; take "
                "the square out of the picture"
            )


def look_notes(badge: Badge) -> list[str]:
    """One sentence for each given thing that is not printed: letters of lines, and what the template leaves out."""
    worn = look_of(badge)
    if worn is None:
        return []
    lines = [line_note(line) for line in lines_of(badge)]
    return [note for note in lines if note] + unworn(badge, worn)


def marker_squares(badge: Badge) -> list[tuple[Rect, list[Rect]]]:
    """For each marker its black square and, within, the runs of white modules; or a frame's sides and their notches.

    Convention: markers upright on the page, module rows from top to bottom.
    Returns: four pairs (black rectangle, white rectangles), page mm.
    """
    if isinstance(badge.markers, CodedFrame):
        return [(side, badge.markers.notches_in(number)) for number, side in enumerate(badge.markers.dark_mm)]
    squares = []
    for identity, square in zip(badge.markers.ids, badge.markers.dark_mm, strict=True):
        modules = marker_modules(badge.markers.dictionary, identity)
        squares.append((square, runs_mm(modules, square[:2], badge.markers.size_mm / len(modules))))
    return squares


def marker_modules(dictionary: str, identity: int) -> NDArray[np.bool_]:
    """The modules of an ArUco marker with its black border, True where white; square, row by row from the top."""
    own = OWN_MARKERS.get(dictionary, ())
    if identity < len(own):
        return np.pad(np.array([own[identity] >> k & 1 for k in range(15, -1, -1)], bool).reshape(4, 4), 1)
    import cv2

    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    side = known.markerSize + 2
    return np.asarray(cv2.aruco.generateImageMarker(known, identity, side)) > 127


def runs_mm(modules: NDArray[np.bool_], corner_mm: Point, module_mm: float) -> list[Rect]:
    """The modules that are True, each row's runs as one rectangle; corner_mm: of the first module, page mm."""
    rects: list[Rect] = []
    for row, line in enumerate(modules):
        top = corner_mm[1] + row * module_mm
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(int), [0]])))
        for begin, end in edges.reshape(-1, 2).tolist():
            left = corner_mm[0] + begin * module_mm
            rects.append((left, top, left + (end - begin) * module_mm, top + module_mm))
    return rects


def qr_rects(badge: Badge, rect: Rect) -> list[Rect]:
    """The dark modules of the identity's code in a square."""
    modules = np.array(modules_of(badge.id or "none"), bool)
    return runs_mm(modules, rect[:2], (rect[2] - rect[0]) / len(modules))


def lettering_places(badge: Badge) -> tuple[tuple[Point, ...], float]:
    """The four places between which name and id are written, and half the height of their room, page mm.

    Convention: as `Markers.centers_mm`: the name between the first two, the id between the others.  A frame has no
        markers; the places are then above and below it.
    """
    if not isinstance(badge.markers, CodedFrame):
        return badge.markers.centers_mm, badge.markers.size_mm / 2
    board, (x0, y0, x1, y1) = badge.outline_mm, badge.markers.rect_mm
    half = max(min(y0 - board[1], board[3] - y1) / 2 - LETTERING_GAP_MM, LEAST_LETTERING_MM / 2)
    upper, lower = (board[1] + y0) / 2, (board[3] + y1) / 2
    return ((x0 - half, upper), (x1 + half, upper), (x1 + half, lower), (x0 - half, lower)), half


def _name_and_id(badge: Badge) -> list[SetWords]:
    """The words of a badge without artwork: the name between the upper markers, the id between the lower ones."""
    name_note(badge.name)
    centers, half = lettering_places(badge)
    middle = (centers[0][0] + centers[1][0]) / 2
    aside = (centers[1][0] - centers[0][0]) / 2 - half - 3.0
    rooms = [(middle - aside, y - half, middle + aside, y + half) for y in (centers[0][1], centers[3][1])]
    name = ArtPiece("words", rooms[0], name=badge.name, points=NAME_POINTS)
    return [*set_words(name, badge.id), *set_words(ArtPiece("id", rooms[1], least_points=0.0), badge.id)]


def _marks_of(badge: Badge, piece: ArtPiece) -> list[Mark]:
    """One piece of the artwork."""
    if piece.kind == "ground":
        return [Fill((piece.rect_mm,), piece.colour)]
    if piece.kind == "qr":
        return [Fill(tuple(qr_rects(badge, piece.rect_mm)), piece.colour)]
    if piece.kind == "picture":
        assert piece.picture is not None
        return [Pasted(piece.picture, piece.rect_mm)]
    return [*set_words(piece, badge.id)]


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
