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
import pypdfium2.raw as raw
import pytest

from kit.drawn import PT_PER_MM, Drawn, geometry
from moireid.badge import Badge, Cell, Grating, Rect
from moireid.designer import Request, design_badge
from moireid.fabrication.page import pdf as page
from moireid.fabrication.page import preview
from moireid.fabrication.page.pdf import crop_marks, dark_lines

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
    return design_badge(Request("Ada Lovelace", form="vector", pattern="cells"), PAYLOAD)


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
    return design_badge(Request("Al", paper=paper, size_mm=size, range_m=(0.39, 0.4)), PAYLOAD)


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


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(
    ("pitch", "edge", "duty"),
    [
        (0.7, 13.3, 0.4),
        (0.52, 10.0, 0.5),
        (0.7, -987.15, 0.9),
        (0.61, 5000.02, 0.1),
        (40.0, 12.5, 0.2),
        (3.0, 9.1, 0.5),
    ],
)
def test_lines_lie_where_the_contract_says(axis: str, pitch: float, edge: float, duty: float) -> None:
    """Catches: a pitch added up and so drifting, the cut lines at either border lost or left whole, axes swapped."""
    cell = Cell((10.0, 20.0, 33.7, 24.5) if axis == "x" else (20.0, 10.0, 24.5, 33.7), pitch, edge, duty)
    lines = dark_lines(Grating(cell.rect_mm, axis, pitch, "uniform", (cell,)), cell)  # type: ignore[arg-type]
    low, high = (0, 2) if axis == "x" else (1, 3)
    expected = lines_by_hand(10.0, 33.7, pitch, edge, duty)
    assert [(line[low], line[high]) for line in lines] == [pytest.approx(pair, abs=1e-9) for pair in expected]
    assert {(line[1 - low], line[5 - high]) for line in lines} == {(20.0, 24.5)}


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
    black = sorted(rect for rect, grey in drawn.fills if grey == 0)
    expected: list[Rect] = []
    for cell in badge.gratings[0].cells:
        x0, y0, x1, y1 = cell.rect_mm
        lines = lines_by_hand(x0, x1, cell.pitch_mm, cell.edge_mm, cell.duty)
        expected += [(begin, y0, end, y1) for begin, end in lines]
    half = badge.markers.size_mm / 2
    expected += [(x - half, y - half, x + half, y + half) for x, y in badge.markers.centers_mm]
    assert len(black) == len(expected)
    assert np.abs(np.array(black) - np.array(sorted(expected))).max() < 1e-4


@pytest.mark.slow
def test_rasterised_bands_have_their_pitch_and_their_dark_line_in_the_middle(badge: Badge, pdf: Path) -> None:
    """Catches: all that the geometry above shares with the writer: units, seams, white painted over lines.

    Fourier phase of each band along x, over whole periods, against the line positions of the badge: 0.05 rad are 4 um.
    """
    picture = raster(pdf, 1200.0)
    # PDFium stretches the page to whole pixels, 9922 in place of 9921.3.
    px_per_mm = picture.shape[1] / badge.page_mm[0]
    for cell in badge.gratings[0].cells:
        x0, y0, x1, y1 = (v * px_per_mm for v in cell.rect_mm)
        row = 255.0 - picture[int((y0 + y1) / 2), round(x0) : round(x1)]
        place = (np.arange(row.size) + 0.5 + round(x0)) / px_per_mm
        window = np.hanning(row.size)
        frequencies = 1 / cell.pitch_mm + np.linspace(-0.004, 0.004, 801)
        power = np.abs((row * window) @ np.exp(-2j * np.pi * place[:, None] * frequencies))
        assert 1 / frequencies[np.argmax(power)] == pytest.approx(cell.pitch_mm, rel=2e-5)
        middle_of_a_line = cell.edge_mm + cell.duty * cell.pitch_mm / 2
        turned = (row * window) @ np.exp(-2j * np.pi * (place - middle_of_a_line) / cell.pitch_mm)
        assert abs(np.angle(turned)) < 0.05
        assert row.mean() / 255 == pytest.approx(0.5, abs=0.06)


# The page round the lines.


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


def test_trim_box_of_a_board_off_the_middle_is_the_board(badge: Badge, tmp_path: Path) -> None:
    """Catches: top and bottom confused, which a board in the middle of its page hides."""
    off = replace(badge, board_mm=(32.0, 40.0, 178.0, 251.0))
    page.write_badge_pdf(off, tmp_path / "off.pdf")
    document = pdfium.PdfDocument(tmp_path / "off.pdf")
    trim = [v * PT_PER_MM for v in (32, 297 - 251, 178, 297 - 40)]
    assert document[0].get_trimbox() == pytest.approx(trim, abs=1e-3)
    document.close()


def test_the_same_badge_gives_the_same_bytes_and_carries_its_fonts(badge: Badge, pdf: Path, tmp_path: Path) -> None:
    """Catches: the clock or chance in a file, and fonts that the print shop lacks."""
    page.write_badge_pdf(badge, tmp_path / "again.pdf")
    assert (tmp_path / "again.pdf").read_bytes() == pdf.read_bytes()
    content = pdf.read_bytes()
    # Of the name, of the identity, and of what is printed next to the scale bars.
    assert content.count(b"/FontFile2") == content.count(b"/Type /FontDescriptor") == 3
    assert b"/BaseFont /Helvetica" not in content


def test_markers_are_read_on_the_page_where_the_badge_says(badge: Badge, pdf: Path) -> None:
    """Catches: ids or corners exchanged, modules mirrored, a marker without white around it."""
    dpi = 300.0
    found = found_markers(raster(pdf, dpi), badge.markers.dictionary)
    assert sorted(found) == sorted(badge.markers.ids)
    for identity, centre in zip(badge.markers.ids, badge.markers.centers_mm, strict=True):
        assert found[identity] * 25.4 / dpi == pytest.approx(centre, abs=0.06)


def test_crop_marks_point_at_the_boards_corners_from_outside(badge: Badge, drawn: Drawn) -> None:
    """Catches: marks within the board, or along the wrong edge."""
    x0, y0, x1, y1 = badge.outline_mm
    marks = crop_marks(badge.outline_mm)
    assert len(marks) == 8
    for ax, ay, bx, by in marks:
        level = ay == by and ay in (y0, y1) and not (x0 < ax < x1 or x0 < bx < x1)
        upright = ax == bx and ax in (x0, x1) and not (y0 < ay < y1 or y0 < by < y1)
        assert level or upright
    on_page = [sorted([stroke[:2], stroke[2:]]) for stroke in drawn.strokes]
    for mark in marks:
        ends = sorted([mark[:2], mark[2:]])
        assert any(np.abs(np.array(ends) - np.array(stroke)).max() < 1e-3 for stroke in on_page)


def test_two_scale_bars_of_150_mm_lie_on_every_page_that_can_be_designed(board: Badge, tmp_path: Path) -> None:
    """Catches: bars pushed off the paper by a large board, so that no one can see that the printer scaled it."""
    page.write_badge_pdf(board, tmp_path / "badge.pdf")
    strokes = geometry(tmp_path / "badge.pdf").strokes
    lengths = [(abs(bx - ax), abs(by - ay)) for ax, ay, bx, by in strokes]
    assert sum(w == pytest.approx(150.0, abs=1e-3) and h == pytest.approx(0, abs=1e-3) for w, h in lengths) == 1
    assert sum(h == pytest.approx(150.0, abs=1e-3) and w == pytest.approx(0, abs=1e-3) for w, h in lengths) == 1
    # Printers leave a rim of 3 to 5 mm white; 0.01 mm is float32's.
    x0, y0, x1, y1 = board.outline_mm
    for ax, ay, bx, by in strokes:
        assert min(ax, bx) > 2.99 and max(ax, bx) < board.page_mm[0] - 2.99
        assert min(ay, by) > 2.99 and max(ay, by) < board.page_mm[1] - 2.99
        # ... and nothing but lines, markers and words lies on the board.
        assert max(ax, bx) <= x0 or min(ax, bx) >= x1 or max(ay, by) <= y0 or min(ay, by) >= y1
    advice = [box for words, box in words_on(tmp_path / "badge.pdf") if "must measure 150 mm" in words]
    assert len(advice) == 1 and advice[0][1] > y1 and advice[0][3] < board.page_mm[1] - 2.8


def words_on(path: Path) -> list[tuple[str, Rect]]:
    """Each text object with its bounds, mm from the top left."""
    document = pdfium.PdfDocument(path)
    sheet = document[0]
    text, height = sheet.get_textpage(), sheet.get_height()
    found = []
    for thing in sheet.get_objects(filter=[raw.FPDF_PAGEOBJ_TEXT]):
        left, bottom, right, top = thing.get_bounds()
        words = text.get_text_bounded(left - 1, bottom - 1, right + 1, top + 1)
        box = (left, height - top, right, height - bottom)
        found.append((words.strip(), tuple(v / PT_PER_MM for v in box)))
    document.close()
    return found  # type: ignore[return-value]


@pytest.mark.parametrize("name", ["Ada Lovelace", "W" * 90, "i", "Владимир Ünlü", "a/b <&> \\(x)"])
def test_name_is_between_the_upper_markers_and_id_between_the_lower(badge: Badge, name: str, tmp_path: Path) -> None:
    """Catches: a long name that runs into the markers, letters that need escaping, name and id exchanged."""
    named = replace(badge, name=name)
    page.write_badge_pdf(named, tmp_path / "n.pdf")
    words = words_on(tmp_path / "n.pdf")
    (x0, y0), (x1, _), _, (_, y3) = badge.markers.centers_mm
    half = badge.markers.size_mm / 2
    for text, height in ((name, y0), (f"moireid {badge.id}", y3)):
        boxes = [box for found, box in words if box[3] < height + half and box[1] > height - half]
        said = "".join(found for found, box in words if box in boxes)
        # A word that is divided has a hyphen at the end of a row, which pdfium gives as a sign of its own.
        assert (said.translate({0x2D: None, 0xFFFE: None, 0x2: None}) if text == "W" * 90 else said) == text
        for left, top, right, bottom in boxes:
            # A marker wants one module of white, 4.3 mm.
            assert x0 + half + 2.5 < left and right < x1 - half - 2.5
            assert (left + right) / 2 == pytest.approx((x0 + x1) / 2, abs=1.5)
            assert height - half < top < bottom < height + half


# The assembly sheet and the preview.


@pytest.fixture(scope="module")
def picture(badge: Badge) -> np.ndarray:
    return np.array(preview.draw_preview(badge))


def test_preview_shows_the_markers_in_their_places(badge: Badge, picture: np.ndarray) -> None:
    """Catches: a preview of the page in place of the board, mirrored or scaled."""
    x0, y0, x1, y1 = badge.outline_mm
    assert picture.shape == (round((y1 - y0) * 6), round((x1 - x0) * 6))
    found = found_markers(picture, badge.markers.dictionary)
    for identity, centre in zip(badge.markers.ids, badge.markers.centers_mm, strict=True):
        assert found[identity] / 6 + (x0, y0) == pytest.approx(centre, abs=0.2)


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


@pytest.mark.parametrize("family", ["spacing", "pitch"])
def test_preview_shows_every_uniform_rows_beat_in_the_middle(family: str) -> None:
    """Catches: fringes of the far camera, a gap of g in place of g_eff, rows in another order.

    Two routes: rays through lenticules here, the closed form there; the dark fringe is in the middle.
    """
    payload = PAYLOAD if family == "spacing" else PAYLOAD[:3]
    badge = design_badge(Request("Ada", family=family), payload)
    picture = np.array(preview.draw_preview(badge))
    code = badge.gratings[0].code
    assert code is not None
    rows = [cell for cell, role in zip(badge.gratings[0].cells, code.roles, strict=True) if role != "phase"]
    assert len(rows) == (3 if family == "spacing" else 11)
    for cell in rows:
        place, row = preview_row(badge, picture, cell)
        beat, window = abs(beat_in_the_middle(badge, cell)), np.hanning(row.size)
        frequencies = beat + np.linspace(-0.01, 0.01, 401)
        power = np.abs(((row - row.mean()) * window) @ np.exp(-2j * np.pi * place[:, None] * frequencies))
        # The lens's curvature bends the far ends, and a fringe is a triangle: 0.3 cycles/m of some 60 are left.
        assert frequencies[np.argmax(power)] == pytest.approx(beat, abs=0.0004)
        middle = row[row.size // 2 - 3 : row.size // 2 + 3]
        assert middle.mean() < row.min() + 0.1 * (row.max() - row.min())


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


def test_preview_of_a_mask_lets_through_what_its_openings_do(badge: Badge, prototype: Badge) -> None:
    """Catches: a mask drawn as a lens, which would be twice as bright, or air traced with the index of plastic."""
    mask = replace(prototype.lens, kind="mask", refractive_index=1.0, radius_mm=None, open_fraction=None)
    drawn = np.array(preview.draw_preview(replace(prototype, lens=mask)), float)
    x0, y0, x1, y1 = (round(v * 6) for v in prototype.gratings[0].rect_mm)
    field = (drawn[y0:y1, x0:x1] - preview.INK) / (preview.PAPER - preview.INK)
    assert field.mean() == pytest.approx(0.25, abs=0.02)
    assert field.min() < 0.05 and field.max() == pytest.approx(0.5, abs=0.03)


# All files of one badge.
