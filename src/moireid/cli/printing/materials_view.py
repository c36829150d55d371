"""How moireid materials shows a shopping list, and the table of products."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.cli.common import echo, show_json

if TYPE_CHECKING:
    from moireid.fabrication.shopping.needs import ShoppingList
    from moireid.materials import Material

#: Width of what is written on a terminal.
WIDE = 100


def list_document(found: ShoppingList, files: dict[str, Path]) -> dict[str, Any]:
    """What --json prints."""
    plan, mount = found.cutting, found.mount
    return {
        "people": found.wish.people,
        "format": found.wish.form,
        "spare_share": found.wish.spare_share,
        "lines": [
            {
                "key": line.key,
                "what": line.what,
                "quantity": line.quantity,
                "unit": line.unit,
                "unit_price": line.unit_price,
                "total": line.total,
                "note": line.note,
                "source": line.source,
                "not_stated": line.unstated,
            }
            for line in found.lines
        ],
        "total": found.total,
        "mount": None
        if mount is None
        else {"hours_each": mount.hours, "grams_each": mount.grams, "hours": found.hours},
        "cutting": None
        if plan is None
        else {
            "sheet_mm": [plan.sheet.across_mm, plan.sheet.along_mm],
            "sheets": plan.sheet_count,
            "pieces_to_a_sheet": plan.most_pieces,
            "waste_share": plan.waste_share,
        },
        "notes": list(found.notes),
        "files": {name: str(path) for name, path in files.items()},
    }


def show_list(found: ShoppingList, files: dict[str, Path]) -> None:
    """The list as a table, and where the files are."""
    from moireid.fabrication.shopping.list_files import heading_lines

    for words in heading_lines(found):
        echo(words)
    echo()
    amounts = [line.amount for line in found.lines]
    width = max(map(len, amounts))
    for line, amount in zip(found.lines, amounts, strict=True):
        price = "" if line.total is None else f"  {line.total:,.2f}"
        _show_wrapped(f"{amount:>{width}}  ", f"{line.what}{price}")
        _show_wrapped(" " * (width + 2), f"[{line.key}] {line.note}")
    echo()
    for path in files.values():
        echo(f"  {path}")
    if not files:
        echo("Give --out FOLDER for the list as PDF and CSV, and for the cutting plan as PDF and DXF.")


def _show_wrapped(lead: str, words: str) -> None:
    """Text in lines as wide as a terminal, below its lead."""
    for line in textwrap.wrap(words, WIDE, initial_indent=lead, subsequent_indent=" " * len(lead)):
        echo(line)


def show_table(as_json: bool) -> None:
    """All products, by kind, with their sources."""
    from msgspec import to_builtins

    from moireid.materials import materials

    rows = materials()
    if as_json:
        show_json({"materials": [to_builtins(row) for row in rows]})
        return
    for kind in dict.fromkeys(row.kind for row in rows):
        echo(f"{kind[0].upper()}{kind[1:]}")
        for row in rows:
            if row.kind == kind:
                _show_row(row)
    echo("For a shopping list: moireid materials --format a6 --people 40 --out shopping")


def _show_row(row: Material) -> None:
    """One product: what to ask for, its source, and what no source states."""
    lead = f"  {row.label or '':<14}"
    shape = "" if row.sold else " (no product: a shape that older badges have)"
    sizes = "" if not row.sizes_mm else "; " + ", ".join(f"{wide:g} x {high:g} mm" for wide, high in row.sizes_mm)
    price = "" if row.price is None else f"; {row.price:g} {row.currency} for {row.per_pack or 1}"
    _show_wrapped(lead, f"{row.words}{sizes}{price}{shape}")
    _show_wrapped(" " * len(lead), f"source: {row.source}")
    if row.unstated:
        _show_wrapped(" " * len(lead), f"not stated: {row.unstated}")
