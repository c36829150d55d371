"""The text of assembly.pdf: what to have, how to print, and what to do, in short sentences with a picture per step.

Sheets that the studio makes mention no commands, because an issuer who uses the studio has none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from moireid.badge import Badge, CodedFrame
from moireid.fabrication.assembly import sketches
from moireid.fabrication.page.pitch_bands import look_m
from moireid.fabrication.page.sheet_layout import lay_out_sheets
from moireid.fabrication.sight import has_turned, sheet_pieces
from moireid.frames import Axis
from moireid.sheets import MM_PER_INCH

if TYPE_CHECKING:
    from moireid.fabrication.acrylic.plates import AcrylicPlan

#: Who makes the sheet: the command line, or the studio.
Maker = Literal["command", "studio"]
#: How the lenses of an upright piece run.
WAYS: dict[Axis, str] = {"x": "upright", "y": "level"}
#: Lengths that M3 button-head screws are sold in, mm.
SCREWS_MM = (6, 8, 10, 12, 14, 16, 18, 20, 25, 30)
#: A sheet must slide into its mount, and is held by its edges.
NARROWER_MM = 0.2
#: Index of the acrylate of clear adhesives: so many times less than air does it add to how far fringes move.
ADHESIVE_INDEX = 1.47


#: One thing to do: its title, what to do, and its picture.
Step = tuple[str, str, sketches.Draw]


@dataclass(frozen=True)
class BuildPlan:
    """What is built: a badge with its mounts, by whom.

    parts: `mount_parts.Parts`, whose file imports this one; for_all: the badge is one of a list that share the sheet.
    """

    badge: Badge
    parts: Any
    maker: Maker
    for_all: bool = False

    @property
    def slots(self) -> int:
        """How many lanyard slots the printed mount has."""
        return len(self.parts.mount_plan[0].slots) if self.parts.mount_plan else 0

    @property
    def stopped(self) -> bool:
        """Whether a printed tray's stops set place and angle of page and sheet; pieces that are turned reach none."""
        return bool(self.parts.printed != "none") and not has_turned(self.badge)

    @property
    def adhesive_mm(self) -> float:
        """Thickness of the adhesive between page and sheet, 0 without one."""
        return float(self.parts.figures.printed.adhesive_mm)


def needs(build: BuildPlan) -> list[str]:
    """What to buy, to have and to make."""
    badge, mount, figures = build.badge, build.parts.printed, build.parts.figures.printed
    width, height = (badge.outline_mm[2 + k] - badge.outline_mm[k] for k in (0, 1))
    found = [
        f"Card: white, matt, 200 to 300 g/m² (about {figures.card_mm:g} mm thick), cut to {width:g} × {height:g} mm"
    ]
    found += dict.fromkeys(_front(build))
    if build.adhesive_mm:
        found.append(f"Clear adhesive film, {build.adhesive_mm:g} mm thick, or a sheet with adhesive on its back")
    if mount != "none":
        lanyard = "; a lanyard with two hooks" if build.slots == 2 else "; a lanyard"
        extra = lanyard if mount == "lanyard" else f", with its {mount}"
        found.append(f"The mount, 3D-printed from mount.3mf, or from mount*.stl, not turned, no supports{extra}")
    tape = ", clear tape" if any("tape" in words for _, words, _ in steps(build)) else ""
    found.append(f"A ruler of 15 cm or more, a sharp knife{tape}, and a phone that films")
    if (count := len(sheet_pieces(badge))) > 1 and badge.lens.kind != "mask":
        found.append(f"{count} pieces of lens sheet are cut: page 3 shows each in true size")
    return found


def _front(build: BuildPlan) -> list[str]:
    """What lies on the card."""
    lens, found = build.badge.lens, []
    for grating, corners in sheet_pieces(build.badge):
        across, along = math.dist(corners[0], corners[1]), math.dist(corners[1], corners[2])
        size = f"{along:.1f} × {across:.1f} mm" if grating.axis == "y" else f"{across:.1f} × {along:.1f} mm"
        if lens.kind == "mask":
            found.append(f"Clear film for your printer: page 2 of badge.pdf, cut along its marks to {size}")
            found.append(f"Clear acrylic, {lens.thickness_mm:g} mm thick, cut to {size}")
            continue
        turned = f"across its length, turned by {grating.axis}° clockwise"
        way = WAYS.get(grating.axis, turned.replace(".0°", "°"))
        found.append(
            f"Lenticular sheet, {MM_PER_INCH / lens.pitch_mm:.0f} lines per inch (LPI), {lens.thickness_mm:.3g} mm "
            f"thick, cut to {size}, lenses {way}"
        )
    return found


def paper_name(badge: Badge) -> str:
    """The name of the paper that a badge is printed on, for people."""
    name = str((badge.print or {}).get("paper", "a4"))
    return {"letter": "US Letter"}.get(name, name.upper())


def settings(build: BuildPlan) -> list[str]:
    """What to set in the print dialog, and what an adhesive does to the fringes."""
    print_data = build.badge.print or {}
    width, height = lay_out_sheets(build.badge).page_mm if build.for_all else build.badge.page_mm
    way = "upright (portrait)" if width <= height else "lying (landscape)"
    film = build.badge.lens.kind == "mask"
    printed = "badges.pdf" if build.for_all else "badge.pdf, page 1"
    found = [
        f"File: {printed}" + (" on card; the mask's page on clear film, with the same settings" if film else ""),
        f"Paper: {paper_name(build.badge)}, {way}, one side; type “heavy” or “card”",
        "Scale: 100 %, also called “actual size”. Never “fit to page”",
        f"Resolution: {print_data.get('dpi', 1200)} dpi, best quality; no “draft”, no “toner save”",
        "Colour: no smoothing. If the badge has colours: colour, and black as pure black. If not: black only",
        "Tray: the manual tray, also called multi-purpose: card stays straight",
    ]
    if build.adhesive_mm:
        found.append(
            f"The adhesive makes the bands move as far as {build.adhesive_mm / ADHESIVE_INDEX:.2g} mm of air would. "
            "Enroll a film of the finished badge, so that this is known."
        )
    return found


def steps(build: BuildPlan) -> list[Step]:
    """What to do, in order."""
    badge, far_m = build.badge, look_m(build.badge)
    mask, upright = badge.lens.kind == "mask", all(grating.axis == "x" for grating in badge.gratings)
    several = len(sheet_pieces(badge)) > 1
    front = "film" if mask else "sheet"
    one = f"each piece of {front}" if several else f"the {front}"
    bands = "are upright" if upright else "run along the printed lines"
    lay = _LAY_MASK if mask else _LAY_PIECES if several else _LAY
    # Under a sheet the sides of a frame look displaced; films of such badges are accepted (docs/accuracy.md).
    free = "Only the frame's left and right side may lie below it"
    again = "--people summary.csv" if build.for_all else "--again badge.json"
    free = free if isinstance(badge.markers, CodedFrame) else "Leave the black squares free"
    found: list[Step] = [
        ("Print it, and measure it", _MEASURE[build.maker].format(again=again), sketches.measure),
        (
            f"Try the uncut {front} on the five bands above the badge",
            f"{_TRY_MASK if mask else _TRY} From {far_m:g} m, one band has no stripes. 0: right. +1 or −1 %: "
            "the badge works. +3 or −3 %: the page was scaled, or the sheet has another pitch. "
            f"{_PITCH[build.maker]}",
            partial(sketches.bands, badge),
        ),
        ("Cut", f"Cut the badge out along the corner marks. {_cut(build)}", partial(sketches.cut, badge)),
        ("Lay", f"Press a curled card flat first. Lay {lay}. {free}.", partial(sketches.lay, badge)),
    ]
    turn = f"Turn the {front} until the bands are upright" if upright else "Turn it until the bands follow the lines"
    looks: list[Step] = [
        (
            "Look at the bands" if build.stopped else turn,
            _seen(build, "Check that" if build.stopped else f"Turn {one} slowly until", bands),
            partial(sketches.fringes, badge, (sketches.GOOD,)),
        ),
        (
            "Do the bands lean?",
            f"Then the {front} is turned by half a degree or so. {_LEANING_IN_TRAY if build.stopped else _LEANING}",
            partial(sketches.fringes, badge, (sketches.LEANING,)),
        ),
        (
            "Do they run the other way, or are they too wide?",
            f"If they run the other way (left) or are twice as wide (right), {front} and print do not fit each other: "
            "see step 2. fringes.webp shows each of them in motion.",
            partial(sketches.fringes, badge, (sketches.MIRRORED, sketches.WIDE)),
        ),
    ]
    # The stops of a tray set the angle, so that there is nothing to turn.
    fixed = _fixed(build, front)
    found += [fixed, *looks] if build.stopped else [*looks, fixed]
    if build.parts.printed != "none":
        found.append(_carried(build))
    film = partial(sketches.film, badge, far_m)
    return [*found, ("Film it and check", _CHECK[build.maker].format(look_m=far_m), film)]


_LEANING = "Turn it back a very little, until they lean no more."
_LEANING_IN_TRAY = (
    "Push card and sheet down and to the left again. If the bands still lean, an edge that lies at a stop is not "
    "straight: cut the card anew along its marks, or the sheet along a groove between two ribs."
)
_TRY = (
    "Peel off its protective film, wipe off dust. Lay it with its ribs, which a fingernail feels, on top and upright. "
    "No stripes at all: it is upside down."
)
_TRY_MASK = "Lay the acrylic there, and the film on it, printed side down, its lines upright."
_LAY = "the lens sheet on the striped field: ribs up, and along the printed lines"
_LAY_PIECES = "each piece of lens sheet on its striped field: ribs up, and along the printed lines"
_LAY_MASK = "the acrylic on the striped field, and the film on it, printed side down"
_BARS = (
    "Use the settings of page 1. Lay a ruler on both scale bars: each must read 150.0 mm, 0.5 mm more or less. If not, "
)
_MEASURE: dict[Maker, str] = {
    "command": _BARS
    + "divide what it reads by 150, and print again at that number: print-your-badge {again} --measured-scale NUMBER "
    "--out again.",
    "studio": _BARS + "look for a setting that fits the page to the paper, switch it off, and print again.",
}
_PITCH: dict[Maker, str] = {
    "command": "Measure the bars again. Then let moireid first-badge measure the sheet and the printer.",
    "studio": "Measure the bars again. Then take another sheet, or ask the person who issued the badge.",
}
_CHECK: dict[Maker, str] = {
    "command": "Film the badge for 8 seconds from {look_m:g} m, and move it 20 cm to and fro. First keep how it was "
    "built: moireid enroll badge.json --capture FILM. Then check any later film: moireid verify FILM --claim NAME.",
    "studio": "Film the badge for 8 seconds from {look_m:g} m, and move it 20 cm to and fro. Then open Enroll in the "
    "studio and give it the film: it keeps how this badge was built. Verify in the studio checks any later film.",
}


def _seen(build: BuildPlan, turn: str, bands: str) -> str:
    """What a builder sees, and until when to turn."""
    run = f" Move your head to the right: they run to the {'right' if sketches.runs_right(build.badge) else 'left'}."
    return (
        f"Look at it from {look_m(build.badge):g} m. You see wide dark bands. {turn} those of the plain rows (top, "
        f"middle and bottom) {bands}, as here; in the other rows they jump."
    ) + (run if build.badge.gratings[0].axis == "x" else "")


def _cut(build: BuildPlan) -> str:
    if build.badge.lens.kind == "mask":
        return "Cut the film along its own marks, and the acrylic to the same size."
    return f"Cut the lens sheet as the next page shows: no wider, and at most {NARROWER_MM:g} mm narrower."


def _fixed(build: BuildPlan, front: str) -> Step:
    badge = build.badge
    seam = " Join the pieces by clear tape on the front of the seam." if len(sheet_pieces(badge)) > 1 else ""
    turned = has_turned(badge)
    # Turned pieces do not reach the edges at which mounts hold, so tape holds them.
    seam = "" if turned else seam
    taped = "Hold each piece, and put clear tape along two of its sides, 2 mm wide. No air may stay between. "
    taped = taped if turned else ""
    if build.adhesive_mm:
        words = (
            f"Peel 1 cm of the liner off at one edge. Lay the {front}, turn it until the bands are right, and press "
            "that edge down. Then pull the liner out from below, and rub from there to the other side: no bubbles."
        )
        return ("Glue it", words, partial(sketches.lay, badge))
    if build.parts.printed != "none":
        words = (
            f"{taped}Slide card and {front} together into the mount from the top. Push both down, and to the left as "
            "you see them: the stops there set place and angle. Springs press them on each other; no air may stay "
            "between."
        )
        return ("Put it into the mount", words + seam, partial(sketches.held, badge, taped=False))
    if build.parts.acrylic:
        words = (
            f"{taped}Lay card and {front} into the acrylic frame, then film and cover on it, and tighten the screws by "
            "turns."
        )
        return ("Close the stack", words + seam, partial(sketches.held, badge, taped=True))
    words = f"Hold the {front}, and put clear tape along its left and right edge, 2 mm wide. No air may stay between."
    return ("Fix it", taped.strip() or words + seam, partial(sketches.held, badge, taped=True))


def _carried(build: BuildPlan) -> Step:
    if build.parts.printed == "clip":
        words = "Put the clip's hook through the slot from behind, and let the bar drop into it."
        return ("Put on the clip", words, partial(sketches.carried, build.badge, "clip", build.slots))
    if build.parts.printed == "stand":
        lean_deg = build.parts.figures.printed.stand_deg
        words = f"Set the mount's bottom edge into the groove. It leans back by {lean_deg:g}°."
        return ("Set it on the stand", words, partial(sketches.carried, build.badge, "stand", 0))
    words = "Hang it from both slots. On one hook a badge turns by itself, and its bands move."
    if build.slots < 2:
        words = "Hang it from its slot. On one hook a badge turns by itself, and its bands move: hold it for a check."
    return ("Hang it", words, partial(sketches.carried, build.badge, "lanyard", build.slots))


def acrylic(plan: AcrylicPlan) -> list[str]:
    """What the acrylic stack takes, and how it is closed."""
    plates = ", ".join(f"{plate.name} {plate.thickness_mm:g} mm" for plate in plan.plates if plate.name != "lips")
    layers = f"Below the badge: {plan.layers} more pieces of card, cut to its size. " if plan.layers else ""
    return [
        f"Laser-cut of clear acrylic: {plates}; acrylic.dxf (or .svg) has a colour for each, or take a file for each",
        f"And the lips, of clear polyester film (PET), {plan.lips.thickness_mm:g} mm thick; never of PVC, whose smoke "
        "is poisonous",
        f"{len(plan.screws)} button-head screws M3 × {screw_length_mm(plan)} (ISO 7380) with nuts",
        f"{layers}Card and sheet lie in the frame, with {plan.clearance_mm:g} mm of air at each edge. The sheet must "
        f"rise above the frame by 0.1 to 0.5 mm (planned: {plan.squeeze_mm:.2f} mm). Plates differ in "
        "thickness: add a layer of card or paper, or take one out. Tighten the screws until the film is flat on the "
        "frame; its lips then press the sheet.",
    ]


def screw_length_mm(plan: AcrylicPlan) -> int:
    """The shortest screw on sale that reaches through the nut."""
    return next((size for size in SCREWS_MM if size >= plan.screw_mm), math.ceil(plan.screw_mm))
