"""All files of a shopping list: made in a temporary folder, read back, and moved into place together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from moireid.fabrication.package import made_aside
from moireid.fabrication.shopping.list_files import write_list_csv, write_list_pdf
from moireid.fabrication.shopping.needs import ShoppingList
from moireid.fabrication.shopping.plan_files import check_plan_dxf, write_plan_dxf, write_plan_pdf
from moireid.files import AnyPath

LIST_FILES = ("shopping-list.pdf", "shopping-list.csv")
PLAN_FILES = ("cutting-plan.pdf", "cutting-plan.dxf")


def write_shopping(
    found: ShoppingList, folder: Path, *, overwrite: bool = False, kept: Sequence[AnyPath] = ()
) -> dict[str, Path]:
    """Write the list, and the cutting plan where lens sheets are cut.

    Parameters
    ----------
    found : ShoppingList
        What `needs.shopping_list` gives.
    folder : Path
        Made where it is absent.
    overwrite : bool
        Replace older files.
    kept : sequence of str or Path
        Input files, which are never replaced.

    Returns
    -------
    dict of str to Path
        Path by name.

    Raises
    ------
    SpecError
        Where a file exists or cannot be written.
    FabricationError
        Where the drawing fails its check.
    MissingExtraError
        Without the CAD packages, which the drawing needs.
    """
    names = [*LIST_FILES, *(PLAN_FILES if found.cutting is not None else ())]
    with made_aside(folder, names, (), overwrite=overwrite, kept=kept, before_moving=None) as aside:
        write_list_pdf(found, aside / LIST_FILES[0])
        write_list_csv(found, aside / LIST_FILES[1])
        if found.cutting is not None:
            write_plan_pdf(found.cutting, aside / PLAN_FILES[0])
            write_plan_dxf(found.cutting, aside / PLAN_FILES[1])
            check_plan_dxf(aside / PLAN_FILES[1], found.cutting)
    return {name: folder / name for name in names}
