"""The table of what a badge is built of: lens sheets, acrylic, paper, holders, each with the source of its figures.

The table is `materials.toml`.  A value that no source states is not in it: it is None here, and the row says what is
unstated.
"""

from __future__ import annotations

from functools import cache
from importlib import resources
from typing import Literal

import msgspec
from msgspec import Struct

MM_PER_MIL = 0.0254
#: Who states a figure of a lens sheet: derived, from figures of its row; assumed, no one.
Origin = Literal["the maker", "a shop's page", "a publication", "derived", "assumed"]
Kind = Literal["lens sheet", "acrylic", "paper", "film", "tape", "filament", "screws", "lanyard", "holder"]


class Material(Struct, frozen=True, forbid_unknown_fields=True):
    """One row of the table.

    source: where its figures come from; figures: of a lens sheet, those that each origin states; unstated: what no
    source states; label: the name for --lens, None for a material that has none; sold: whether it is a product; maker,
    article: as they name themselves, None where no source does; angle_deg: the viewing angle that the seller states;
    sizes_mm: width and height of sheets, or of what a holder holds; price: of a pack, in that currency; formats: the
    badges that it is for, none for all; settings: of the printer.
    """

    kind: Kind
    source: str
    figures: dict[Origin, str] = {}
    label: str | None = None
    sold: bool = True
    maker: str | None = None
    article: str | None = None
    lines_per_inch: float | None = None
    thickness_mm: float | None = None
    thickness_mil: float | None = None
    plastic: str | None = None
    refractive_index: float | None = None
    angle_deg: float | None = None
    sizes_mm: tuple[tuple[float, float], ...] = ()
    per_pack: int | None = None
    price: float | None = None
    currency: str | None = None
    formats: tuple[str, ...] = ()
    settings: str | None = None
    unstated: str | None = None

    @property
    def thick_mm(self) -> float | None:
        """Thickness, mm; None where no source states it."""
        return self.thickness_mm if self.thickness_mil is None else self.thickness_mil * MM_PER_MIL

    @property
    def origins(self) -> str:
        """The source, and of a lens sheet who states which figure."""
        return "; ".join([self.source, *(f"{origin}: {figures}" for origin, figures in self.figures.items())])

    @property
    def words(self) -> str:
        """What to ask a shop for."""
        if self.label is None:
            return ": ".join(filter(None, (self.maker, self.article)))
        thick = f"{self.thick_mm:.3g} mm" + (f" ({self.thickness_mil:g} mil)" if self.thickness_mil else "")
        angle = "" if self.angle_deg is None else f", viewing angle {self.angle_deg:g} degrees"
        return f"Lenticular sheet, {self.lines_per_inch:g} LPI, {thick}, {self.plastic}{angle}"


@cache
def materials() -> tuple[Material, ...]:
    """The rows of the table, in its order."""
    import tomllib

    text = resources.files("moireid").joinpath("materials.toml").read_text(encoding="utf-8")
    return msgspec.convert(tomllib.loads(text)["material"], tuple[Material, ...])


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
