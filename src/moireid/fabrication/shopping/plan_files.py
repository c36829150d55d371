"""cutting-plan.pdf for the person at the cutter, and cutting-plan.dxf for a machine.

A page shows sheets that are cut alike: the sheet with its lenses' direction, the pieces, the cuts with their numbers,
and each cut's distance from an edge.  What fits the paper is drawn at true scale; what does not is drawn smaller, by a
scale that the page states.

Convention: in the DXF file mm, y up, x across the lenses; one layer for the sheets, one for the first cuts, one for the
second cuts, one for notes.  Sheets that are cut alike are drawn once.
"""

from __future__ import annotations

from pathlib import Path

from moireid.badge import Rect
from moireid.errors import FabricationError
from moireid.fabrication.dxf_file import sound_dxf, written_dxf
from moireid.fabrication.page.canvas import BOLD, POINTS_PER_MM, PdfPage
from moireid.fabrication.shopping.cutting import CutSheet, CuttingPlan
from moireid.profiles import PAPERS_MM

#: Scales of a page: 1 to so much.
SCALES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 8.0, 10.0, 15.0, 20.0)
LEFT_MM, TOP_MM, RIGHT_MM, BOTTOM_MM = 22.0, 44.0, 12.0, 32.0
TITLE_POINTS, TEXT_POINTS, SMALL_POINTS = 13.0, 8.5, 6.5
LINE_MM = 4.4
#: On the page, mm: between the strokes that show the lenses, and from a sheet's edge to the numbers at it.
LENSES_MM, NUMBER_MM = 6.0, 1.6
#: Distances at an edge are written no closer than this, mm on the page.
LEAST_APART_MM = 2.8
#: Figures below a sheet: rows of them, a row's height, and the width of a figure, mm on the page.
ROWS, ROW_MM, FIGURE_MM = 3, 6.4, 8.4
PIECE_GREY, LENS_GREY = 0.93, 0.82
CUT_MM, SECOND_MM = 0.5, 0.25
LAYERS = {"SHEET": 8, "CUT-1": 1, "CUT-2": 5, "PIECE": 3, "NOTE": 8}
GAP_MM, TEXT_MM = 40.0, 5.0
ROUNDING_MM = 1e-6


def write_plan_pdf(plan: CuttingPlan, path: Path) -> None:
    """Write a page for each way in which sheets are cut."""
    paper = PAPERS_MM["a4"]
    page = PdfPage(path, paper, "Cutting plan")
    for number, sheet in enumerate(plan.sheets, start=1):
        if number > 1:
            page.turn_page(paper)
        _draw_page(page, plan, sheet, number, paper)
    page.save()


def page_scale(plan: CuttingPlan, paper_mm: tuple[float, float]) -> float:
    """1 to so much, by which a sheet fits the page.  Raises: FabricationError for a sheet that fits by no scale."""
    room = (paper_mm[0] - LEFT_MM - RIGHT_MM, paper_mm[1] - TOP_MM - BOTTOM_MM)
    sides = (plan.sheet.across_mm, plan.sheet.along_mm)
    for scale in SCALES:
        if all(side / scale <= space for side, space in zip(sides, room, strict=True)):
            return scale
    raise FabricationError(f"a sheet of {sides[0]:g} x {sides[1]:g} mm is too large to draw; give a smaller one")


def _draw_page(page: PdfPage, plan: CuttingPlan, sheet: CutSheet, number: int, paper: tuple[float, float]) -> None:
    scale, stock = page_scale(plan, paper), plan.sheet
    before = sum(one.count for one in plan.sheets[: number - 1])
    last = before + sheet.count
    title = f"Sheet {last}" if sheet.count == 1 else f"Sheets {before + 1:,} to {last:,}, all cut alike"
    page.text(LEFT_MM, 14.0, title, points=TITLE_POINTS, font=BOLD, align="left")
    shown = "at true scale" if scale == 1 else f"at a scale of 1 : {scale:g}"
    sizes = "; ".join(f"{one.name} {_mm(one.across_mm)} x {_mm(one.along_mm)}" for one in plan.wanted)
    pieces = "1 piece" if len(sheet.pieces) == 1 else f"{len(sheet.pieces)} pieces"
    lines = (
        f"{stock.across_mm:g} x {stock.along_mm:g} mm, {pieces}. Drawn {shown}; all figures are mm, across the lenses "
        "x along them.",
        f"Needed: {sizes}. Grey lines show the lenses: they run from top to bottom.",
        f"Cut from edge to edge, in the order of the numbers: first the bold cuts, then each strip. Edges lose "
        f"{stock.trim_mm:g} mm.",
        "Never turn a piece: the lenses must run on the badge as they run here.",
    )
    room = paper[0] - LEFT_MM - RIGHT_MM
    points = TEXT_POINTS * min(1.0, *(room / page.text_width_mm(words, TEXT_POINTS) for words in lines))
    for k, words in enumerate(lines):
        page.text(LEFT_MM, 20.5 + k * LINE_MM, words, points=points, align="left")
    _Drawing(page, plan, sheet, scale).draw()


class _Drawing:
    """One sheet on a page: its frame is that of the plan, and the page's y runs down."""

    def __init__(self, page: PdfPage, plan: CuttingPlan, sheet: CutSheet, scale: float) -> None:
        self.page, self.plan, self.sheet, self.scale = page, plan, sheet, scale

    def at(self, x: float, y: float) -> tuple[float, float]:
        """A place of the sheet on the page, mm."""
        return LEFT_MM + x / self.scale, TOP_MM + (self.plan.sheet.along_mm - y) / self.scale

    def box(self, rect: Rect) -> Rect:
        """A rectangle of the sheet on the page."""
        (x0, y1), (x1, y0) = self.at(rect[0], rect[1]), self.at(rect[2], rect[3])
        return (x0, y0, x1, y1)

    def draw(self) -> None:
        """Sheet, lenses, pieces with their sizes, cuts with their numbers and distances."""
        page, stock = self.page, self.plan.sheet
        page.fill([self.box(rect) for _, rect in self.sheet.pieces], PIECE_GREY)
        steps = max(1, int(stock.across_mm / self.scale / LENSES_MM))
        for k in range(1, steps):
            x, top = self.at(stock.across_mm * k / steps, stock.along_mm)
            page.path([(x, top), (x, self.at(0, 0)[1])], None, LENS_GREY, closed=False)
        outline = self.box((0, 0, stock.across_mm, stock.along_mm))
        x0, y0, x1, y1 = outline
        page.path([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], None, 0.0)
        several = len(self.plan.wanted) > 1
        for k, (name, rect) in enumerate(self.sheet.pieces, start=1):
            left, upper, right, lower = self.box(rect)
            words = f"{name.split()[-1]}.{k}" if several else f"{k}"
            points = min(11.0, 0.5 * min(right - left, lower - upper) * POINTS_PER_MM)
            page.text((left + right) / 2, (upper + lower) / 2 + 0.35 * points / POINTS_PER_MM, words, points=points)
        self._write_sizes()
        for cut in self.sheet.cuts:
            (ax, ay), (bx, by) = self.at(*cut.line[:2]), self.at(*cut.line[2:])
            page.stroke(ax, ay, bx, by, CUT_MM if cut.first else SECOND_MM)
        self._number_cuts(outline)

    def _write_sizes(self) -> None:
        """The sizes of the first piece of each kind, in the piece, where there is room."""
        seen = set()
        for name, rect in self.sheet.pieces:
            left, _, right, lower = self.box(rect)
            words = f"{_mm(rect[2] - rect[0])} x {_mm(rect[3] - rect[1])}"
            if name not in seen and self.page.text_width_mm(words, SMALL_POINTS) < right - left - 2:
                self.page.text((left + right) / 2, lower - 1.5, words, points=SMALL_POINTS)
            seen.add(name)

    def _number_cuts(self, outline: Rect) -> None:
        """Each cut's number, and how far it is from the left or lower edge; like cuts of strips share a place."""
        page, (x0, _, x1, y1) = self.page, outline
        across: dict[float, list[int]] = {}
        along: dict[float, list[int]] = {}
        for cut in self.sheet.cuts:
            level = abs(cut.line[1] - cut.line[3]) < ROUNDING_MM
            (across if level else along).setdefault(round(cut.line[1] if level else cut.line[0], 3), []).append(
                cut.number
            )
        last = float("inf")
        for y in sorted(across):
            place = self.at(0, y)[1]
            if last - place < LEAST_APART_MM:
                continue
            last = place
            page.text(x0 - NUMBER_MM, place + 0.8, f"{y:.1f}", points=SMALL_POINTS, align="right")
            page.text(x1 + NUMBER_MM, place + 0.8, _numbers(across[y]), points=SMALL_POINTS, align="left", font=BOLD)
        # Cuts of different strips may be close to each other: their figures go below one another.
        ends = [-float("inf")] * ROWS
        for x in sorted(along):
            place = self.at(x, 0)[0]
            row = next((k for k, end in enumerate(ends) if place - end >= FIGURE_MM), None)
            if row is None:
                continue
            ends[row] = place
            top = y1 + NUMBER_MM + row * ROW_MM
            page.text(place, top + 1.8, f"{x:.1f}", points=SMALL_POINTS)
            page.text(place, top + 4.6, _numbers(along[x]), points=SMALL_POINTS, font=BOLD)
        words = "Next to the sheet: distance from its lower or left edge, and numbers of cuts (bold)."
        page.text(x0, y1 + NUMBER_MM + ROWS * ROW_MM + 3.0, words, points=SMALL_POINTS, align="left")


def _mm(length: float) -> str:
    """A length to a hundredth, without zeros at its end."""
    return f"{length:.2f}".rstrip("0").rstrip(".")


def _numbers(found: list[int]) -> str:
    """Numbers of cuts in few letters: "7", "7, 9", "7 … 31"."""
    return ", ".join(map(str, found)) if len(found) < 3 else f"{found[0]} … {found[-1]}"


def write_plan_dxf(plan: CuttingPlan, path: Path) -> None:
    """Write a DXF R2010 file, mm.  Raises: MissingExtraError without ezdxf."""
    with written_dxf(path) as document:
        space = document.modelspace()
        for name, colour in LAYERS.items():
            document.layers.add(name, color=colour)
        stock = plan.sheet
        for k, sheet in enumerate(plan.sheets):
            dx = k * (stock.across_mm + GAP_MM)
            outline = (0.0, 0.0, stock.across_mm, stock.along_mm)
            for layer, rect in [("SHEET", outline), *(("PIECE", rect) for _, rect in sheet.pieces)]:
                x0, y0, x1, y1 = rect
                corners = [(x0 + dx, y0), (x1 + dx, y0), (x1 + dx, y1), (x0 + dx, y1)]
                space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
            for cut in sheet.cuts:
                x0, y0, x1, y1 = cut.line
                layer = "CUT-1" if cut.first else "CUT-2"
                space.add_line((x0 + dx, y0), (x1 + dx, y1), dxfattribs={"layer": layer})
            words = f"{sheet.count} x; lenses run along y"
            space.add_text(words, height=TEXT_MM, dxfattribs={"layer": "NOTE"}).set_placement((dx, -3 * TEXT_MM))


def check_plan_dxf(path: Path, plan: CuttingPlan) -> None:
    """Read a DXF file back: no faults in the audit, millimetres, and as many pieces and cuts as the plan has.

    Raises: FabricationError with what was found and what is allowed.
    """
    document = sound_dxf(path, _refused)
    found = [entity.dxf.layer for entity in document.modelspace()]
    wanted = {
        "SHEET": len(plan.sheets),
        "PIECE": sum(len(sheet.pieces) for sheet in plan.sheets),
        "CUT-1": sum(cut.first for sheet in plan.sheets for cut in sheet.cuts),
        "CUT-2": sum(not cut.first for sheet in plan.sheets for cut in sheet.cuts),
    }
    for layer, count in wanted.items():
        if found.count(layer) != count:
            raise _refused(f"has {found.count(layer)} shapes on {layer}", f"{count}")


def _refused(got: str, allowed: str) -> FabricationError:
    return FabricationError(f"the cutting plan's DXF {got}, allowed is {allowed}; nothing was kept: report this")
