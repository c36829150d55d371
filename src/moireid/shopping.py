"""From a badge, or a format alone, to its shopping list, for `moireid materials`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from moireid.errors import FabricationError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.fabrication.shopping.shopping_list import ShoppingList

#: A lens sheet where none is given, mm across the lenses and along them: A4, its lenses along the longer side.
ASSUMED_MM = (210.0, 297.0)


def usual_badge(form: str, lens: str | None = None, paper: str = "a4") -> Badge:
    """A badge of that format, as `print-your-badge` designs it, of the identity 0, as its layout alone counts.

    Parameters
    ----------
    form : str
        Name of a format.
    lens : str, optional
        Label or file of a lens sheet; None for that of the format.
    paper : str
        One of `profiles.PAPERS_MM`.

    Raises
    ------
    SpecError
        For an unknown format or sheet.
    DesignError
        Where nothing works.
    """
    from moireid.designer import Order, design_badge
    from moireid.issuing import fitted

    order, _ = fitted(Order("Everybody", format=form, lens=lens, paper=paper))
    return design_badge(order, bytes(8))


def list_for(
    badge: Badge,
    people: int = 1,
    *,
    mount: str | None = None,
    sheet_mm: tuple[float, float] | None = None,
) -> ShoppingList:
    """What to buy for so many badges alike, with notes on mount and lens sheets.

    Parameters
    ----------
    badge : Badge
        One of them.
    people : int
        How many.
    mount : {"lanyard", "clip", "stand", "acrylic", "none"}, optional
        What holds the badges, printed but for acrylic; None for none where holders of that size are sold, else the
        lanyard's.
    sheet_mm : (float, float), optional
        Sides of a lens sheet across and along its lenses, mm; None for `ASSUMED_MM`, and a note.

    Raises
    ------
    FabricationError
        Where a piece does not fit the sheet, or the mount cannot be made.
    SpecError
        For a number of people that no event has.
    """
    from moireid.designer import Order
    from moireid.designer.formats import LENSES_MM, by_lens, format_of
    from moireid.designer.reach import verdict_reach_m
    from moireid.fabrication.shopping.shopping_list import shopping_list
    from moireid.issuing import choose_parts
    from moireid.materials import materials_for

    form = format_of(badge.outline_mm)
    kind = mount or ("none" if form is not None and materials_for("holder", form=form) else "lanyard")
    order = Order("Everybody", format=form, mount="lanyard" if kind == "acrylic" else kind)
    parts, note = choose_parts(badge, order)
    if kind == "acrylic" and parts.acrylic is None:
        raise FabricationError(f"no acrylic stack can be made: {parts.left_out['acrylic']}; give another mount")
    parts = replace(parts, printed="none") if kind == "acrylic" else replace(parts, acrylic=None)
    found = shopping_list(badge, parts, people, sheet_mm or ASSUMED_MM, form=form)
    notes = [note] if note and kind != "acrylic" else []
    if found.cutting is not None and sheet_mm is None:
        notes.append(
            f"lens sheets of {ASSUMED_MM[0]:g} x {ASSUMED_MM[1]:g} mm are assumed, as no source states which sizes are "
            "sold; ask your shop for size and direction of the lenses, and give them (sheet_mm)"
        )
    title = found.title
    if badge.range_m is not None:
        spans = [f"{span} ({mm:g} mm)" for span, mm in zip(by_lens(badge.range_m), LENSES_MM, strict=True)]
        title += f" Judged in films of 1080p, by the camera's lens (27 mm: a phone): {', '.join(spans)}."
        if badge.range_m[1] > (swaying_m := verdict_reach_m(badge)):
            title += f" Beyond {swaying_m:.1f} m from a phone, move it more than by swaying."
    return replace(found, title=title, notes=(*notes, *found.notes))
