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

from kit.drawn import geometry
from moireid.badge import Badge
from moireid.cli.printing.print_options import mount_figure
from moireid.designer import Order, design_badge
from moireid.fabrication.assembly.assembly_words import BuildPlan
from moireid.fabrication.assembly.guide import pieces, write_assembly_pdf
from moireid.fabrication.assembly.sketches import LEANING_DEG, PX_PER_MM, WIDER, fringe_pictures
from moireid.fabrication.mount_parts import plan_parts, shape_parts
from moireid.fabrication.process_figures import mount_figures

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
    build = BuildPlan(badge, parts, maker)  # type: ignore[arg-type]
    write_assembly_pdf(build, path, shape_parts(badge, parts).drawn)
    return text_of(path)


def beat_and_lean(badge: Badge, **look: float) -> tuple[float, float]:
    """Fringes to the mm across, and their lean in degrees, of plain lines under the sheet, by Fourier transform."""
    grating = badge.gratings[0]
    assert grating.code
    cell = grating.cells[grating.code.reference_cell]
    plain = replace(badge, gratings=(replace(grating, cells=(replace(cell, rect_mm=grating.rect_mm),), code=None),))
    seen = np.asarray(fringe_pictures(plain, **look)[0], dtype=float)
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
    assert sorted(map(tuple, np.round(cut, 2))) == sorted(tuple(np.round(size, 2)) for _, size in found)
    assert ("cut 3" in assembly_words) == (axes == "hex") and "must measure 100 mm" in assembly_words
    # The sheet hides the outline it lies on: eight ticks a piece are beyond it, and cross none.
    ticks = [
        stroke
        for stroke in geometry(tmp_path / "a.pdf", 2).strokes
        if 3.9 < np.abs(np.subtract(*np.split(np.array(stroke), 2))).sum() < 4.1
    ]
    assert len(ticks) == 8 * len(found)
    if axes == "x":
        _, y0, _, y1 = badge.gratings[0].rect_mm
        assert found[0][1] == pytest.approx((146.0, y1 - y0))
    if axes == "xy":
        # The second piece's lenses lie level on the badge, so it is cut a quarter turn from how it lies.
        assert found[1][1][0] > found[0][1][0] > 72


@pytest.mark.parametrize(
    ("wish", "mount"),
    [
        (Order("A", format="a6"), "none"),
        (Order("A", lens="50lpi", axes="hex", range_m=(0.8, 1.5), paper="letter"), "clip"),
        (Order("A", lens="50lpi", front="mask", lens_thickness_mm=2.0, paper="letter"), "stand"),
    ],
)
def test_parts_and_steps_are_a_page_each(wish: Order, mount: str, tmp_path: Path) -> None:
    """Catches: lists or steps that run off their page, or a third page of them."""
    badge = design_badge(wish, bytes(8))
    parts = plan_parts(badge, mount, mount_figures({"adhesive_mm": 0.05} if mount == "clip" else {}))
    build = BuildPlan(badge, parts, "command")
    write_assembly_pdf(build, tmp_path / "a.pdf", shape_parts(badge, parts).drawn)
    document = pdfium.PdfDocument(tmp_path / "a.pdf")
    texts = [page.get_textpage() for page in document]
    assert len(texts) == (2 if badge.lens.kind == "mask" else 3)
    found = [text.get_text_range() for text in texts[:2]]
    # A sheet with ribs: film, dust, curl and the wrong side up spoil a badge.
    words = ("fingernail", "film", "dust", "curled", "upside down")
    assert badge.lens.kind == "mask" or all(word in " ".join(found[1].split()) for word in words)
    assert "Print settings" in found[0] and found[1].startswith("Step by step") and "Film it and check" in found[1]
    for page, text in zip(document, texts[:2], strict=False):
        boxes = [text.get_charbox(k) for k in range(text.count_chars())]
        assert min(box[1] for box in boxes if box[3] > box[1]) > 8 * PT_PER_MM
        assert max(box[2] for box in boxes) < page.get_width() - 8 * PT_PER_MM
    document.close()


@pytest.mark.slow
def test_the_studio_s_sheet_has_no_command_in_it(badge: Badge, tmp_path: Path) -> None:
    """Catches: options and commands for somebody who has a page in a browser; tape where a tray holds the sheet."""
    for kind in ("lanyard", "clip", "stand", "none"):
        whole = " ".join(written(badge, tmp_path / f"{kind}.pdf", kind, "studio"))
        assert "--" not in whole and "moireid verify" not in whole and "pitch-test" not in whole
        assert "open Enroll in the studio" in whole and ("clear tape" in whole) == (kind == "none")
