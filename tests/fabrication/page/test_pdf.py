"""The page as printed and the preview: read back as geometry, as a raster, and as a camera sees it.

Where PDFium rasterises, upright filled rectangles snap to whole pixels, so single edges are up to a pixel off and only
what is averaged over many lines can be held to more.  Geometry is read from the path objects, without a raster.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pypdfium2 as pdfium
import pytest

from kit.drawn import PT_PER_MM, Drawn, geometry
from moireid.badge import Badge, Cell, Rect
from moireid.designer import Order, design_badge
from moireid.fabrication.page import pdf as page
from moireid.fabrication.page import preview
from moireid.fabrication.page.canvas import PdfPage

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")
#: Boards at the corners of what the designer accepts on each paper, and one in between.
BOARDS = [("a4", None), ("letter", None), ("a4", (30.0, 150.0)), ("letter", (120.0, 150.0))]


def raster(path: Path, dpi: float) -> np.ndarray:
    """Page 1 in grey."""
    document = pdfium.PdfDocument(path)
    picture = np.array(document[0].render(scale=dpi / 72, grayscale=True).to_numpy())
    document.close()
    return picture.reshape(picture.shape[:2])


def found_markers(picture: np.ndarray, dictionary: str) -> dict[int, np.ndarray]:
    """Marker centres (pixel edges are whole numbers) by id, and the way that the first side points."""
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary)))
    corners, ids, _ = detector.detectMarkers(np.ascontiguousarray(picture))
    assert ids is not None
    found = {}
    for quad, identity in zip(corners, np.ravel(ids), strict=True):
        quad = quad.reshape(4, 2) + 0.5
        assert quad[0, 0] < quad[1, 0] and quad[0, 1] < quad[3, 1], "the marker lies on its side"
        found[int(identity)] = quad.mean(axis=0)
    return found


@pytest.fixture(scope="module")
def badge() -> Badge:
    # Plain vectors, whose geometry is the badge's own; what dots make of it is in test_dots.py, and lines that bend are
    # in test_smooth_page.py.
    return design_badge(Order("Ada Lovelace", lens="50lpi", form="vector", pattern="cells"), PAYLOAD)


@pytest.fixture(scope="module")
def pdf(badge: Badge, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "badge.pdf"
    page.write_badge_pdf(badge, path)
    return path


@pytest.fixture(scope="module")
def drawn(pdf: Path) -> Drawn:
    return geometry(pdf)


@pytest.fixture(params=BOARDS, ids=lambda board: f"{board[0]}-{board[1]}")
def board(request: pytest.FixtureRequest) -> Badge:
    """A badge on a board of that size; the largest that fits where none is given.  A name of two letters fits all."""
    paper, size = request.param
    if size is None:
        margin = 2 * design_module().PAPER_MARGIN_MM
        size = tuple(side - margin for side in {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}[paper])
    return design_badge(Order("Al", lens="50lpi", paper=paper, size_mm=size, range_m=(0.39, 0.4)), PAYLOAD)


def design_module():
    from moireid.designer import layout

    return layout


# The lines.


def lines_by_hand(low: float, high: float, pitch: float, edge: float, duty: float) -> list[tuple[float, float]]:
    """Dark intervals in exact arithmetic, from every k that could reach the cell."""
    low_, high_, pitch_, edge_, duty_ = (Fraction(str(v)) for v in (low, high, pitch, edge, duty))
    out = []
    for k in range(math.floor((low_ - edge_) / pitch_) - 3, math.ceil((high_ - edge_) / pitch_) + 4):
        begin, end = max(edge_ + k * pitch_, low_), min(edge_ + (k + duty_) * pitch_, high_)
        if end > begin:
            out.append((float(begin), float(end)))
    return out


@pytest.mark.slow
@pytest.mark.parametrize("form", ["dots", "vector"])
def test_ink_growth_narrows_lines_about_their_middles(badge: Badge, tmp_path: Path, form: str) -> None:
    """Catches: lines moved, one edge alone, a growth of each edge instead of both, cells without it."""
    dark = []
    for growth_um in (0.0, 60.0):
        made = replace(badge, print=dict(badge.print or {}) | {"ink_growth_um": growth_um, "form": form})
        page.write_badge_pdf(made, tmp_path / f"{growth_um}.pdf")
        picture = raster(tmp_path / f"{growth_um}.pdf", 2400) < 128
        x0, y0, x1, y1 = (v / 25.4 * 2400 for v in badge.gratings[0].cells[0].rect_mm)
        row = picture[round((y0 + y1) / 2), round(x0) : round(x1)].astype(int)
        dark.append([np.flatnonzero(np.diff(row) == step)[2:100] for step in (1, -1)])
    (wide_from, wide_to), (from_, to) = dark
    first = 1 if wide_to[0] < wide_from[0] else 0
    count = 90
    begun, ended = (from_ - wide_from)[:count], (wide_to - to)[first : first + count]
    assert (begun.mean() + ended.mean()) * 25400 / 2400 == pytest.approx(60, abs=6)
    assert abs(begun.mean() - ended.mean()) * 25400 / 2400 < 6


@pytest.mark.claim("Every edge on the page is where badge.json says")
def test_every_edge_on_the_page_is_where_the_badge_says(badge: Badge, drawn: Drawn) -> None:
    """Catches: points rounded to hundredths (3.5 um), y turned over, a page scaled or shifted.

    Tolerance: coordinates have six decimals of a point, and PDFium hands them over as float32: 0.02 um.
    """
    # The pitch bands are above the board (test_pitch_bands.py).
    black = [rect for rect, grey in drawn.fills if grey == 0 and rect[3] > badge.outline_mm[1]]
    half, (left, *_, low) = badge.markers.size_mm / 2, badge.markers.centers_mm
    # Letters are between the markers.
    lettered = left[0] + half, badge.markers.centers_mm[1][0] - half
    rows = [(y - half, y + half) for y in (left[1], low[1])]
    black = sorted(
        (x0, y0, x1, y1)
        for x0, y0, x1, y1 in black
        if not (lettered[0] < x0 and x1 < lettered[1] and any(top <= y0 and y1 <= end for top, end in rows))
    )
    expected: list[Rect] = []
    for cell in badge.gratings[0].cells:
        x0, y0, x1, y1 = cell.rect_mm
        lines = lines_by_hand(x0, x1, cell.pitch_mm, cell.edge_mm, cell.duty)
        expected += [(begin, y0, end, y1) for begin, end in lines]
    expected += [(x - half, y - half, x + half, y + half) for x, y in badge.markers.centers_mm]
    assert len(black) == len(expected)
    assert np.abs(np.array(black) - np.array(sorted(expected))).max() < 1e-4


# The page round the lines.


@pytest.mark.slow
@pytest.mark.parametrize("form", ["dots", "vector"])
def test_a_large_board_is_painted_whole_where_its_dots_are_fine(form: str, tmp_path: Path) -> None:
    """Catches: all lines as one path, of which PDFium leaves out what is at the right from 1200 dpi on."""
    made = design_badge(Order("Al", size_mm=(180.0, 230.0), range_m=(0.8, 2.5), form=form), PAYLOAD)
    page.write_badge_pdf(made, tmp_path / "badge.pdf")
    x0, y0, x1, y1 = (round(v / 25.4 * 1200) for v in made.gratings[0].rect_mm)
    dark = raster(tmp_path / "badge.pdf", 1200)[y0 + 50 : y1 - 50 : 97, x0:x1] < 128
    assert min(part.mean() for part in np.array_split(dark, 12, axis=1)) > 0.4


@pytest.mark.claim("The page is true to scale and asks not to be scaled")
def test_page_has_its_true_size_and_asks_not_to_be_scaled(badge: Badge, pdf: Path) -> None:
    """Catches: inches, a viewer that is free to fit to page, a TrimBox with y turned over or not there."""
    document = pdfium.PdfDocument(pdf)
    assert len(document) == 1
    sheet = document[0]
    assert sheet.get_size() == pytest.approx((210 * PT_PER_MM, 297 * PT_PER_MM), abs=1e-3)
    x0, y0, x1, y1 = badge.outline_mm
    trim = (x0 * PT_PER_MM, (297 - y1) * PT_PER_MM, x1 * PT_PER_MM, (297 - y0) * PT_PER_MM)
    assert sheet.get_trimbox() == pytest.approx(trim, abs=1e-3)
    document.close()
    content = pdf.read_bytes()
    assert b"/PrintScaling /None" in content
    assert b"/UserUnit" not in content


def test_the_same_badge_gives_the_same_bytes_and_carries_its_fonts(badge: Badge, pdf: Path, tmp_path: Path) -> None:
    """Catches: the clock or chance in a file, and fonts that the print shop lacks."""
    page.write_badge_pdf(badge, tmp_path / "again.pdf")
    assert (tmp_path / "again.pdf").read_bytes() == pdf.read_bytes()
    content = pdf.read_bytes()
    # Of what is printed next to the scale bars; name and identity are outlines.
    assert content.count(b"/FontFile2") == content.count(b"/Type /FontDescriptor") == 1
    assert b"/BaseFont /Helvetica" not in content


def test_black_of_artwork_is_written_as_grey(tmp_path: Path) -> None:
    """Catches: black words as mixed colours, which printers set from three inks next to each other."""
    sheet = PdfPage(tmp_path / "p.pdf", (100.0, 100.0), "page")
    sheet.fill([(10.0, 10.0, 20.0, 20.0)], colour=(0.0, 0.0, 0.0))
    sheet.fill([(30.0, 10.0, 40.0, 20.0)], colour=(1.0, 0.0, 0.0))
    fills = [line for line in "\n".join(sheet.canvas._code).split("\n") if line.endswith((" g", " rg"))]
    assert fills == ["0 g", "1 0 0 rg"]


def test_markers_are_read_on_the_page_where_the_badge_says(badge: Badge, pdf: Path) -> None:
    """Catches: ids or corners exchanged, modules mirrored, a marker without white around it."""
    dpi = 300.0
    found = found_markers(raster(pdf, dpi), badge.markers.dictionary)
    assert sorted(found) == sorted(badge.markers.ids)
    for identity, centre in zip(badge.markers.ids, badge.markers.centers_mm, strict=True):
        assert found[identity] * 25.4 / dpi == pytest.approx(centre, abs=0.06)


def test_two_scale_bars_of_150_mm_lie_on_every_page_that_can_be_designed(board: Badge, tmp_path: Path) -> None:
    """Catches: bars pushed off the paper by a large board, so that no one can see that the printer scaled it."""
    page.write_badge_pdf(board, tmp_path / "badge.pdf")
    strokes = geometry(tmp_path / "badge.pdf").strokes
    lengths = [(abs(bx - ax), abs(by - ay)) for ax, ay, bx, by in strokes]
    assert sum(w == pytest.approx(150.0, abs=1e-3) and h == pytest.approx(0, abs=1e-3) for w, h in lengths) == 1
    assert sum(h == pytest.approx(150.0, abs=1e-3) and w == pytest.approx(0, abs=1e-3) for w, h in lengths) == 1
    # Nothing but lines, markers and words lies on the board.
    x0, y0, x1, y1 = board.outline_mm
    for ax, ay, bx, by in strokes:
        assert max(ax, bx) <= x0 or min(ax, bx) >= x1 or max(ay, by) <= y0 or min(ay, by) >= y1
    with pdfium.PdfDocument(tmp_path / "badge.pdf") as document:
        assert "must measure 150 mm" in document[0].get_textpage().get_text_bounded()


# The assembly sheet and the preview.


@pytest.fixture(scope="module")
def picture(badge: Badge) -> np.ndarray:
    return np.array(preview.draw_preview(badge))


def preview_row(badge: Badge, picture: np.ndarray, cell: Cell) -> tuple[np.ndarray, np.ndarray]:
    """Places from the grating's middle, mm, and brightness along the middle of a cell."""
    left, top = badge.outline_mm[:2]
    x0, y0, x1, y1 = cell.rect_mm
    row = picture[int(((y0 + y1) / 2 - top) * 6), round((x0 - left) * 6) : round((x1 - left) * 6)].astype(float)
    middle = (badge.gratings[0].rect_mm[0] + badge.gratings[0].rect_mm[2]) / 2
    return x0 + (np.arange(row.size) + 0.5) / 6 - middle, row


def beat_in_the_middle(badge: Badge, cell: Cell) -> float:
    """Signed beat of a cell from 1.65 m, the middle of its range, by the traced gap of the prototype's sheet."""
    assert badge.range_m == (0.8, 2.5)
    return (1 + 0.60 / 1650) / cell.pitch_mm - 1 / badge.lens.pitch_mm


def test_preview_shows_every_cells_shift_against_the_reference_row(badge: Badge, picture: np.ndarray) -> None:
    """Catches: shifted lines drawn unshifted, by the wrong sign, or about the wrong middle.

    A line shift of s moves the fringe's phase by -2 pi s / p, so the cell shows what the reference row shows where
    its phase is that: s / (p f) away along the row.
    """
    grating = badge.gratings[0]
    assert grating.code is not None
    reference = grating.cells[grating.code.reference_cell]
    place, row = preview_row(badge, picture, reference)
    beat = beat_in_the_middle(badge, reference)
    seen = set()
    for cell, role in zip(grating.cells, grating.code.roles, strict=True):
        if role != "phase":
            continue
        turns = (cell.edge_mm - reference.edge_mm) / cell.pitch_mm
        where, shown = preview_row(badge, picture, cell)
        moved = where - turns / beat
        moved -= round(moved.mean() * abs(beat)) / abs(beat)
        seen.add(round(4 * turns) % 4)
        assert np.abs(shown - np.interp(moved, place, row)).mean() < 25
    assert seen == {0, 1, 2, 3}
