"""The assembly sheet's words, pictures and plate.  Each test names the wrong sheet it catches."""

from __future__ import annotations

import ctypes
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pypdfium2.raw as raw
import pytest

from moireid.badge import Badge
from moireid.cli.printing.print_options import mount_figure
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS
from moireid.fabrication.assembly import assembly_words
from moireid.fabrication.assembly.assembly_words import BuildPlan
from moireid.fabrication.assembly.guide import SheetPiece, _draw_steps, pieces, placed, write_assembly_pdf
from moireid.fabrication.assembly.sketches import LEANING_DEG, NARROWER, PX_PER_MM, WIDER, fringe_picture
from moireid.fabrication.mount_parts import plan_parts, shape_parts
from moireid.fabrication.page.canvas import PdfPage
from moireid.fabrication.printed.mount import plan_mount
from moireid.fabrication.process_figures import MountFigures, mount_figures

PT_PER_MM = 72 / 25.4


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Order("Ada Lovelace", lens="50lpi"), bytes(range(8)))


def text_of(path: Path) -> list[str]:
    document = pdfium.PdfDocument(path)
    found = [" ".join(page.get_textpage().get_text_range().split()) for page in document]
    document.close()
    return found


def written(badge: Badge, path: Path, mount: str = "lanyard", maker: str = "command", *pairs: str) -> list[str]:
    parts = replace(plan_parts(badge, mount, mount_figures(dict(map(mount_figure, pairs)))), acrylic=None)
    build = BuildPlan(badge, mount, None, parts.figures, maker, parts.mount_plan)  # type: ignore[arg-type]
    write_assembly_pdf(build, path, shape_parts(badge, parts).drawn)
    return text_of(path)


def test_the_studio_s_sheet_has_no_command_in_it(badge: Badge, tmp_path: Path) -> None:
    """Catches: options and commands for somebody who has a page in a browser."""
    for kind in ("lanyard", "clip", "stand", "holder", "none"):
        whole = " ".join(written(badge, tmp_path / f"{kind}.pdf", kind, "studio"))
        assert "--" not in whole and "moireid verify" not in whole and "pitch-test" not in whole
        assert "open Enroll in the studio" in whole


@pytest.mark.parametrize("paper", ["a4", "letter"])
@pytest.mark.parametrize("name", ["A" * 200, "محمد بن سلمان", "W W " * 40])
def test_no_word_leaves_the_page_or_lies_on_another(name: str, paper: str, tmp_path: Path) -> None:
    """Catches: a step more than the page holds, a long name off its edge, lines over each other."""
    badge = design_badge(Order(name.strip(), lens="50lpi", axes="xy", paper=paper), bytes(8))
    written(badge, tmp_path / "a.pdf", "stand", "studio")
    document = pdfium.PdfDocument(tmp_path / "a.pdf")
    for number in (0, 1):
        page = document[number]
        text = page.get_textpage()
        boxes = [np.array(text.get_rect(k)) / PT_PER_MM for k in range(text.count_rects())]
        width, _ = (side / PT_PER_MM for side in page.get_size())
        assert min(b[0] for b in boxes) > 15 and max(b[2] for b in boxes) < width - 12 and min(b[1] for b in boxes) > 6
        for k, one in enumerate(boxes):
            for other in boxes[:k]:
                wide = min(one[2], other[2]) - max(one[0], other[0])
                tall = min(one[3], other[3]) - max(one[1], other[1])
                assert wide < 0.2 or tall < 0.4, (number, one, other)
    document.close()


def beat_and_lean(badge: Badge, **look: float) -> tuple[float, float]:
    """Fringes to the mm across, and their lean in degrees, of plain lines under the sheet, by Fourier transform."""
    grating = badge.gratings[0]
    assert grating.code
    cell = grating.cells[grating.code.reference_cell]
    plain = replace(badge, gratings=(replace(grating, cells=(replace(cell, rect_mm=grating.rect_mm),), code=None),))
    seen = np.asarray(fringe_picture(plain, **look), dtype=float)
    spectrum = np.abs(
        np.fft.fft2((seen - seen.mean()) * np.outer(np.hanning(seen.shape[0]), np.hanning(seen.shape[1])), (2048, 2048))
    )
    up, across = np.unravel_index(int(np.argmax(spectrum[:, :1024])), (2048, 1024))
    down = np.fft.fftfreq(2048)[up]
    return float(across) / 2048 * PX_PER_MM, math.degrees(math.atan2(abs(down), across / 2048))


def test_pictures_show_what_the_law_says(badge: Badge) -> None:
    """Catches: pictures that are painted by hand: fringes of another number, that lean too little or not at all."""
    grating = badge.gratings[0]
    assert grating.code
    cell = grating.cells[grating.code.reference_cell]
    beat = abs(1 / cell.pitch_mm - 1 / badge.lens.pitch_mm)
    good, lean = beat_and_lean(badge)
    assert good == pytest.approx(beat, abs=0.003) and lean < 1.0
    turned, lean = beat_and_lean(badge, turned_deg=LEANING_DEG)
    across = 1 / badge.lens.pitch_mm * math.sin(math.radians(LEANING_DEG))
    assert turned == pytest.approx(beat, abs=0.003) and lean == pytest.approx(
        math.degrees(math.atan(across / beat)), abs=2
    )
    assert beat_and_lean(badge, beats=NARROWER)[0] == pytest.approx(NARROWER * beat, rel=0.15)
    assert beat_and_lean(badge, beats=WIDER)[0] == pytest.approx(WIDER * beat, rel=0.25)


def dashed_mm(path: Path, number: int) -> list[np.ndarray]:
    """Closed loops of four corners that are not filled, mm: what is cut."""
    document = pdfium.PdfDocument(path)
    x, y, found = ctypes.c_float(), ctypes.c_float(), []
    for thing in document[number].get_objects(filter=[raw.FPDF_PAGEOBJ_PATH]):
        mode, stroked = ctypes.c_int(), ctypes.c_int()
        raw.FPDFPath_GetDrawMode(thing.raw, mode, stroked)
        loop = []
        for k in range(raw.FPDFPath_CountSegments(thing.raw)):
            raw.FPDFPathSegment_GetPoint(raw.FPDFPath_GetPathSegment(thing.raw, k), x, y)
            loop.append((x.value / PT_PER_MM, y.value / PT_PER_MM))
        if mode.value == 0 and len(loop) >= 4:
            found.append(np.array(loop[:4]))
    document.close()
    return found


@pytest.mark.parametrize("axes", ["x", "xy", "hex"])
def test_the_plate_is_of_true_size_and_its_lenses_are_upright(axes: str, tmp_path: Path) -> None:
    """Catches: a plate fitted to the page, width and length exchanged, a piece that is missing or turned."""
    badge = design_badge(Order("A", lens="50lpi", axes=axes, range_m=(0.8, 1.5)), bytes(8))
    assembly_words = written(badge, tmp_path / "a.pdf", "none")[2]
    cut = [np.ptp(loop, axis=0) for loop in dashed_mm(tmp_path / "a.pdf", 2)]
    found = pieces(badge)
    assert sorted(map(tuple, np.round(cut, 2))) == sorted(tuple(np.round(piece.size_mm, 2)) for piece in found)
    assert ("cut 3" in assembly_words) == (axes == "hex") and "must measure 100 mm" in assembly_words
    if axes == "x":
        _, y0, _, y1 = badge.gratings[0].rect_mm
        assert found[0].size_mm == pytest.approx((146.0, y1 - y0))
    if axes == "xy":
        # The second piece's lenses lie level on the badge, so it is cut a quarter turn from how it lies.
        assert found[1].size_mm[0] > found[0].size_mm[0] > 72


def test_any_rectangle_is_drawn_upright_and_pages_follow() -> None:
    """Catches: a turned piece drawn askew or mirrored; pieces over each other or off the room."""
    cos, sin = math.cos(0.7), math.sin(0.7)
    corners = tuple((5 + x * cos - y * sin, 9 + x * sin + y * cos) for x, y in ((0, 0), (40, 0), (40, 25), (0, 25)))
    piece = SheetPiece("p", corners)
    assert np.allclose(piece.upright, [(0, 0), (40, 0), (40, 25), (0, 25)]) and piece.size_mm == pytest.approx((40, 25))
    pages = placed([piece] * 20, (10.0, 10.0, 180.0, 200.0))
    assert len(pages) == 2 and sum(map(len, pages)) == 20
    for page in pages:
        spots = [corner for _, corner in page]
        assert len(set(spots)) == len(spots) and all(x + 40 <= 180 and y + 25 <= 200 for x, y in spots)


@pytest.mark.parametrize("paper", ["a4", "letter"])
@pytest.mark.parametrize("form", FORMATS)
def test_every_piece_lies_whole_on_its_page(form: str, paper: str, tmp_path: Path) -> None:
    """Catches: a piece as wide as the paper, whose cutting line runs off it; landscape paper said to be upright."""
    badge = design_badge(Order("A", paper=paper, format=form, orientation="landscape"), bytes(8))
    texts = written(badge, tmp_path / "a.pdf", "none")
    document = pdfium.PdfDocument(tmp_path / "a.pdf")
    page = next(document[k] for k, text in enumerate(texts) if "in true size" in text)
    picture = page.render(scale=2, grayscale=True).to_numpy().squeeze()
    document.close()
    for edge in (picture[:, :8], picture[:, -8:], picture[:8], picture[-8:]):
        assert edge.min() > 200
    way = "lying" if badge.page_mm[0] > badge.page_mm[1] else "upright"
    assert f", {way} (" in texts[0]


@pytest.mark.parametrize("count", [8, 10])
def test_no_step_runs_into_the_next(count: int) -> None:
    """Catches: words that reach down to the next heading where there are many steps."""
    badge = design_badge(Order("A", lens="50lpi", axes="hex"), bytes(8))
    figures = MountFigures()
    mount, plan = ("holder", plan_mount(badge, "holder", figures.printed)) if count == 10 else ("none", None)
    build = BuildPlan(badge, mount, None, figures, "command", plan)
    steps = assembly_words.steps(build)
    drawn: list[tuple[float, float]] = []
    sheet = PdfPage(Path("unwritten.pdf"), (210.0, 297.0), "")
    write = sheet.text
    sheet.text = lambda x, y, *args, **kwargs: (drawn.append((y, kwargs["points"])), write(x, y, *args, **kwargs))[1]  # type: ignore[method-assign]
    _draw_steps(sheet, steps)
    titles = [y for y, points in drawn if points == 10.5]
    assert len(titles) == len(steps) == count
    for title in titles[1:]:
        assert title - max(y for y, points in drawn if points == 9.0 and y < title) > 5.0
    assert max(y for y, _ in drawn) < 290.0
