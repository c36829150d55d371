"""What a visitor asks for: the order of the Issue page and of the API, and its checks.

The order is checked by the same functions as in `print-your-badge`, so both refuse it with the same sentence.  No field
names a file of the server: sheets and templates are those that come with the program, and pictures are handed in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError

from moireid.artwork.template import TEMPLATES
from moireid.designer import Order, explain
from moireid.designer.formats import FORMATS, format_named
from moireid.designer.order import MountFigure
from moireid.designer.reach import LinkBudget, link_budgets
from moireid.errors import SpecError
from moireid.issuing import Package, plan_badge
from moireid.names import MOST_LINES
from moireid.profiles import PAPERS_MM
from moireid.registry import Record, Registry
from moireid.sheets import PRODUCTS

#: Labels and names alone: the library would take the path of a lens profile or template too, and no visitor names one.
if TYPE_CHECKING:
    LensLabel = str
    FormatName = str
    TemplateName = str
    PaperName = str
else:
    LensLabel, FormatName, TemplateName = Literal[tuple(PRODUCTS)], Literal[tuple(FORMATS)], Literal[TEMPLATES]
    PaperName = Literal[tuple(PAPERS_MM)]
Mount = Literal["lanyard", "clip", "stand", "none"]
#: As the answer to the pictures says.
PictureId = Annotated[str, Field(pattern="^[0-9a-f]{32}$", description="As `POST /api/badges/pictures` gave it.")]
Millimetres = Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)]
#: Fields of a form that are pairs of an order.
PAIRS = {"range_m": ("near_m", "far_m"), "size_mm": ("width_mm", "height_mm")}


def _without_ours(schema: dict[str, Any]) -> None:
    """Leave out of the schema what no visitor chooses."""
    for one in fields(VisitorOrder):
        if not one.init:
            del schema["properties"][one.name]


@dataclass(frozen=True)
class VisitorOrder(Order):
    """An order for one badge, or for all of a list; the fields of `moireid.Order`, and what is left out is as there."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid", ser_json_bytes="hex", json_schema_extra=_without_ours)

    name: Annotated[str, Field(max_length=2000)]
    format: FormatName | None = None
    orientation: Literal["landscape", "portrait"] | None = None
    lens: LensLabel | None = None
    lens_thickness_mm: Annotated[float, Field(gt=0, le=20)] | None = None
    printer_dpi: Annotated[int, Field(ge=72, le=9600)] = 1200
    paper: PaperName = "a4"
    axes: Literal["x", "xy", "hex"] = "x"
    markers: Literal["squares", "frame"] = "squares"
    template: TemplateName | None = None
    lines: Annotated[Sequence[Annotated[str, Field(max_length=2000)]], Field(max_length=4 * MOST_LINES)] = ()
    logo: PictureId | None = None
    portrait: PictureId | None = None
    colour: Annotated[str, Field(max_length=100)] | None = None
    payload: Annotated[str, Field(max_length=200)] | bytes | None = None
    mount: Mount | None = None
    # These are no visitor's to choose.
    ink_growth_um: float = field(default=0.0, init=False)
    code: str | None = field(default=None, init=False)
    form: str = field(default="dots", init=False)
    front: str = field(default="lens", init=False)
    pattern: str | None = field(default=None, init=False)
    head: float = field(default=0.0, init=False)
    foot: float = field(default=0.0, init=False)
    mount_mm: Mapping[str, MountFigure] = field(default_factory=dict, init=False)

    def with_files(self, pictures: Mapping[str, Path]) -> Order:
        """The library's order; pictures: files of ours, by "logo" and "portrait"."""
        given = {one.name: getattr(self, one.name) for one in fields(Order)}
        return Order(**given | {what: pictures.get(what) for what in ("logo", "portrait")})


#: Reads and writes an order as JSON.
ORDERS = TypeAdapter(VisitorOrder)


@dataclass(frozen=True)
class CheckedOrder:
    """A badge that can be made, and what the visitor should know about it.

    rows: as `print-your-badge --explain`; links: link budget at each end of the range; namesakes: other badges issued
    to the name; look_alikes: badges of people whose names look like it.
    """

    plan: Package
    rows: list[tuple[str, str]]
    links: list[tuple[float, LinkBudget]]
    namesakes: list[Record]
    look_alikes: list[Record]

    @property
    def to_read(self) -> str | None:
        """What the issuer must have read before this badge is issued, as a mark of it; None where there is nothing."""
        notable = self.plan.holder or self.namesakes or self.look_alikes
        return f"{self.plan.badge.id} {self.plan.badge.name}" if notable else None


def checked(order: VisitorOrder, registry: Registry, pictures: Mapping[str, Path]) -> CheckedOrder:
    """The badge of an order, if it can be made, and all that is known of it; nothing is issued.

    Parameters
    ----------
    pictures
        As for `VisitorOrder.with_files`.

    Notes
    -----
    Raises: SpecError, DesignError, CodeError, FabricationError or RegistryError, as the command does.
    """
    plan = plan_badge(order.with_files(pictures), registry.by_id)
    badge = plan.badge
    namesakes = [record for record in registry.named(badge.name) if record.id != badge.id]
    look_alikes = registry.look_alikes([badge.name]).get(badge.name, [])
    return CheckedOrder(plan, explain(badge), link_budgets(badge), namesakes, look_alikes)


def read_order(given: Mapping[str, str]) -> VisitorOrder:
    """The order of a form, where a pair of numbers is two fields.  Raises: SpecError as `read_fields`."""
    form = format_named(given.get("format") or None)
    texts: dict[str, Any] = {
        key: value for key, value in given.items() if not any(key in two for two in PAIRS.values())
    }
    for what, names in PAIRS.items():
        typed = [given.get(name, "").strip().replace(",", ".") for name in names]
        if any(typed):
            texts[what] = [one or other for one, other in zip(typed, getattr(form, what), strict=True)]
    if "lines" in texts:
        texts["lines"] = [line.strip() for line in texts["lines"].splitlines() if line.strip()]
    order: VisitorOrder = read_fields(VisitorOrder, texts)
    return order


def read_fields(model: type[Any], given: Mapping[str, Any]) -> Any:
    """An order or another model from a form: empty fields keep their defaults, and unknown fields are ignored.

    Raises: SpecError that names the first field which cannot be used, and what it may be.
    """
    known = getattr(model, "model_fields", None) or model.__dataclass_fields__
    texts = {
        key: value.strip() if isinstance(value, str) and key != "name" else value
        for key, value in given.items()
        if key in known
    }
    # Half of the world writes 0,5.
    texts |= {
        key: value.replace(",", ".")
        for key, value in texts.items()
        if isinstance(value, str) and key.endswith(("_m", "_mm", "_percent"))
    }
    try:
        return TypeAdapter(model).validate_python(
            {key: value for key, value in texts.items() if value or key == "name"}
        )
    except ValidationError as error:
        first = error.errors()[0]
        label, *place = map(str, first["loc"])
        label = PAIRS[label][int(place[0])] if label in PAIRS and place else label
        words = first["msg"][0].lower() + first["msg"][1:]
        words = "it is no number such as 0.5" if first["type"] in ("float_parsing", "int_parsing") else words
        shown = str(first.get("input", ""))[:40]
        raise SpecError(f"{LABELS.get(label, label)} {shown!r} cannot be used: {words}; correct that field") from error


#: The fields' names in messages for people.
LABELS = {
    "lens": "lens sheet",
    "lens_thickness_mm": "sheet thickness",
    "printer_dpi": "printer resolution",
    "near_m": "nearest camera",
    "far_m": "farthest camera",
    "width_mm": "width of the badge",
    "height_mm": "height of the badge",
    "axes": "fringes",
    "lines": "lines below the name",
}
