"""The exploded views of assembly.pdf, read off the page.  Each test names the wrong drawing it catches."""

from __future__ import annotations

import ctypes
import itertools
import math
import re
from pathlib import Path

import manifold3d
import numpy as np
import pypdfium2 as pdfium
import pypdfium2.raw as raw
import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.assembly.assembly_words import BuildPlan
from moireid.fabrication.assembly.exploded import Part, plain_parts, prism
from moireid.fabrication.assembly.guide import _views, write_assembly_pdf
from moireid.fabrication.mount_parts import Parts, plan_parts, shape_parts
from moireid.fabrication.printed.mount import plan_mount
from moireid.fabrication.process_figures import AcrylicProcess, MountFigures, MountProcess

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")
PT_PER_MM = 72 / 25.4


@pytest.fixture(scope="module")
def lens() -> Badge:
    return design_badge(Order("Ada", lens="50lpi"), PAYLOAD)


@pytest.fixture(scope="module")
def mask() -> Badge:
    return design_badge(Order("Ada", lens="50lpi", front="mask", lens_thickness_mm=2.0), PAYLOAD)


def write(badge: Badge, mount: str, path: Path, figures: MountFigures | None = None) -> Parts:
    parts = plan_parts(badge, mount, figures)
    build = BuildPlan(badge, parts.printed, parts.acrylic, parts.figures, "command", parts.mount_plan)
    write_assembly_pdf(build, path, shape_parts(badge, parts).drawn)
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


def views(badge: Badge, mount: str, figures: MountFigures | None = None) -> list[list[Part]]:
    """The parts of each exploded view."""
    parts = plan_parts(badge, mount, figures)
    build = BuildPlan(badge, mount, parts.acrylic, parts.figures, "command", parts.mount_plan)
    return [found for _, found in _views(build, shape_parts(badge, parts).drawn)]


def test_parts_are_those_of_the_plans(lens: Badge, mask: Badge) -> None:
    """Catches: a forgotten part, an order that cannot be put together, figures of the defaults for somebody's own."""
    process = MountProcess(card_mm=0.5, back_mm=2.0)
    assert [part.name for part in plain_parts(mask, process)] == ["printed card", "clear spacer", "mask film"]
    names = [part.name.split(",")[0] for part in views(mask, "clip", MountFigures(process))[0]]
    assert names == ["clip", "tray", "printed card", "clear spacer", "mask film"]
    tray, card, sheet = views(lens, "lanyard", MountFigures(process))[0]
    assert tray.low == pytest.approx(-2.0) and (card.low, card.high) == (0.0, 0.5)
    assert (sheet.low, sheet.high) == (0.5, 0.5 + lens.lens.thickness_mm)
    stack = views(lens, "lanyard")[1]
    assert [part.name for part in stack] == [
        "6 nuts",
        "acrylic base",
        "acrylic frame",
        "3 layers of card",
        "printed card",
        "lens sheet",
        "lips of film",
        "acrylic cover",
        "6 screws",
    ]
    # Each screw, and the window and the holes through which the part behind is seen.
    assert len(stack[0].pieces) == len(stack[-1].pieces) == 6
    assert len(stack[2].pieces[0].outlines) == 1 + 1 + 6 + 2
    with pytest.raises(FabricationError, match="slot"):
        plan_mount(lens, "clip", MountProcess(slot_mm=(16.0, 2.0)))


def test_solids_are_drawn_from_where_the_view_says(lens: Badge) -> None:
    """Catches: a view that is mirrored, turned, or in perspective: the kernel draws a box as `prism` does."""
    from moireid.fabrication.assembly.solid_views import drawn_solids
    from moireid.fabrication.solid_parts import SolidPart, box

    rect = (-10.0, -20.0, 30.0, 5.0)
    drawn = drawn_solids([SolidPart("box", box(rect, 1.0, 4.0))])["box"]
    plain = prism(((-10.0, -20.0), (30.0, -20.0), (30.0, 5.0), (-10.0, 5.0)), 1.0, 4.0)
    for one, other in ((drawn, plain), (plain, drawn)):
        for corner in {corner for line in one.lines for corner in line}:
            assert min(math.dist(corner, place) for line in other.lines for place in line) < 1e-4
    silhouettes = [manifold3d.CrossSection([list(piece.outlines[0])]) for piece in (drawn, plain)]
    assert (silhouettes[0] ^ silhouettes[1]).area() == pytest.approx(silhouettes[0].area(), rel=1e-4)
    assert silhouettes[1].area() == pytest.approx(silhouettes[0].area(), rel=1e-4)
    # The highest corner of the picture is the far one, and the lowest is near, below.
    assert max((v for line in drawn.lines for _, v in line)) == pytest.approx(seen(30, 5, 4)[1], abs=1e-4)
    assert min((v for line in drawn.lines for _, v in line)) == pytest.approx(seen(-10, -20, 1)[1], abs=1e-4)


@pytest.mark.parametrize("size", [(146.0, 160.0), (120.0, 200.0)])
def test_outlines_have_the_plans_proportions(size: tuple[float, float], tmp_path: Path) -> None:
    """Catches: a view of a standard badge, one stretched to the page, mirrored, or with thicknesses not to scale."""
    badge = design_badge(Order("Ada", lens="50lpi", size_mm=size, range_m=(0.8, 2.0)), PAYLOAD)
    figures = MountFigures(acrylic=AcrylicProcess(base_mm=8.0))
    plan = write(badge, "lanyard", tmp_path / "a.pdf", figures).acrylic
    assert plan
    last = len(pages(tmp_path / "a.pdf")) - 1
    drawn = [loops[0] for loops in paths(tmp_path / "a.pdf", last)]
    scale = float(re.search(r"([\d.]+) of life size", pages(tmp_path / "a.pdf")[last]).group(1))
    edges = seen(size[0], 0), seen(0, size[1])
    cards = [
        c for c in drawn if len(c) == 5 and np.allclose([c[1] - c[0], c[2] - c[1]], scale * np.array(edges), rtol=0.03)
    ]
    assert cards
    scale = np.linalg.norm(cards[0][1] - cards[0][0]) / np.linalg.norm(edges[0])
    assert cards[0][2] - cards[0][1] == pytest.approx(scale * edges[1], abs=0.01)
    # Edges of plates: the board, its air, and the rim on both sides, less the rounded corners.
    lines = [loop[1] - loop[0] for loop in drawn if len(loop) == 2]
    rim = plan.base.outline.bounds[2] - size[0] / 2
    for across, side in ((seen(1, 0), size[0]), (seen(0, 1), size[1])):
        wanted = scale * across * (side + 2 * rim - 8.0)
        assert any(np.allclose(np.abs(line), np.abs(wanted), atol=0.02) for line in lines)
    # The base's walls are as high as it is thick.
    assert any(np.allclose(np.abs(line), [0, scale * seen(0, 0, 8.0)[1]], atol=0.02) for line in lines)


@pytest.mark.parametrize("mount", ["none", "lanyard", "clip", "stand", "holder"])
@pytest.mark.parametrize("paper", ["a4", "letter"])
def test_nothing_leaves_the_page_or_meets_a_label(mount: str, paper: str, tmp_path: Path) -> None:
    """Catches: a part or label off the paper, labels over each other or over the drawing, a font not carried."""
    badge = design_badge(Order("Ada", lens="50lpi", paper=paper, axes="xy"), PAYLOAD)
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
