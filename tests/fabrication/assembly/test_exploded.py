"""The exploded views of assembly.pdf, read off the page.  Each test names the wrong drawing it catches."""

from __future__ import annotations

import ctypes
import itertools
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pypdfium2.raw as raw
import pytest

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.assembly.exploded import plain_parts
from moireid.fabrication.assembly.guide import write_assembly_pdf
from moireid.fabrication.assembly.mount_views import acrylic_parts, printed_parts
from moireid.fabrication.package import Parts, plan_parts
from moireid.fabrication.printed.mount import plan_mount
from moireid.fabrication.process_figures import AcrylicProcess, MountFigures, MountProcess

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")
PT_PER_MM = 72 / 25.4


@pytest.fixture(scope="module")
def lens() -> Badge:
    return design_badge(Request("Ada"), PAYLOAD)


@pytest.fixture(scope="module")
def mask() -> Badge:
    return design_badge(Request("Ada", front="mask", gap_mm=2.0), PAYLOAD)


def write(badge: Badge, mount: str, path: Path, figures: MountFigures | None = None) -> Parts:
    parts = plan_parts(badge, mount, figures)
    write_assembly_pdf(badge, path, mount=parts.printed, acrylic=parts.acrylic, figures=parts.figures)
    return parts


def pages(path: Path) -> list[str]:
    document = pdfium.PdfDocument(path)
    words = [page.get_textpage().get_text_range() for page in document]
    document.close()
    return words


def paths(path: Path, number: int) -> list[list[np.ndarray]]:
    """Every path of a page as loops of points, mm, y up."""
    document = pdfium.PdfDocument(path)
    x, y, found = ctypes.c_float(), ctypes.c_float(), []
    for thing in document[number].get_objects(filter=[raw.FPDF_PAGEOBJ_PATH]):
        loops: list[list[tuple[float, float]]] = []
        for k in range(raw.FPDFPath_CountSegments(thing.raw)):
            segment = raw.FPDFPath_GetPathSegment(thing.raw, k)
            raw.FPDFPathSegment_GetPoint(segment, x, y)
            if raw.FPDFPathSegment_GetType(segment) == raw.FPDF_SEGMENT_MOVETO:
                loops.append([])
            loops[-1].append((x.value / PT_PER_MM, y.value / PT_PER_MM))
        found.append([np.array(loop) for loop in loops])
    document.close()
    return found


def seen(x: float, y: float, z: float = 0.0) -> np.ndarray:
    """Where the stated view puts a place: turned by 30 degrees, seen from 32 above, at life size."""
    turn, rise = math.radians(30), math.radians(32)
    away = x * math.sin(turn) + y * math.cos(turn)
    return np.array([x * math.cos(turn) - y * math.sin(turn), away * math.sin(rise) + z * math.cos(rise)])


def test_views_name_what_is_made_and_nothing_else(lens: Badge, mask: Badge, tmp_path: Path) -> None:
    """Catches: a mask shown as a lens sheet, a stand for a lanyard, parts of a mount that was not ordered, a thickness
    of another badge."""
    write(lens, "lanyard", tmp_path / "a.pdf")
    *_, printed, acrylic = pages(tmp_path / "a.pdf")
    for words in (printed, acrylic):
        assert "lens sheet\r\n1 mm" in words and "printed card\r\n0.3 mm" in words
        assert "mask" not in words and "spacer" not in words
    assert "tray, 3D-printed" in printed and "acrylic cover" not in printed
    assert "stand" not in printed and "clip" not in printed
    assert "acrylic base\r\n3 mm" in acrylic and "acrylic frame\r\n1 mm" in acrylic and "tray" not in acrylic
    assert "6 nuts" in acrylic and "6 screws\r\nM3 × 10" in acrylic
    write(mask, "stand", tmp_path / "b.pdf")
    *_, printed, acrylic = pages(tmp_path / "b.pdf")
    for words in (printed, acrylic):
        assert "clear spacer\r\n2 mm" in words and "mask film\r\n0.1 mm" in words and "lens" not in words
    assert "stand, 3D-printed" in printed and "stand" not in acrylic
    write(lens, "none", tmp_path / "c.pdf")
    *_, plain = pages(tmp_path / "c.pdf")
    assert "printed card" in plain and "lens sheet" in plain
    assert not any(word in plain for word in ("tray", "acrylic", "screws", "stand", "mount"))


def test_parts_are_those_of_the_plans(lens: Badge, mask: Badge) -> None:
    """Catches: a forgotten part, an order that cannot be put together, figures of the defaults for somebody's own."""
    process = MountProcess(card_mm=0.5, back_mm=2.0)
    assert [part.name for part in plain_parts(mask, process)] == ["printed card", "clear spacer", "mask film"]
    names = [part.name.split(",")[0] for part in printed_parts(mask, plan_mount(mask, "clip", process), process)]
    assert names == ["clip", "tray", "printed card", "clear spacer", "mask film"]
    tray, card, sheet = printed_parts(lens, plan_mount(lens, "lanyard", process), process)
    heights = [[z for _, _, z in part.places] for part in (tray, card, sheet)]
    assert min(heights[0]) == -2.0 and (min(heights[1]), max(heights[1])) == (0.0, 0.5)
    assert (min(heights[2]), max(heights[2])) == (0.5, 0.5 + lens.lens.thickness_mm)
    plan = plan_parts(lens, "lanyard").acrylic
    assert plan
    stack = acrylic_parts(lens, plan, AcrylicProcess().film_mm, "M3 × 10")
    assert [part.name for part in stack] == [
        "6 nuts",
        "acrylic base",
        "acrylic frame",
        "printed card",
        "lens sheet",
        "acrylic cover",
        "6 screws",
    ]
    assert len(stack[0].prisms) == 6 and len(stack[2].prisms[0].openings) == 1 + len(stack[1].prisms[0].openings)
    with pytest.raises(FabricationError, match="slot"):
        plan_mount(lens, "clip", MountProcess(slot_mm=(16.0, 2.0)))


@pytest.mark.parametrize("size", [(146.0, 160.0), (120.0, 200.0)])
def test_outlines_have_the_plans_proportions(size: tuple[float, float], tmp_path: Path) -> None:
    """Catches: a view of a standard badge, one stretched to the page, mirrored, or with thicknesses not to scale."""
    badge = design_badge(Request("Ada", size_mm=size, range_m=(0.8, 2.0)), PAYLOAD)
    figures = MountFigures(acrylic=AcrylicProcess(base_mm=8.0))
    plan = write(badge, "lanyard", tmp_path / "a.pdf", figures).acrylic
    assert plan
    last = len(pages(tmp_path / "a.pdf")) - 1
    drawn = paths(tmp_path / "a.pdf", last)
    # The frame's window and the card are parallelograms of the board, the window larger by the air round it.
    window = next(loops[1] for loops in drawn if len(loops) == len(plan.frame.openings) + 1 and len(loops[1]) == 5)
    reach = [size[k] + 2 * plan.clearance_mm for k in (0, 1)]
    across, up = window[1] - window[0], window[2] - window[1]
    scale = np.linalg.norm(across) / np.linalg.norm(seen(reach[0], 0))
    words = pages(tmp_path / "a.pdf")[last]
    assert f"{scale:.2f} of life size" in words
    assert across == pytest.approx(scale * seen(reach[0], 0), abs=0.01)
    assert up == pytest.approx(scale * seen(0, reach[1]), abs=0.01)
    cards = [loops[0] for loops in drawn if len(loops) == 1 and len(loops[0]) == 5]
    edges = scale * seen(size[0], 0), scale * seen(0, size[1])
    assert any(np.allclose([c[1] - c[0], c[2] - c[1]], edges, atol=0.01) for c in cards)
    # A wall of the base plate is as high as the plate is thick, and the highest one of all that are drawn along x.
    walls = [c[3] - c[0] for c in cards if abs((c[3] - c[0])[0]) < 1e-3 and np.linalg.norm(c[1] - c[0]) > 30]
    assert max(wall[1] for wall in walls) == pytest.approx(scale * seen(0, 0, 8.0)[1], abs=0.01)


@pytest.mark.parametrize("mount", ["none", "lanyard", "clip", "stand", "holder"])
@pytest.mark.parametrize("paper", ["a4", "letter"])
def test_nothing_leaves_the_page_or_meets_a_label(mount: str, paper: str, tmp_path: Path) -> None:
    """Catches: a part or label off the paper, labels over each other or over the drawing, a font not carried."""
    badge = design_badge(Request("Ada", paper=paper, axes="xy"), PAYLOAD)
    write(badge, mount, tmp_path / "a.pdf")
    document = pdfium.PdfDocument(tmp_path / "a.pdf")
    # List, steps and plate come before.
    for number in range(3, len(document)):
        width, height = (v / PT_PER_MM for v in document[number].get_size())
        points = np.concatenate([loop for loops in paths(tmp_path / "a.pdf", number) for loop in loops])
        assert points.min() > 20 and points[:, 0].max() < width - 20 and points[:, 1].max() < height - 40
        text = document[number].get_textpage()
        boxes = [np.array(text.get_rect(k)) / PT_PER_MM for k in range(text.count_rects())]
        assert max(box[2] for box in boxes) < width - 15
        labels = sorted((box for box in boxes if box[1] < height - 40), key=lambda box: box[1])
        assert len(labels) >= 4
        for low, high in itertools.pairwise(labels):
            assert low[3] <= high[1] + 0.2
        assert points[:, 0].max() < min(label[0] for label in labels)
    document.close()
    assert b"Helvetica" not in (tmp_path / "a.pdf").read_bytes()


def test_same_bytes_again_and_no_cad_kernel(lens: Badge, tmp_path: Path) -> None:
    """Catches: a date or an order of sets in the file; a view that loads the CAD packages, which takes seconds."""
    write(lens, "stand", tmp_path / "a.pdf")
    write(lens, "stand", tmp_path / "b.pdf")
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()
    code = (
        "import sys, pathlib; from moireid.designer import Request, design_badge\n"
        "from moireid.fabrication.assembly.guide import write_assembly_pdf\n"
        f"badge = design_badge(Request('Ada'), bytes.fromhex('{PAYLOAD.hex()}'))\n"
        f"write_assembly_pdf(badge, pathlib.Path({str(tmp_path / 'c.pdf')!r}), mount='stand')\n"
        "print([name for name in ('OCP', 'build123d', 'cadquery', 'manifold3d', 'trimesh') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
