"""From a badge and a number of people to the lines of a shopping list: what to buy, how much of it, and why.

Of everything that is bought there is a spare share on top, as sheets are cut wrong and cards are printed twice.

Source: pieces of lens sheet by `sight.piece_sizes`, pages by the layout that is printed (`sheet_layout`), plates and
screws by the plan of the acrylic stack, products by the table of materials, hours and grams of printed mounts by a
slicer: `mount_times.csv` has what `moireid lab bench mounts` prints, for a common printer (nozzle 0.4 mm, layers 0.2
mm, PLA, no supports).
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.fabrication.assembly.assembly_words import paper_name, screw_length_mm
from moireid.fabrication.mount_parts import Parts
from moireid.fabrication.page.sheet_layout import lay_out_sheets
from moireid.fabrication.shopping.cutting import CuttingPlan, Pieces, plan_cutting
from moireid.fabrication.sight import piece_sizes
from moireid.materials import Kind, Material, materials, materials_for
from moireid.profiles import find_dpi
from moireid.sheets import MM_PER_INCH, PRODUCTS

MOST_PEOPLE = 10_000
#: Of everything that is bought, so much more.
SPARE_SHARE = 0.05
MOUNT_TIMES = Path(__file__).with_name("mount_times.csv")
#: A slicer's words for a time, such as "1h 3m 4s", in hours.
HOURS = {"h": 1.0, "m": 1 / 60, "s": 1 / 3600}
#: Thinner plates are polyester film.
LEAST_ACRYLIC_MM = 1.0
#: Two strips of tape for each piece of lens sheet, each so much longer than the piece, mm.
TAPE_OVER_MM = 10.0


@dataclass(frozen=True)
class ListLine:
    """One line: its key, what to ask for, how much of it, how that comes about, and what the product's figures rest on.

    unstated: what no source states.
    """

    key: str
    what: str
    quantity: int
    unit: str
    note: str
    source: str = ""
    unstated: str = "maker, article, price"

    @property
    def amount(self) -> str:
        """Quantity and unit, for people."""
        return f"{self.quantity:,} {self.unit.removesuffix('s') if self.quantity == 1 else self.unit}"


@dataclass(frozen=True)
class ShoppingList:
    """All lines; title: for what they are; cutting: of the lens sheets, None for a mask; notes: what no line says."""

    title: str
    lines: tuple[ListLine, ...]
    cutting: CuttingPlan | None
    notes: tuple[str, ...]


def shopping_list(
    badge: Badge, parts: Parts, people: int, sheet_mm: tuple[float, float], *, form: str | None
) -> ShoppingList:
    """What to buy for so many badges alike.

    Parameters
    ----------
    badge : Badge
        One of them; all have its layout.
    parts : Parts
        The mount that is made for each: printed or of acrylic; neither where holders are bought.
    people : int
        How many badges.
    sheet_mm : (float, float)
        Sides of a lens sheet across and along its lenses, mm.
    form : str or None
        Name of the badge's format; None for another size.

    Returns
    -------
    ShoppingList
        Lines in the order in which a badge is built.

    Raises
    ------
    SpecError
        For a number of people that no event has.
    FabricationError
        Where a piece does not fit the sheet.
    """
    if not 1 <= people <= MOST_PEOPLE:
        raise SpecError(f"{people} people are not possible; give 1 to {MOST_PEOPLE}")
    count = with_spare(people)
    pieces = lens_pieces(badge, count)
    cutting = None if badge.lens.kind == "mask" else plan_cutting(pieces, sheet_mm)
    lines = _mask_lines(badge, pieces, count) if cutting is None else _sheet_lines(badge, cutting)
    lines.append(_paper_line(badge, people))
    notes = []
    if parts.acrylic is not None:
        stack = parts.acrylic
        plates = Counter((plate.thickness_mm, plate.outline.bounds) for plate in stack.plates)
        for (thickness_mm, (x0, y0, x1, y1)), number in plates.items():
            lines.append(_plates("acrylic", thickness_mm, (x1 - x0, y1 - y0), number * count))
        length_mm, screws = screw_length_mm(stack), len(stack.screws)
        what, note = f"{_only('screws').words}, {length_mm} mm long", f"{screws} for each badge"
        lines.append(_line("screws", what, screws * count, "screws with nuts", note, _only("screws")))
        if stack.layers:
            notes.append(f"each badge takes {stack.layers} more pieces of the card, cut to its size, below the page")
    elif (mount := mount_times().get((form, parts.printed))) is not None:
        hours, grams = mount
        note = f"{grams:.3g} g and {hours:.1f} h for each mount; {hours * people:,.1f} h for all on one printer"
        plastic = _only("filament")
        lines.append(_line("filament", plastic.words, math.ceil(grams * count), "g", note, plastic))
    elif parts.printed != "none":
        notes.append(f"the mount {parts.printed} of this size was not sliced, so its time and plastic are unknown")
    elif form is not None and (found := materials_for("holder", form=form)):
        width, high = found[0].sizes_mm[0]
        note = f"for a card of {width:g} x {high:g} mm with a lens sheet on it; try one before you buy all"
        lines.append(_line("holder", found[0].words, count, "holders", note, found[0]))
    if parts.printed in ("lanyard", "none"):
        note = "one for each badge; with two hooks where a mount has two slots"
        lines.append(_line("lanyard", _only("lanyard").words, count, "lanyards", note, _only("lanyard")))
    x0, y0, x1, y1 = badge.outline_mm
    title = f"{people:,} {'badge' if people == 1 else 'badges'} of {x1 - x0:g} x {y1 - y0:g} mm"
    title += f"{f' ({form})' if form else ''}, with {100 * SPARE_SHARE:g} % of everything to spare."
    return ShoppingList(title, tuple(lines), cutting, tuple(notes))


def with_spare(count: int) -> int:
    """A number with the spare share on top, rounded up; a billionth more is no reason for another."""
    return count + math.ceil(count * SPARE_SHARE - 1e-9)


def lens_pieces(badge: Badge, count: int) -> tuple[Pieces, ...]:
    """The pieces of lens sheet of so many badges, by size."""
    return tuple(Pieces(*size, number * count) for size, number in piece_sizes(badge).items())


def front_words(badge: Badge) -> str:
    """The product that lies on the card, for people: the row of the table, or the figures of another sheet."""
    if badge.lens.kind == "mask":
        return f"Line mask on clear film, over acrylic of {badge.lens.thickness_mm:g} mm"
    if (row := _sheet_row(badge)) is not None:
        return row.words
    return f"Lenticular sheet, {MM_PER_INCH / badge.lens.pitch_mm:.4g} LPI, {badge.lens.thickness_mm:.3g} mm"


@cache
def mount_times() -> dict[tuple[str | None, str], tuple[float, float]]:
    """Hours and grams of a printed mount, by format and kind; one that cannot be made for a format has no entry."""
    with MOUNT_TIMES.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["time"]]
    return {(row["format"], row["mount"]): (_hours(row["time"]), float(row["PLA, g"])) for row in rows}


def _hours(words: str) -> float:
    return sum(int(number) * HOURS[unit] for number, unit in re.findall(r"(\d+)(\w)", words))


def _sheet_row(badge: Badge) -> Material | None:
    """The row that the badge was designed for; None for a measured sheet, a mask, or another thickness."""
    label = str((badge.print or {}).get("lens")).lower()
    if badge.lens.kind != "lenticular" or label not in PRODUCTS:
        return None
    if abs(PRODUCTS[label].thickness_mm - badge.lens.thickness_mm) > 1e-6:
        return None
    return next(row for row in materials() if row.label == label)


def _sheet_lines(badge: Badge, plan: CuttingPlan) -> list[ListLine]:
    """Lens sheets, and the tape that holds a piece on the card."""
    sizes = " and ".join(f"{one.across_mm:.1f} x {one.along_mm:.1f} mm" for one in plan.pieces)
    most = max(sum(strip.count for strip in strips) for strips, _ in plan.sheets)
    note = f"{most} pieces from a sheet, of {sizes} (across the lenses x along them)"
    side = "longer" if plan.sheet_mm[1] >= plan.sheet_mm[0] else "shorter"
    what = f"{front_words(badge)}; {plan.sheet_mm[0]:g} x {plan.sheet_mm[1]:g} mm, lenses along the {side} side"
    long_mm = sum(2 * (one.along_mm + TAPE_OVER_MM) * one.count for one in plan.pieces)
    about_tape = "two strips for each piece; none where the sheet has adhesive on its back"
    tape = _only("tape")
    return [
        _line("lens-sheet", what, plan.sheet_count, "sheets", note, _sheet_row(badge)),
        _line("tape", tape.words, math.ceil(long_mm / 1000), "m", about_tape, tape),
    ]


def _mask_lines(badge: Badge, pieces: tuple[Pieces, ...], count: int) -> list[ListLine]:
    """A mask's films, one for each badge, and its spacers."""
    film, thick_mm = _only("film"), badge.lens.thickness_mm
    spacers = [_plates("spacer", thick_mm, (one.across_mm, one.along_mm), one.count) for one in pieces]
    return [_line("film", film.words, count, "sheets", f"the mask; print {film.settings}", film), *spacers]


def _paper_line(badge: Badge, people: int) -> ListLine:
    """The printed cards."""
    layout, paper = lay_out_sheets(badge), _only("paper")
    to_a_page = len(layout.places_mm)
    boards = "1 badge" if to_a_page == 1 else f"{to_a_page} badges"
    boards += " on a page" + ", and a page of pitch bands" * layout.bands_apart
    note = f"{boards}; print at {paper.settings}, {find_dpi(badge)} dpi"
    pages = with_spare(layout.pages(people))
    return _line("paper", f"{paper.words}, {paper_name(badge)}", pages, "pages", note, paper)


def _plates(key: str, thickness_mm: float, size_mm: tuple[float, float], count: int) -> ListLine:
    """Parts that a shop cuts by laser."""
    row = next(iter(materials_for("acrylic", thickness_mm=thickness_mm)), None)
    plain = "Clear acrylic" if thickness_mm >= LEAST_ACRYLIC_MM else "Clear polyester film (PET, never PVC)"
    what = row.words if row else f"{plain}, {thickness_mm:g} mm"
    note = f"each of {size_mm[0]:.0f} x {size_mm[1]:.0f} mm, by laser"
    if row is None:
        note += "; the table has no shop that stocks this thickness: ask before you order"
    return _line(f"{key}-{thickness_mm:g}mm", what, count, "parts", note, row)


def _only(kind: Kind) -> Material:
    """The first row of a kind that the table always has."""
    return next(row for row in materials() if row.kind == kind)


def _line(key: str, what: str, quantity: int, unit: str, note: str, row: Material | None) -> ListLine:
    if row is None:
        return ListLine(key, what, quantity, unit, note)
    return ListLine(key, what, quantity, unit, note, row.origins, row.unstated or "")
