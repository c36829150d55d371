"""assembly.pdf: what to gather, what to do, and a drawing of the stack."""

from __future__ import annotations

from pathlib import Path

from moireid.badge import Badge, Lens
from moireid.fabrication.page import BOLD, Sheet
from moireid.files import whole_file
from moireid.profiles import PAPERS_MM

LEFT_MM, TOP_MM, LINE_MM = 22.0, 28.0, 7.0


def write_assembly_pdf(badge: Badge, path: Path, *, mount: str) -> None:
    """Write the sheet of parts and steps, whole or not at all; `mount` is the contract's word for the mount."""
    paper = str((badge.print or {}).get("paper", "a4"))
    with whole_file(path) as temporary:
        sheet = Sheet(temporary, PAPERS_MM.get(paper, PAPERS_MM["a4"]), f"Assembly of moiré badge {badge.id}")
        sheet.text(LEFT_MM, TOP_MM, f"Moiré badge {badge.id}: assembly", points=16, font=BOLD, align="left")
        y = TOP_MM + 12
        for heading, lines in (("You need", _parts(badge, mount)), ("Steps", _steps(badge, mount))):
            sheet.text(LEFT_MM, y, heading, points=12, font=BOLD, align="left")
            for line in lines:
                y += LINE_MM
                sheet.text(LEFT_MM + 4, y, line, points=9, align="left")
            y += 12
        _draw_stack(sheet, badge, y)
        sheet.save()


def _parts(badge: Badge, mount: str) -> list[str]:
    width, height = (badge.outline_mm[2 + k] - badge.outline_mm[k] for k in (0, 1))
    lens = badge.lens
    parts = [f"•  badge.pdf printed at 100 % on card, board {width:g} × {height:g} mm"]
    for grating in badge.gratings:
        sheet = [grating.rect_mm[2 + k] - grating.rect_mm[k] for k in (0, 1)]
        if len(badge.gratings) == 1:
            sheet[0] = width
        way = "upright" if grating.axis == "x" else "level"
        if lens.kind == "mask":
            size = f"{grating.rect_mm[2] - grating.rect_mm[0]:.1f} × {grating.rect_mm[3] - grating.rect_mm[1]:.1f} mm"
            parts.append(f"•  page 2 of badge.pdf printed at 100 % on clear film, cut along its marks to {size}")
            parts.append(f"•  clear acrylic, {lens.thickness_mm:g} mm thick, cut to {size}")
            continue
        parts.append(
            f"•  a lenticular sheet, {25.4 / lens.pitch_mm:.0f} lines per inch, {lens.thickness_mm:g} mm thick, cut to "
            f"{sheet[0]:.1f} × {sheet[1]:.1f} mm, lenses {way}"
        )
    if mount != "none":
        parts.append("•  the mount: mount.stl, 3D-printed with its back on the bed; a lanyard")
    return parts


def _steps(badge: Badge, mount: str) -> list[str]:
    hold = "2 mm tape along its left and right edges" if mount == "none" else "the mount's lips"
    if badge.lens.kind == "mask":
        front, lay = "film", "Lay the acrylic over the striped field, and the film on it, printed side down."
    else:
        front, lay = "sheet", "Lay the lenticular sheet over the striped field, its lenses up and along the lines."
    steps = [
        "Measure both scale bars on the print. Each must read 150.0 mm, give or take 0.5 mm.",
        "Cut the board out along the crop marks.",
        lay,
        f"Turn the {front} until the fringes of the plain rows (top, middle, bottom) stand upright.",
        f"Fix it flat on the paper with {hold}; no air between, markers uncovered.",
    ]
    if mount != "none":
        steps.append("Slide board and front together into the mount from the top, and tie on the lanyard.")
    return [f"{number}.  {step}" for number, step in enumerate(steps, start=1)]


def _draw_stack(sheet: Sheet, badge: Badge, top_mm: float) -> None:
    """A section through the stack, 12 times life size, with the true radius and pitches."""
    scale, lens = 12.0, badge.lens
    left, width = LEFT_MM + 4, 10 * lens.pitch_mm * scale
    page_y = top_mm + 8 + lens.thickness_mm * scale
    if lens.kind == "mask":
        shut = 1 - (lens.open_fraction or 0.0)
        pitch = lens.pitch_mm * scale
        sheet.fill([(left + k * pitch, top_mm + 7, left + (k + shut) * pitch, top_mm + 8) for k in range(10)])
        for y in (top_mm + 8, page_y):
            sheet.stroke(left, y, left + width, y, 0.2)
        for x in (left, left + width):
            sheet.stroke(x, top_mm + 8, x, page_y, 0.2)
    for k in range(0 if lens.kind == "mask" else 10):
        assert lens.radius_mm is not None
        axis = left + (k + 0.5) * lens.pitch_mm * scale
        points = [(step / 10 - 0.5) * lens.pitch_mm for step in range(11)]
        sags = [lens.radius_mm - (lens.radius_mm**2 - x**2) ** 0.5 for x in points]
        for i in range(10):
            sheet.stroke(
                axis + points[i] * scale, top_mm + 8 + sags[i] * scale,
                axis + points[i + 1] * scale, top_mm + 8 + sags[i + 1] * scale, 0.2,
            )  # fmt: skip
    cell = badge.gratings[0].cells[0]
    lines = int(10 * lens.pitch_mm / cell.pitch_mm)
    sheet.fill(
        [
            (left + k * cell.pitch_mm * scale, page_y, left + (k + cell.duty) * cell.pitch_mm * scale, page_y + 1.2)
            for k in range(lines)
        ]
    )
    sheet.stroke(left, page_y, left + width, page_y, 0.2)
    labels = ((_front_words(lens), 8 + lens.thickness_mm * scale / 2), ("printed lines", 0))
    sheet.text(left + width + 4, top_mm + labels[0][1], labels[0][0], points=8, align="left")
    sheet.text(left + width + 4, page_y + 1.2, labels[1][0], points=8, align="left")


def _front_words(lens: Lens) -> str:
    """What the section's upper part is."""
    return "printed film on acrylic" if lens.kind == "mask" else "lens sheet, lenses towards the viewer"
