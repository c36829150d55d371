"""The table of what a badge is built of: lens sheets, acrylic, paper, holders, each with the source of its figures.

The table is `materials.toml`.  A value that no source states is not in it: it is None here, and the row says what is
unstated.  `sheets.PRODUCTS` are the rows of lens sheets that have a label.
"""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta, Struct

from moireid.errors import SpecError
from moireid.models import check_format, read_model

MM_PER_MIL = 0.0254
TABLE = Path(__file__).with_name("materials.toml")
TABLE_FORMAT = 1
Kind = Literal["lens sheet", "acrylic", "paper", "film", "tape", "filament", "screws", "lanyard", "holder"]
Positive = Annotated[float, Meta(gt=0)]
Words = Annotated[str, Meta(min_length=1)]


class Material(Struct, frozen=True, forbid_unknown_fields=True):
    """One row of the table.

    source: where its figures come from; unstated: what no source states; label: the name for --lens, None for a
    material that has none; sold: whether it is a product; maker, article: as they name themselves, None where no source
    does; angle_deg: the viewing angle that the seller states; sizes_mm: width and height of sheets, or of what a holder
    holds; price: of a pack, in that currency; formats: the badges that it is for, none for all; settings: of the
    printer.
    """

    kind: Kind
    source: Words
    label: Words | None = None
    sold: bool = True
    maker: Words | None = None
    article: Words | None = None
    lines_per_inch: Positive | None = None
    thickness_mm: Positive | None = None
    thickness_mil: Positive | None = None
    plastic: Words | None = None
    refractive_index: Annotated[float, Meta(ge=1.2, le=2)] | None = None
    angle_deg: Annotated[float, Meta(gt=0, lt=180)] | None = None
    sizes_mm: tuple[tuple[Positive, Positive], ...] = ()
    per_pack: Annotated[int, Meta(ge=1)] | None = None
    price: Positive | None = None
    currency: Annotated[str, Meta(pattern="^[A-Z]{3}$")] | None = None
    formats: tuple[Words, ...] = ()
    settings: Words | None = None
    unstated: Words | None = None

    def __post_init__(self) -> None:
        """Raises: ValueError for figures that contradict each other, or a row that names nothing to buy."""
        if self.thickness_mm is not None and self.thickness_mil is not None:
            raise ValueError("thickness_mm and thickness_mil are both given; give the one that the source states")
        if (self.price is None) != (self.currency is None):
            raise ValueError("price and currency go together; give both or none")
        if self.label is None and self.article is None:
            raise ValueError("label and article are both missing; name what one can buy")
        if self.label is not None and (self.lines_per_inch is None or self.thick_mm is None or self.plastic is None):
            raise ValueError(f"label {self.label} needs lines_per_inch, a thickness and the plastic")

    @property
    def thick_mm(self) -> float | None:
        """Thickness, mm; None where no source states it."""
        return self.thickness_mm if self.thickness_mil is None else self.thickness_mil * MM_PER_MIL

    @property
    def words(self) -> str:
        """What to ask a shop for."""
        if self.label is None:
            return ": ".join(filter(None, (self.maker, self.article)))
        thick = f"{self.thick_mm:.3g} mm" + (f" ({self.thickness_mil:g} mil)" if self.thickness_mil else "")
        angle = "" if self.angle_deg is None else f", viewing angle {self.angle_deg:g} degrees"
        return f"Lenticular sheet, {self.lines_per_inch:g} LPI, {thick}, {self.plastic}{angle}"


class MaterialTable(Struct, frozen=True, forbid_unknown_fields=True):
    """The file.  Raises: ValueError where two rows have one label."""

    format: Literal[1]
    material: tuple[Material, ...]

    def __post_init__(self) -> None:
        labels = [one.label for one in self.material if one.label is not None]
        twice = sorted({label for label in labels if labels.count(label) > 1})
        if twice:
            raise ValueError(f"label {twice[0]} is given twice; give each label once")


def read_materials(path: Path) -> tuple[Material, ...]:
    """The rows of a table.  Raises: SpecError with the place of the first fault."""
    source, advice = f"table of materials {path.name}", "correct it"
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise SpecError(f"{source} cannot be read ({error}); {advice}") from error
    check_format(document, TABLE_FORMAT, source)
    return read_model(document, MaterialTable, source, advice).material


@cache
def materials() -> tuple[Material, ...]:
    """The rows of the table that comes with the package, in its order."""
    return read_materials(TABLE)


def materials_for(kind: Kind, *, form: str | None = None, thickness_mm: float | None = None) -> list[Material]:
    """Products of a kind, those of a named maker first.

    Parameters: form: those for badges of this format alone; thickness_mm: those as thick as that.
    """
    found = [one for one in materials() if one.kind == kind and one.sold]
    if form is not None:
        found = [one for one in found if not one.formats or form in one.formats]
    if thickness_mm is not None:
        found = [one for one in found if one.thick_mm is not None and abs(one.thick_mm - thickness_mm) < 0.05]
    return sorted(found, key=lambda one: one.maker is None)


def sheet_labelled(label: str) -> Material | None:
    """The lens sheet of a label; None where it is no label, as the file of a lens profile."""
    return next((one for one in materials() if one.label == label.lower()), None)
