"""The parts of a mount as a list: what each is made of, how large it is, and how long it takes to print.

Convention: mm, g, minutes; a size is width and height as the part is cut, or as it is on the printer's bed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from moireid.fabrication.printing_times import PRINTING_TIMES

if TYPE_CHECKING:
    from moireid.fabrication.package import Parts

PLASTIC, ACRYLIC, FILM, CARD, STEEL = "PLA or PETG", "clear acrylic", "polyester film", "card", "steel"


@dataclass(frozen=True)
class ListedPart:
    """One kind of part of a mount.

    name, material: for people; count: how many are needed; size_mm: width and height, None for screws and for what is
    printed besides the tray; thickness_mm: of what is cut, None otherwise; minutes, grams: to print all parts of a
    mount together, stated at the first of them; None where it is not known.
    """

    name: str
    material: str
    count: int
    size_mm: tuple[float, float] | None
    thickness_mm: float | None = None
    minutes: int | None = None
    grams: float | None = None


def list_parts(parts: Parts, format_name: str | None = None) -> dict[str, tuple[ListedPart, ...]]:
    """The parts of each mount that can be made: "printed", "acrylic", or both, as alternatives.

    Parameters
    ----------
    parts : Parts
        As `plan_parts` gives them.
    format_name : str, optional
        The badge's format, for printing times; None for a size of its own, whose times are not known.

    Returns
    -------
    dict of str to tuple of ListedPart
        The parts of the mounts that are made.
    """
    found: dict[str, tuple[ListedPart, ...]] = {}
    if parts.mount_plan:
        minutes, grams = PRINTING_TIMES.get((format_name or "", parts.printed), (None, None))
        plan, second = parts.mount_plan
        name = "holder" if parts.printed == "holder" else "tray"
        first = ListedPart(name, PLASTIC, 1, plan.size_mm, minutes=minutes, grams=grams)
        found["printed"] = (first, ListedPart(second.name, PLASTIC, 1, None)) if second else (first,)
    if stack := parts.acrylic:
        x0, y0, x1, y1 = stack.base.outline.bounds
        size_mm = round(x1 - x0, 2), round(y1 - y0, 2)
        cut = [
            ListedPart(plate.name, FILM if plate.name == "lips" else ACRYLIC, 1, size_mm, plate.thickness_mm)
            for plate in stack.plates
        ]
        if stack.layers:
            card_mm = stack.pad_mm / stack.layers
            page = stack.page[2] - stack.page[0], stack.page[3] - stack.page[1]
            cut.append(ListedPart("layer below the page", CARD, stack.layers, page, card_mm))
        screws = ListedPart("M3 button-head screw with nut", STEEL, len(stack.screws), None)
        found["acrylic"] = (*cut, screws)
    return found
