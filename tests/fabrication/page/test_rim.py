"""Every page that is printed: white where office printers leave white, and as many pages as the shopping list says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.chart import design_chart
from moireid.fabrication.assembly.assembly_words import BuildPlan
from moireid.fabrication.assembly.guide import write_assembly_pdf
from moireid.fabrication.event import write_sheets_pdf
from moireid.fabrication.mount_parts import plan_parts
from moireid.fabrication.page.camera_page import print_camera_chart
from moireid.fabrication.page.chart_page import print_chart
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.fabrication.page.sheet_layout import lay_out_sheets
from moireid.fabrication.shopping.shopping_files import write_shopping
from moireid.fabrication.shopping.shopping_list import with_spare
from moireid.shopping import list_for

#: Resolution at which marks are looked for, and the white at each edge: less a dot, as rasters grey what they touch.
DPI, RIM_MM = 100, 6.0 - 25.4 / 100
#: Boards that leave the paper least room, by paper: the largest, a wide one and a narrow one that meet the scale bars.
LARGEST = {"a4": [(180, 267), (180, 140), (100, 267)], "letter": [(185.9, 249.4), (185.9, 140), (100, 249.4)]}
FORMATS = [("cr80", "landscape"), ("a6", "portrait"), ("webcam", "landscape")]


def design(paper: str, **wish: object) -> Badge:
    return design_badge(Order("Al", paper=paper, **wish), bytes(8))  # type: ignore[arg-type]


def sized(paper: str, size: tuple[float, float], front: str = "lens") -> Badge:
    return design(paper, size_mm=size, front=front, lens="50lpi", range_m=(0.6, 0.7))


def badges(paper: str, folder: Path) -> None:
    for number, size in enumerate(LARGEST[paper]):
        for front in ("lens", "mask"):
            write_badge_pdf(sized(paper, size, front), folder / f"{number}-{front}.pdf")


def events(paper: str, folder: Path) -> None:
    for number, size in enumerate(LARGEST[paper]):
        write_sheets_pdf([sized(paper, size)], folder / f"{number}.pdf")
    for form, orientation in FORMATS:
        badge = design(paper, format=form, orientation=orientation)
        write_sheets_pdf([badge] * len(lay_out_sheets(badge).places_mm), folder / f"{form}-{orientation}.pdf")


def charts(paper: str, folder: Path) -> None:
    for steps in (1, 10):
        (folder / str(steps)).mkdir()
        print_chart(design_chart("62lpi-27mil", paper=paper, steps=steps), folder / str(steps))
    print_camera_chart(folder / "camera.pdf", paper)


def others(paper: str, folder: Path) -> None:
    """Instructions and lists; the widest piece of sheet takes the paper up to its rim."""
    made = sized(paper, LARGEST[paper][0]), design(paper, format="a5", orientation="landscape")
    for number, badge in enumerate(made):
        write_assembly_pdf(BuildPlan(badge, plan_parts(badge, "none"), "command"), folder / f"{number}.pdf", {})
    write_shopping(list_for(design(paper, format="a6"), 40), folder / "shopping")


@pytest.mark.claim("All that is printed lies 6 mm within its page")
@pytest.mark.parametrize("paper", LARGEST)
@pytest.mark.parametrize("draw", [badges, events, charts, others])
def test_printers_that_leave_6_mm_white_cut_nothing_off(
    draw: Callable[[str, Path], None], paper: str, tmp_path: Path
) -> None:
    """Catches: scale bars, crop marks, words and pitch bands in the rim that office printers leave white."""
    draw(paper, tmp_path)
    for path in sorted(tmp_path.rglob("*.pdf")):
        with pdfium.PdfDocument(path) as document:
            for number, page in enumerate(document):
                dark = np.asarray(page.render(scale=DPI / 72, grayscale=True).to_pil()) < 220
                for side in (dark, dark[::-1], dark.T, dark.T[::-1]):
                    white_mm = np.flatnonzero(side.any(axis=1))[0] / DPI * 25.4
                    assert white_mm >= RIM_MM, (path.name, number, white_mm)


@pytest.mark.parametrize(("form", "orientation"), FORMATS)
@pytest.mark.parametrize("paper", ["a4", "letter", "a3"])
def test_the_shopping_list_counts_the_pages_that_are_printed(
    form: str, orientation: str, paper: str, tmp_path: Path
) -> None:
    """Catches: a count of its own, the page of pitch bands left out, half of the paper used by upright badges."""
    badge = design(paper, format=form, orientation=orientation)
    write_sheets_pdf([badge] * 3, tmp_path / "badges.pdf")
    with pdfium.PdfDocument(tmp_path / "badges.pdf") as document:
        pages = len(document)
    assert with_spare(pages) == next(line.quantity for line in list_for(badge, 3).lines if line.key == "paper")
    assert form != "a6" or pages == (2 if paper != "a3" else 1)
