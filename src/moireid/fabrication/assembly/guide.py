"""assembly.pdf: what to gather, what to do, a section through the stack, and exploded views on pages of their own."""

from __future__ import annotations

import math
from pathlib import Path

from moireid.badge import Badge, Lens
from moireid.fabrication.acrylic.plates import AcrylicPlan
from moireid.fabrication.assembly.axonometry import Part, draw_exploded
from moireid.fabrication.assembly.exploded import acrylic_parts, plain_parts, printed_parts
from moireid.fabrication.page.pdf import BOLD, Sheet
from moireid.fabrication.process import MountFigures
from moireid.fabrication.sight import sheet_pieces
from moireid.files import whole_file
from moireid.profiles import PAPERS_MM
from moireid.turned import Axis

#: How the lenses of an upright piece run.
WAYS: dict[Axis, str] = {"x": "upright", "y": "level"}
LEFT_MM, TOP_MM, LINE_MM = 22.0, 28.0, 7.0
#: Lengths that M3 button-head screws are sold in, mm.
SCREWS_MM = (6, 8, 10, 12, 14, 16, 18, 20, 25, 30)
#: For each mount: what else to gather for carrying it, and the last step.
_CARRIED = {
    "lanyard": ("; a lanyard", "Tie the lanyard to the mount's slot."),
    "clip": (", with its clip", "Put the clip's hook through the slot from behind, and let the bar drop into it."),
    "stand": (", with its stand", "Set the mount's bottom edge into the stand's groove."),
}


def write_assembly_pdf(
    badge: Badge, path: Path, *, mount: str, acrylic: AcrylicPlan | None = None, figures: MountFigures | None = None
) -> None:
    """Write the sheet of parts and steps, whole or not at all.

    Parameters: mount: kind of the printed mount, "none" without one; acrylic: the stack, if one can be built instead
        of it or alone; figures: those of the plans, None for the defaults.
    """
    views = _views(badge, mount, acrylic, figures or MountFigures())
    paper = str((badge.print or {}).get("paper", "a4"))
    with whole_file(path) as temporary:
        sheet = Sheet(temporary, PAPERS_MM.get(paper, PAPERS_MM["a4"]), f"Assembly of moiré badge {badge.id}")
        sheet.text(LEFT_MM, TOP_MM, f"Moiré badge {badge.id}: assembly", points=16, font=BOLD, align="left")
        y = TOP_MM + 12
        sections = [("You need", _parts(badge, mount)), ("Steps", _steps(badge, mount, acrylic is not None))]
        if acrylic:
            heading = "The mount, in acrylic" if mount == "none" else "Or, instead of the printed mount, in acrylic"
            sections.append((heading, _acrylic(acrylic)))
        for heading, lines in sections:
            sheet.text(LEFT_MM, y, heading, points=12, font=BOLD, align="left")
            for line in lines:
                y += LINE_MM
                sheet.text(LEFT_MM + 4, y, line, points=9, align="left")
            y += 12
        _draw_stack(sheet, badge, y)
        for heading, view in views:
            sheet.canvas.showPage()
            _draw_view(sheet, heading, view)
        sheet.save()


def _views(
    badge: Badge, mount: str, acrylic: AcrylicPlan | None, figures: MountFigures
) -> list[tuple[str, list[Part]]]:
    """The exploded views, one for each way to build the badge: heading and parts."""
    views = []
    if mount != "none":
        views.append(("Exploded view: the printed mount", printed_parts(badge, mount, figures.printed)))
    if acrylic:
        parts = acrylic_parts(badge, acrylic, figures.acrylic.film_mm, f"M3 × {_screw_length_mm(acrylic)}")
        views.append(("Exploded view: the mount in acrylic", parts))
    return views or [("Exploded view", plain_parts(badge, figures.printed))]


def _draw_view(sheet: Sheet, heading: str, parts: list[Part]) -> None:
    width, height = sheet.page_mm
    sheet.text(LEFT_MM, TOP_MM, heading, points=16, font=BOLD, align="left")
    scale = draw_exploded(sheet, parts, (LEFT_MM, TOP_MM + 18, width - LEFT_MM, height - TOP_MM))
    words = (
        f"Parts to one scale, {scale:.2f} of life size, pulled apart from front (top) to back; bottom edge near you."
    )
    sheet.text(LEFT_MM, TOP_MM + 8, words, points=9, align="left")


def _parts(badge: Badge, mount: str) -> list[str]:
    width, height = (badge.outline_mm[2 + k] - badge.outline_mm[k] for k in (0, 1))
    lens = badge.lens
    parts = [f"•  badge.pdf printed at 100 % on card, board {width:g} × {height:g} mm"]
    for grating, corners in sheet_pieces(badge):
        across, along = math.dist(corners[0], corners[1]), math.dist(corners[1], corners[2])
        size = f"{along:.1f} × {across:.1f} mm" if grating.axis == "y" else f"{across:.1f} × {along:.1f} mm"
        way = WAYS.get(grating.axis, f"across its length, turned by {grating.axis}° clockwise")
        if lens.kind == "mask":
            parts.append(f"•  page 2 of badge.pdf printed at 100 % on clear film, cut along its marks to {size}")
            parts.append(f"•  clear acrylic, {lens.thickness_mm:g} mm thick, cut to {size}")
            continue
        parts.append(
            f"•  a lenticular sheet, {25.4 / lens.pitch_mm:.0f} lines per inch, {lens.thickness_mm:g} mm thick, cut to "
            f"{size}, lenses {way}"
        )
    if mount != "none":
        parts.append(f"•  the mount: mount.stl or mount.3mf, 3D-printed as it lies{_CARRIED[mount][0]}")
    return parts


def _steps(badge: Badge, mount: str, acrylic: bool) -> list[str]:
    hold = "2 mm tape along its left and right edges" if mount == "none" else "the mount's lips"
    hold = "the acrylic cover" if mount == "none" and acrylic else hold
    if badge.lens.kind == "mask":
        front, lay = "film", "Lay the acrylic over the striped field, and the film on it, printed side down."
    else:
        front, lay = "sheet", "Lay the lenticular sheet over the striped field, its lenses up and along the lines."
    steps = [
        "Measure both scale bars. Each must read 150.0 mm, give or take 0.5; else print with --measured-scale.",
        "Cut the board out along the crop marks.",
        lay,
        f"Turn the {front} until the fringes of the plain rows (top, middle, bottom) stand upright.",
        f"Fix it flat on the paper with {hold}; no air between, markers uncovered.",
    ]
    if len(badge.gratings) > 1:
        steps.append("Join the sheets with a strip of clear tape on the front of the seam, between the striped fields.")
    if mount != "none":
        steps += [
            "Slide board and front together into the mount from the top, down to its bottom edges.",
            _CARRIED[mount][1],
        ]
    return [f"{number}.  {step}" for number, step in enumerate(steps, start=1)]


def _acrylic(plan: AcrylicPlan) -> list[str]:
    film = {plate.name: " (film)" for plate in plan.plates if plate.thickness_mm <= 0.5}
    plates = ", ".join(f"{plate.name} {plate.thickness_mm:g} mm{film.get(plate.name, '')}" for plate in plan.plates)
    return [
        f"•  acrylic.dxf or acrylic.svg, laser-cut: {plates}",
        f"•  {len(plan.screws)} button-head screws M3 × {_screw_length_mm(plan)} (ISO 7380) with nuts",
        f"Lay board and sheet into the frame on the base ({plan.clearance_mm:g} mm of air at each edge), put the cover",
        f"on, and tighten until it touches the sheet all along; {plan.squeeze_mm:.2f} mm to the frame remain.",
    ]


def _screw_length_mm(plan: AcrylicPlan) -> int:
    """The shortest screw on sale that reaches through the nut."""
    return next((size for size in SCREWS_MM if size >= plan.screw_mm), math.ceil(plan.screw_mm))


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
                axis + points[i] * scale,
                top_mm + 8 + sags[i] * scale,
                axis + points[i + 1] * scale,
                top_mm + 8 + sags[i + 1] * scale,
                0.2,
            )
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
    """The name of the section's upper part."""
    return "printed film on acrylic" if lens.kind == "mask" else "lens sheet, lenses towards the viewer"
