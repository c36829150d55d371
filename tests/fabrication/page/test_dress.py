"""Artwork on the page: no dot of what is read changes, no marker is hidden or made; without it, all is as before."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pypdfium2 as pdfium
import pytest
from PIL import Image, ImageDraw

from moireid.artwork.clear import clear_zones
from moireid.artwork.content import Artwork, with_lines
from moireid.artwork.placing import Look
from moireid.artwork.template import TEMPLATES, template_named
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS, turned
from moireid.errors import SpecError
from moireid.fabrication.page.marks import OWN_MARKERS, check_look, marker_modules, qr_rects
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.fabrication.page.preview import draw_preview

PAYLOAD = bytes.fromhex("7097c67b0fafc59b")
DPI = 150


def dressed(template: str, folder: Path, name: str = "a7", orientation: str = "portrait") -> Badge:
    """A badge with a logo of nested squares, a chessboard for a portrait, and two lines."""
    logo = Image.new("RGB", (600, 200), "white")
    for k in range(5):
        box = (20 + 18 * k, 20 + 18 * k, 180 - 18 * k, 180 - 18 * k)
        ImageDraw.Draw(logo).rectangle(box, fill=("black", "white")[k % 2])
    ImageDraw.Draw(logo).rectangle((220, 60, 580, 140), outline="black", width=12)
    logo.save(folder / "logo.png")
    squares = np.kron(np.indices((10, 8)).sum(axis=0) % 2, np.ones((20, 20)))
    Image.fromarray((255 * squares).astype(np.uint8)).save(folder / "face.png")
    look = Look(template_named(template), Artwork(folder / "logo.png", folder / "face.png", (0.5, 0.1, 0.3)))
    side = look.template.side(*turned(FORMATS[name].size_mm, orientation))
    order = Order("Ada Lovelace", format=name, orientation=orientation, head=side.head, foot=side.foot)
    badge = design_badge(order, PAYLOAD)
    return replace(with_lines(badge, ["Reporter", "Example News"]), look=look)


def board_of(pdf: Path, badge: Badge) -> np.ndarray:
    """The board on page 1, in grey, `DPI`."""
    document = pdfium.PdfDocument(pdf)
    page = np.array(document[0].render(scale=DPI / 72, grayscale=True).to_numpy())
    document.close()
    x0, y0, x1, y1 = (round(side * DPI / 25.4) for side in badge.outline_mm)
    return page.reshape(page.shape[:2])[y0:y1, x0:x1]


def markers_in(picture: np.ndarray, badge: Badge) -> dict[int, tuple[float, float]]:
    """Middles of all markers that OpenCV finds, as shares of the board, by id; an id that is found twice is -1."""
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, badge.markers.dictionary))
    corners, ids, _ = cv2.aruco.ArucoDetector(known).detectMarkers(np.ascontiguousarray(picture))
    found: dict[int, tuple[float, float]] = {}
    for quad, identity in zip(corners, [] if ids is None else np.ravel(ids), strict=True):
        x, y = quad.reshape(4, 2).mean(axis=0) + 0.5
        found[-1 if int(identity) in found else int(identity)] = (x / picture.shape[1], y / picture.shape[0])
    return found


@pytest.mark.claim("Artwork changes no dot of what is read")
@pytest.mark.parametrize("template", list(TEMPLATES)[::2])
def test_artwork_changes_no_dot_of_what_is_read(template: str, tmp_path: Path) -> None:
    """Catches: a ground, word or picture in the white of a marker or next to the fringes; lines moved by a colour left
    on; a logo or QR code that is taken for a marker or hides one, near and far.
    """
    badge = dressed(template, tmp_path)
    check_look(badge)
    bare, worn = tmp_path / "bare.pdf", tmp_path / "worn.pdf"
    write_badge_pdf(badge, bare, write_words=lambda sheet, badge: None)
    write_badge_pdf(badge, worn)
    pictures = [board_of(path, badge) for path in (bare, worn)]
    scale, (left, top, _, _) = DPI / 25.4, badge.outline_mm
    for _, (x0, y0, x1, y1) in clear_zones(badge):
        rows = slice(max(round((y0 - top) * scale), 0) + 1, round((y1 - top) * scale) - 1)
        columns = slice(max(round((x0 - left) * scale), 0) + 1, round((x1 - left) * scale) - 1)
        assert np.array_equal(pictures[0][rows, columns], pictures[1][rows, columns])
    assert np.mean(pictures[0] != pictures[1]) > 0.01
    x0, y0, x1, y1 = badge.outline_mm
    places = {
        identity: ((x - x0) / (x1 - x0), (y - y0) / (y1 - y0))
        for identity, (x, y) in zip(badge.markers.ids, badge.markers.centers_mm, strict=True)
    }
    seen = np.asarray(draw_preview(badge).convert("L"))
    for px_per_mm in (6.0, 3.0):
        size = (round((x1 - x0) * px_per_mm), round((y1 - y0) * px_per_mm))
        found = markers_in(cv2.resize(seen, size, interpolation=cv2.INTER_AREA), badge)
        assert set(found) == set(places)
        for identity, place in places.items():
            assert found[identity] == pytest.approx(place, abs=0.01)


def test_a_logo_that_is_a_marker_is_refused(tmp_path: Path) -> None:
    """Catches: a fifth marker on the board, which a camera takes for a corner of it."""
    badge = dressed("conference", tmp_path)
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    marker = Image.fromarray(cv2.aruco.generateImageMarker(known, 2, 120)).convert("RGB")
    logo = Image.new("RGB", (400, 160), "white")
    logo.paste(marker, (20, 20))
    logo.save(tmp_path / "marked.png")
    with pytest.raises(SpecError, match="a square that is read as a marker"):
        content = replace(badge.look.content, logo=tmp_path / "marked.png")
        check_look(replace(badge, look=replace(badge.look, content=content)))


def test_the_qr_code_says_the_identity_and_no_more(tmp_path: Path) -> None:
    """Catches: modules mirrored or turned, a code of the payload's secret or of another badge."""
    badge = dressed("court", tmp_path)
    picture = np.full((460, 460), 255, np.uint8)
    for x0, y0, x1, y1 in qr_rects(badge, (40.0, 40.0, 420.0, 420.0)):
        picture[round(y0) : round(y1), round(x0) : round(x1)] = 0
    words, _, _ = cv2.QRCodeDetector().detectAndDecode(picture)
    assert words == "moireid:7097c67b0fafc59b"


@pytest.mark.parametrize(("dictionary", "identity"), [(name, k) for name in OWN_MARKERS for k in range(5)])
def test_markers_are_those_that_opencv_finds(dictionary: str, identity: int) -> None:
    """Catches: a module of our own markers that is mistyped; one beyond them that is another's."""
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    assert np.array_equal(marker_modules(dictionary, identity), cv2.aruco.generateImageMarker(known, identity, 6) > 127)
