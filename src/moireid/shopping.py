"""From a badge, or a format alone, to its shopping list, for `moireid materials` and for the studio."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from moireid.errors import FabricationError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.fabrication.shopping.cutting import CuttingPlan
    from moireid.fabrication.shopping.needs import ShoppingList, ShoppingWish
    from moireid.materials import Material

#: A lens sheet where none is given, mm across the lenses and along them: A4, its lenses along the longer side.
ASSUMED_MM = (210.0, 297.0)


def usual_badge(form: str, lens: str | None = None, orientation: str | None = None) -> Badge:
    """A badge of that format, as `print-your-badge` designs it.

    Parameters
    ----------
    form : str
        Name of a format.
    lens : str, optional
        Label or file of a lens sheet; None for that of the format.
    orientation : {"landscape", "portrait"}, optional
        None for what is usual for the format.

    Returns
    -------
    Badge
        Of the identity 0, as its layout alone counts.

    Raises
    ------
    SpecError
        For an unknown format or sheet.
    DesignError
        Where nothing works.
    """
    from moireid.designer import Request, design_badge
    from moireid.issuing import Wear

    wear = Wear(form, orientation, None, lens, None, None, (), None, None, None)
    return design_badge(wear.fit(Request("Everybody")), bytes(8))


def list_for(badge: Badge, wish: ShoppingWish, mount: str | None, *, assumed: bool) -> ShoppingList:
    """What to buy for so many badges alike, with notes on mount and lens sheets.

    Parameters
    ----------
    badge : Badge
        One of them.
    wish : ShoppingWish
        People, spare share, sheet, format, prices.
    mount : {"lanyard", "clip", "stand", "holder", "none"}, optional
        What holds the badges; None for none where holders of that size are sold and no acrylic is wished, else the
        lanyard's.
    assumed : bool
        Whether the size of the lens sheets is `ASSUMED_MM` because none was given.

    Returns
    -------
    ShoppingList
        As `needs.shopping_list` gives it, with more notes.

    Raises
    ------
    FabricationError
        Where a piece does not fit the sheet, or the mount cannot be made.
    SpecError
        For a price of what is not on the list.
    """
    from moireid.fabrication.process_figures import MountFigures
    from moireid.fabrication.shopping.needs import shopping_list
    from moireid.issuing import Wear
    from moireid.materials import materials_for

    if mount is None:
        sold = wish.form is not None and bool(materials_for("holder", form=wish.form))
        mount = "none" if sold and wish.made == "printed" else "lanyard"
    wear = Wear(wish.form, None, None, None, None, None, (), None, None, None)
    parts, about_mount = wear.parts(badge, mount, MountFigures())
    found = shopping_list(badge, parts, wish)
    notes = [*filter(None, [about_mount]), *found.notes]
    if found.cutting is not None:
        notes += _sheet_notes(found.cutting, badge, assumed=assumed)
    return replace(found, notes=tuple(notes))


def _sheet_notes(plan: CuttingPlan, badge: Badge, *, assumed: bool) -> list[str]:
    """What to know about the sheets: a size that is assumed, a direction that gives more, articles of that pitch."""
    from moireid.fabrication.shopping.cutting import plan_cutting

    notes = []
    if assumed:
        notes.append(
            f"lens sheets of {ASSUMED_MM[0]:g} x {ASSUMED_MM[1]:g} mm are assumed, as no source states which sizes are "
            "sold; ask your shop for size and direction of the lenses, and give them as --sheet-size"
        )
    try:
        turned = plan_cutting(plan.wanted, plan.sheet.turned)
    except FabricationError:
        turned = plan
    if turned.sheet_count < plan.sheet_count:
        size = f"{plan.sheet.along_mm:g}x{plan.sheet.across_mm:g}"
        notes.append(
            f"sheets whose lenses run along the other side would be {turned.sheet_count}, not {plan.sheet_count}: if "
            f"your shop has them, give --sheet-size {size}"
        )
    return notes + [
        f"also sold: {row.words} ({row.source}); not stated: {row.unstated}. Measure its thickness and print badges "
        "for it with --lens-thickness"
        for row in _articles_like(badge)
    ]


def _articles_like(badge: Badge) -> list[Material]:
    """Lens sheets of a maker that have the badge's lenses to the inch, within a hundredth."""
    from moireid.materials import materials_for
    from moireid.sheets import MM_PER_INCH

    lines = MM_PER_INCH / badge.lens.pitch_mm
    articles = (row for row in materials_for("lens sheet") if row.maker and row.lines_per_inch is not None)
    return [row for row in articles if abs((row.lines_per_inch or 0.0) / lines - 1) < 0.01]
