"""What a visitor asks for: the fields of the Issue page and of the API, and their checks.

The wish is checked by the same functions as in `print-your-badge`, so both refuse it with the same sentence.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from moireid.badge import Badge
from moireid.designer import Request, explain, payload_from_hex
from moireid.designer.drawn import drawn_badge
from moireid.designer.link import LinkBudget
from moireid.designer.reach import link_budgets
from moireid.designer.request import clean_name, parse_range_m
from moireid.errors import RegistryError, SpecError
from moireid.fabrication.page.lettering import name_note
from moireid.fabrication.parts import plan_parts
from moireid.idcodes import is_name_derived
from moireid.registry import Record, Registry

#: Labels alone: the library would take the path of a lens profile too, and no visitor names a path.
LensLabel = Literal[
    "40lpi",
    "50lpi",
    "60lpi",
    "75lpi",
    "20lpi-2mm",
    "30lpi-47mil",
    "40lpi-33mil",
    "40lpi-2mm",
    "60lpi-1.2mm",
    "62lpi-27mil",
    "75lpi-18mil",
    "100lpi-14mil",
]
Mount = Literal["lanyard", "clip", "stand", "none"]


class Wish(BaseModel):
    """How badges are to be made; the defaults are those of `print-your-badge`."""

    model_config = ConfigDict(extra="forbid")

    lens: LensLabel = Field("50lpi", description="Lenticular sheet, lenses per inch.")
    lens_thickness_mm: float | None = Field(
        None, gt=0, le=20, allow_inf_nan=False, description="Thickness of the sheet by a calliper, mm."
    )
    printer_dpi: int = Field(1200, ge=72, le=9600, description="Printer's dots per inch.")
    paper: Literal["a4", "letter"] = "a4"
    near_m: float = Field(0.8, gt=0, le=100, allow_inf_nan=False, description="Nearest camera, metres.")
    far_m: float = Field(2.5, gt=0, le=100, allow_inf_nan=False, description="Farthest camera, metres.")
    axes: Literal["x", "xy", "hex"] = Field("x", description="Directions that the fringes sense.")
    width_mm: float = Field(146.0, gt=0, le=1000, allow_inf_nan=False, description="Board's width, mm.")
    height_mm: float = Field(160.0, gt=0, le=1000, allow_inf_nan=False, description="Board's height, mm.")
    mount: Mount = Field("lanyard", description="What carries the badge.")

    def request(self, name: str) -> Request:
        """The library's request for a person of that name.  Raises: SpecError as `clean_name`, `parse_range_m`."""
        return Request(
            clean_name(name),
            self.lens,
            self.printer_dpi,
            self.paper,
            parse_range_m(f"{self.near_m:g}-{self.far_m:g}"),
            (self.width_mm, self.height_mm),
            "spacing",
            self.axes,
            lens_thickness_mm=self.lens_thickness_mm,
        )


class Order(Wish):
    """One person's badge."""

    name: str = Field(max_length=2000, description="The person's name; 200 letters at most are set on a badge.")
    payload: str = Field("", max_length=200, description="The identity, 16 or 32 hex digits; else one is drawn.")

    def chosen(self) -> bytes | None:
        """The payload that is asked for.  Raises: CodeError where it is none."""
        return payload_from_hex(self.payload.strip(), family="spacing") if self.payload.strip() else None

    def of(self, badge: Badge) -> Order:
        """The order of this very badge, so that whoever makes it draws no other identity."""
        return self.model_copy(update={"payload": badge.id})


@dataclass(frozen=True)
class Checked:
    """A badge that can be made, and what the visitor should know about it.

    rows: as `print-your-badge --explain`; links: link budget at each end of the range; holder: who already has this
    same badge; namesakes: other badges issued to the name; look_alikes: badges of people whose names look like it;
    files: names in the package; left_out: which of the two mounts cannot be made, and why; note: about letters of a
    name that no font has; name_derived: whether everyone who knows the name can print this badge.
    """

    badge: Badge
    rows: list[tuple[str, str]]
    links: list[tuple[float, LinkBudget]]
    holder: Record | None
    namesakes: list[Record]
    look_alikes: list[Record]
    files: tuple[str, ...]
    left_out: dict[str, str] = field(default_factory=dict)
    note: str | None = None
    name_derived: bool = False

    @property
    def to_read(self) -> str | None:
        """What the issuer must have read before this badge is issued, as a mark of it; None where there is nothing."""
        told = self.holder or self.namesakes or self.look_alikes or self.name_derived
        return f"{self.badge.id} {self.badge.name}" if told else None


def checked(order: Order, registry: Registry) -> Checked:
    """The badge of an order, if it can be made; nothing is issued.

    Raises: SpecError, DesignError, CodeError, FabricationError or RegistryError, as the command does.
    """
    badge = drawn_badge(order.request(order.name), order.chosen(), registry.by_id).badge
    holder = registry.by_id(badge.id or "")
    if holder is not None and holder.badge != badge:
        raise RegistryError(
            f"badge {badge.id} is held by {holder.name!r} already, and is another badge; give another identity"
        )
    parts = plan_parts(badge, order.mount)
    namesakes = [record for record in named(registry, badge.name) if record.id != badge.id]
    return Checked(
        badge,
        explain(badge),
        link_budgets(badge),
        holder,
        namesakes,
        registry.look_alikes([badge.name]).get(badge.name, []),
        parts.files,
        parts.left_out,
        name_note(badge.name),
        is_name_derived(badge),
    )


def named(registry: Registry, name: str) -> list[Record]:
    """Every record of exactly that name.  Raises: RegistryError where a record is not to be believed."""
    try:
        return [record for record in [registry.find(name)] if record.name == name]
    except RegistryError as error:
        # Nobody, or several: the error says which.
        ids = error.details.get("ids")
        if not isinstance(ids, list):
            raise
        found = [registry.by_id(badge_id) for badge_id in ids]
        return [record for record in found if record is not None and record.name == name]


def read_fields(model: type[Wish], fields: Mapping[str, str]) -> Any:
    """A wish or an order from a form: empty fields keep their defaults, and unknown fields are ignored.

    Raises: SpecError that names the first field which cannot be used, and what it may be.
    """
    known = model.model_fields
    given = {key: value.strip() if key != "name" else value for key, value in fields.items() if key in known}
    try:
        return model.model_validate({key: value for key, value in given.items() if value or key == "name"})
    except ValidationError as error:
        first = error.errors()[0]
        key = str(first["loc"][0])
        words = first["msg"][0].lower() + first["msg"][1:]
        shown = str(first.get("input", ""))[:40]
        raise SpecError(f"{LABELS.get(key, key)} {shown!r} cannot be used: {words}; correct that field") from error


#: The fields' names in messages for people.
LABELS = {
    "lens": "lens sheet",
    "lens_thickness_mm": "sheet thickness",
    "printer_dpi": "printer resolution",
    "near_m": "nearest camera",
    "far_m": "farthest camera",
    "width_mm": "board width",
    "height_mm": "board height",
    "axes": "fringes",
}
