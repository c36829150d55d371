"""From a badge and a number of people to the lines of a shopping list: what to buy, how much of it, and why.

Of everything that is bought there is a spare share on top, as sheets are cut wrong and cards are printed twice.
Printing times are for the people alone, since a mount that fails is printed again when it does.

Source: pieces of lens sheet by `sight.sheet_pieces`, boards on a page by `event.places_mm`, plates and screws by the
plan of the acrylic stack, hours and grams by `mount_times`, products by the table of materials.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from moireid.badge import Badge
from moireid.errors import FabricationError, SpecError
from moireid.fabrication.acrylic.plates import Plate
from moireid.fabrication.assembly.assembly_words import screw_length_mm
from moireid.fabrication.event import places_mm
from moireid.fabrication.mount_parts import Parts
from moireid.fabrication.shopping.cutting import CuttingPlan, LensPiece, StockSheet, plan_cutting, with_spare
from moireid.fabrication.shopping.mount_times import MountTime, mount_times, time_words
from moireid.fabrication.sight import sheet_pieces
from moireid.materials import Kind, Material, materials, materials_for, sheet_labelled
from moireid.profiles import PAPERS_MM, find_printer

MOST_PEOPLE = 10_000
#: Of everything that is bought, so much more.
SPARE_SHARE, MOST_SPARE_SHARE = 0.05, 1.0
#: Between two parts on a plate, and from its edge, mm: what a laser shop leaves.
PART_GAP_MM = 5.0
#: Thinner plates are polyester film.
LEAST_ACRYLIC_MM = 1.0
#: Two strips of tape for each piece of lens sheet, each so much longer than the piece, mm.
TAPE_OVER_MM = 10.0
MM_PER_M, GRAMS_PER_SPOOL = 1000.0, 1000.0


@dataclass(frozen=True)
class ListLine:
    """One line: its key for --price, what to ask for, how much, and what the figures rest on.

    unit_price: as the user gave it, None for one to be filled in; note: how the quantity comes about.
    """

    key: str
    what: str
    quantity: float
    unit: str
    note: str
    source: str = ""
    unstated: str = ""
    unit_price: float | None = None

    @property
    def total(self) -> float | None:
        """Price of the line; None without a price."""
        return None if self.unit_price is None else round(self.quantity * self.unit_price, 2)

    @property
    def amount(self) -> str:
        """Quantity and unit, for people."""
        unit = self.unit.removesuffix("s") if self.quantity == 1 else self.unit
        return f"{self.quantity:,.4g} {unit}" if self.quantity < 1000 else f"{self.quantity:,.0f} {unit}"


@dataclass(frozen=True)
class ShoppingWish:
    """For how many people, with which spare share, on which sheets, at which prices.

    sheet: None for badges without a lens sheet of lenticules; made: "printed" or "acrylic", which of the two mounts is
    made; prices: of one unit, by key.
    """

    people: int
    sheet: StockSheet
    spare_share: float = SPARE_SHARE
    form: str | None = None
    made: str = "printed"
    prices: Mapping[str, float] | None = None

    def __post_init__(self) -> None:
        """Raises: SpecError for a number of people or a spare share that no event has."""
        if not 1 <= self.people <= MOST_PEOPLE:
            raise SpecError(f"{self.people} people are not possible; give 1 to {MOST_PEOPLE}")
        if not 0 <= self.spare_share <= MOST_SPARE_SHARE:
            raise SpecError(f"a spare share of {100 * self.spare_share:g} % is not possible; give 0 to 100")


@dataclass(frozen=True)
class ShoppingList:
    """All lines; cutting: of the lens sheets, None for a mask; mount: hours and grams of one printed mount, None where
    none is printed or it was not sliced; notes: what is not in the lines.
    """

    badge: Badge
    wish: ShoppingWish
    lines: tuple[ListLine, ...]
    cutting: CuttingPlan | None
    mount: MountTime | None
    notes: tuple[str, ...]

    @property
    def hours(self) -> float | None:
        """Printing time of all mounts on one printer."""
        return None if self.mount is None else self.mount.hours * self.wish.people

    @property
    def total(self) -> float | None:
        """Sum of the lines that have a price; None where none has."""
        priced = [line.total for line in self.lines if line.total is not None]
        return round(sum(priced), 2) if priced else None


def shopping_list(badge: Badge, parts: Parts, wish: ShoppingWish) -> ShoppingList:
    """What to buy for so many badges alike.

    Parameters
    ----------
    badge : Badge
        One of them; all have its layout.
    parts : Parts
        Its mounts, as `package.plan_parts` gives them.
    wish : ShoppingWish
        People, spare share, sheet, prices.

    Returns
    -------
    ShoppingList
        Lines in the order in which a badge is built.

    Raises
    ------
    FabricationError
        Where a piece does not fit the sheet, or the wished mount cannot be made.
    SpecError
        For a price of what is not on the list.
    """
    if wish.made == "acrylic" and parts.printed != "none" and parts.acrylic is None:
        raise FabricationError(f"no acrylic stack can be made: {parts.left_out['acrylic']}")
    count = with_spare(wish.people, wish.spare_share)
    lines, cutting = _front_lines(badge, wish, count)
    lines += _card_lines(badge, count, wish)
    mount: MountTime | None = None
    notes: list[str] = []
    if parts.printed == "none" and parts.acrylic is None:
        lines += _holder_lines(wish, count)
    elif wish.made == "acrylic" and parts.acrylic is not None:
        lines += _acrylic_lines(parts.acrylic.plates, count)
        if layers := parts.acrylic.layers:
            notes.append(f"each badge takes {layers} more pieces of the card, cut to its size, below the page")
        length, screws = screw_length_mm(parts.acrylic), len(parts.acrylic.screws)
        found = _only("screws")
        what = f"{found.words}, {length} mm long"
        lines.append(_line("screws", what, screws * count, "screws with nuts", f"{screws} for each badge", found))
    elif parts.printed != "none":
        mount = mount_times().get((wish.form or "", parts.printed))
        if mount is None:
            notes.append(f"the mount {parts.printed} of this size was not sliced, so its time and plastic are unknown")
        else:
            grams = math.ceil(mount.grams * count)
            note = f"{mount.grams:.3g} g for each mount, {grams / GRAMS_PER_SPOOL:.2f} spools of 1 kg"
            lines.append(_line("filament", _only("filament").words, grams, "g", note, _only("filament")))
    if parts.printed in ("lanyard", "holder") or parts.printed == "none":
        found = _only("lanyard")
        note = "one for each badge"
        note += "" if parts.printed == "none" else "; with two hooks where the mount has two slots"
        lines.append(_line("lanyard", found.words, count, "lanyards", note, found))
    notes += [f"{what} is not made: {why}" for what, why in parts.left_out.items()]
    priced = _with_prices(lines, wish.prices or {})
    return ShoppingList(badge, wish, priced, cutting, mount, tuple(notes))


def lens_pieces(badge: Badge, count: int) -> list[LensPiece]:
    """The pieces of lens sheet of so many badges, by size."""
    sizes: dict[tuple[float, float], int] = {}
    for _, corners in sheet_pieces(badge):
        # The side across the lenses comes first.
        size = (round(math.dist(corners[0], corners[1]), 3), round(math.dist(corners[1], corners[2]), 3))
        sizes[size] = sizes.get(size, 0) + 1
    names = ["piece"] if len(sizes) == 1 else [f"piece {k}" for k in range(1, len(sizes) + 1)]
    return [LensPiece(name, *size, number * count) for name, (size, number) in zip(names, sizes.items(), strict=True)]


def _front_lines(badge: Badge, wish: ShoppingWish, count: int) -> tuple[list[ListLine], CuttingPlan | None]:
    """What lies on the card: a lens sheet, or a mask's film and spacer."""
    pieces = lens_pieces(badge, count)
    if badge.lens.kind == "mask":
        film = _only("film")
        lines = [_line("film", film.words, count, "sheets", f"the mask; print {film.settings}", film)]
        plates = [(piece.across_mm, piece.along_mm, piece.count) for piece in pieces]
        return lines + _plate_lines("spacer", badge.lens.thickness_mm, plates), None
    plan = plan_cutting(pieces, wish.sheet)
    row = _sheet_row(badge)
    what = front_words(badge)
    sizes = " and ".join(f"{one.across_mm:.1f} x {one.along_mm:.1f} mm" for one in plan.wanted)
    note = (
        f"{plan.most_pieces} pieces from a sheet, of {sizes} (across the lenses x along them); "
        f"{100 * plan.waste_share:.0f} % of the sheets is waste"
    )
    side = "longer" if wish.sheet.along_mm >= wish.sheet.across_mm else "shorter"
    size = f"{wish.sheet.across_mm:g} x {wish.sheet.along_mm:g} mm, lenses along the {side} side"
    line = _line("lens-sheet", f"{what}; {size}", plan.sheet_count, "sheets", note, row)
    return [line], plan


def front_words(badge: Badge) -> str:
    """The product that lies on the card, for people: the row of the table, or the figures of another sheet."""
    if badge.lens.kind == "mask":
        return f"Line mask on clear film, over acrylic of {badge.lens.thickness_mm:g} mm"
    if (row := _sheet_row(badge)) is not None:
        return row.words
    return f"Lenticular sheet, {25.4 / badge.lens.pitch_mm:.4g} LPI, {badge.lens.thickness_mm:.3g} mm"


def _sheet_row(badge: Badge) -> Material | None:
    """The row that the badge was designed for; None for a measured sheet, or another thickness."""
    label = (badge.print or {}).get("lens")
    row = sheet_labelled(label) if isinstance(label, str) and badge.lens.kind == "lenticular" else None
    if row is None or row.thick_mm is None or abs(row.thick_mm - badge.lens.thickness_mm) > 1e-6:
        return None
    return row


def _card_lines(badge: Badge, count: int, wish: ShoppingWish) -> list[ListLine]:
    """The printed card, and the tape that holds the lens sheet on it."""
    to_a_page = len(places_mm(badge))
    pages = math.ceil(wish.people / to_a_page)
    paper, tape = _only("paper"), _only("tape")
    name = next((name.upper() for name, size in PAPERS_MM.items() if size == badge.page_mm), "of the page's size")
    dpi = find_printer(badge).dpi
    boards = "1 badge" if to_a_page == 1 else f"{to_a_page} badges"
    note = f"{boards} on a page; print at {paper.settings}, {dpi} dpi"
    what = f"{paper.words}, {name}"
    lines = [_line("paper", what, with_spare(pages, wish.spare_share), "pages", note, paper)]
    if badge.lens.kind != "mask":
        long_mm = sum(2 * (one.along_mm + TAPE_OVER_MM) * one.count for one in lens_pieces(badge, count))
        note = "two strips for each piece; none where the sheet has adhesive on its back"
        lines.append(_line("tape", tape.words, math.ceil(long_mm / MM_PER_M), "m", note, tape))
    return lines


def _holder_lines(wish: ShoppingWish, count: int) -> list[ListLine]:
    """A bought holder of that format's size, where holders are sold for it."""
    if wish.form is None or not (found := materials_for("holder", form=wish.form)):
        return []
    width, high = found[0].sizes_mm[0]
    note = f"for a card of {width:g} x {high:g} mm with a lens sheet on it; try one before you buy all"
    if (printed := mount_times().get((wish.form, "holder"))) is not None:
        note += f"; printed (--mount holder), each takes {time_words(printed.hours)} and {printed.grams:.3g} g"
    return [_line("holder", found[0].words, count, "holders", note, found[0])]


def _acrylic_lines(plates: Iterable[Plate], count: int) -> list[ListLine]:
    """The plates of a stack, by thickness."""
    by_mm: dict[float, list[tuple[float, float, int]]] = {}
    for plate in plates:
        x0, y0, x1, y1 = plate.outline.bounds
        by_mm.setdefault(plate.thickness_mm, []).append((x1 - x0, y1 - y0, count))
    lines: list[ListLine] = []
    for thickness_mm, parts in by_mm.items():
        lines += _plate_lines("acrylic", thickness_mm, parts)
    return lines


def _plate_lines(key: str, thickness_mm: float, parts: list[tuple[float, float, int]]) -> list[ListLine]:
    """Plates of one thickness: parts in rows, turned if more fit so."""
    stocked = materials_for("acrylic", thickness_mm=thickness_mm)
    size_mm = next((size for row in [*stocked, *materials_for("acrylic")] for size in row.sizes_mm), None)
    assert size_mm is not None, "the table of materials has an acrylic sheet with a size"
    plates, to_a_plate = 0, []
    for wide, high, number in parts:
        most = max(_in_rows(size_mm, (wide, high)), _in_rows(size_mm, (high, wide)))
        if most == 0:
            raise FabricationError(
                f"an acrylic part of {wide:.0f} x {high:.0f} mm does not fit a plate of {size_mm[0]:g} x "
                f"{size_mm[1]:g} mm; have the shop cut it from a larger plate, and list it without --made acrylic"
            )
        to_a_plate.append(f"{most} parts of {wide:.0f} x {high:.0f} mm")
        plates += math.ceil(number / most)
    row = stocked[0] if stocked else None
    plain = "Clear acrylic" if thickness_mm >= LEAST_ACRYLIC_MM else "Clear polyester film (PET, never PVC)"
    what = row.words if row else f"{plain}, {thickness_mm:g} mm"
    note = f"plates of {size_mm[0]:g} x {size_mm[1]:g} mm, from each {' or '.join(to_a_plate)}, by laser"
    if row is None:
        note += "; the table has no shop that stocks this thickness: ask before you order"
    elif not row.sizes_mm:
        note += "; no source states this sheet's sizes"
    return [_line(f"{key}-{thickness_mm:g}mm", what, plates, "plates", note, row)]


def _in_rows(plate: tuple[float, float], part: tuple[float, float]) -> int:
    """How many parts fit in rows on a plate, with the laser shop's gap around each."""
    across, along = (
        int((side - PART_GAP_MM + 1e-6) // (own + PART_GAP_MM)) for side, own in zip(plate, part, strict=True)
    )
    return max(across, 0) * max(along, 0)


def _only(kind: Kind) -> Material:
    """The first row of a kind that the table always has."""
    return next(row for row in materials() if row.kind == kind)


def _line(key: str, what: str, quantity: float, unit: str, note: str, row: Material | None) -> ListLine:
    if row is None:
        return ListLine(key, what, quantity, unit, note, unstated="maker, article, price")
    return ListLine(key, what, quantity, unit, note, row.source, row.unstated or "")


def _with_prices(lines: list[ListLine], prices: Mapping[str, float]) -> tuple[ListLine, ...]:
    """The lines with the user's prices.  Raises: SpecError for a price of what is not on the list."""
    keys = [line.key for line in lines]
    for key, price in prices.items():
        if key not in keys:
            raise SpecError(f"price of {key[:40]!r}: that is not on this list; choose one of {', '.join(keys)}")
        if not (math.isfinite(price) and price >= 0):
            raise SpecError(f"price {key}={price:g} is not possible; give 0 or more")
    return tuple(replace(line, unit_price=prices.get(line.key)) for line in lines)
