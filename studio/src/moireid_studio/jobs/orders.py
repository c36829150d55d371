"""What a visitor asks for: the fields of the Issue page and of the API, and their checks.

The wish is checked by the same functions as in `print-your-badge`, so both refuse it with the same sentence.  No field
names a file of the server: sheets and templates are those that come with the program, and pictures are handed in.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from moireid.badge import Badge
from moireid.designer import Request, explain, payload_from_hex
from moireid.designer.formats import FORMATS
from moireid.designer.reach import LinkBudget, link_budgets
from moireid.designer.request import clean_name
from moireid.errors import SpecError
from moireid.fabrication.process_figures import MountFigures
from moireid.issuing import IssueOrder, IssuePlan, Wear, plan_badge
from moireid.names import MOST_LINES
from moireid.registry import Record, Registry
from moireid.sheets import PRODUCTS

#: Labels alone: the library would take the path of a lens profile too, and no visitor names a path.
if TYPE_CHECKING:
    LensLabel = str
else:
    LensLabel = Literal[tuple(PRODUCTS)]
Mount = Literal["lanyard", "clip", "stand", "holder", "none"]
#: Names of `designer.formats.FORMATS`, and of `artwork.template.TEMPLATES`.
FormatName = Literal["cr80", "a7", "4x3in", "a6", "a5", "webcam", "board"]
TemplateName = Literal[
    "plain", "conference", "newsroom", "court", "webcam", "banner", "campus", "minimal", "stripes", "gala"
]
Orientation = Literal["landscape", "portrait"]
#: As the answer to the pictures says.
PictureId = Annotated[str, Field(pattern="^[0-9a-f]{32}$")]
Metres = Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)]
Millimetres = Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)]


class Wish(BaseModel):
    """How badges are to be made; what is left out is as in `print-your-badge`."""

    model_config = ConfigDict(extra="forbid")

    format: FormatName | None = Field(
        None, description="A size that holders are made for, with a sheet and a range that suit it; else the board's."
    )
    orientation: Orientation | None = Field(
        None, description="Landscape or portrait; else as its format is made: all are landscape but the board."
    )
    lens: LensLabel | None = Field(
        None, description="Lenticular sheet, lenses per inch; else the format's, of the board 62lpi-27mil."
    )
    lens_thickness_mm: float | None = Field(
        None, gt=0, le=20, allow_inf_nan=False, description="Thickness of the sheet by a calliper, mm."
    )
    printer_dpi: int = Field(1200, ge=72, le=9600, description="Printer's dots per inch.")
    paper: Literal["a4", "letter"] = "a4"
    near_m: Metres | None = Field(None, description="Nearest camera, metres; else the format's, of the board 0.8.")
    far_m: Metres | None = Field(None, description="Farthest camera, metres; else the format's, of the board 2.5.")
    axes: Literal["x", "xy", "hex"] = Field("x", description="Directions that the fringes sense.")
    markers: Literal["squares", "frame"] = Field(
        "squares", description="What a film finds the badge by: squares in its corners, or a thin frame."
    )
    width_mm: Millimetres | None = Field(None, description="Width of a board of no format, mm; else 146.")
    height_mm: Millimetres | None = Field(None, description="Height of a board of no format, mm; else 160.")
    mount: Mount | None = Field(
        None, description="What carries the badge; else a lanyard's, or none where the format has a holder of its own."
    )
    template: TemplateName | None = Field(
        None,
        description="Layout of the front; else plain, for a webcam's badge webcam, for a bare board name and id alone.",
    )
    colour: str | None = Field(None, max_length=100, description="Of the template's accents: #134e8c, or teal.")
    typeface: Literal["sans", "serif", "slab"] | None = Field(
        None, description="Of name, lines and identity; else that of the layout."
    )
    lines: list[Annotated[str, Field(max_length=2000)]] = Field(
        default_factory=list, max_length=4 * MOST_LINES, description=f"Lines below the name, at most {MOST_LINES}."
    )
    logo: PictureId | None = Field(None, description="A logo, by the id that `POST /api/badges/pictures` gave.")

    def wear(self, pictures: Mapping[str, Path] | None = None) -> Wear:
        """Size and looks, as the command takes them.

        Parameters
        ----------
        pictures
            Files of ours, by "logo" and "portrait".

        Raises
        ------
        SpecError
            For fields that contradict each other.
        """
        size, metres = (self.width_mm, self.height_mm), (self.near_m, self.far_m)
        if size != (None, None) and (self.format or self.orientation):
            raise SpecError(
                "width and height are for a size of your own, which has no orientation; leave both empty, or choose "
                "the size of your own and leave the orientation as it is"
            )
        usual_m = FORMATS[self.format].range_m if self.format else Request.range_m
        return Wear(
            self.format,
            self.orientation,
            None if size == (None, None) else "x".join(_filled(size, Request.size_mm)),
            self.lens,
            None if metres == (None, None) else "-".join(_filled(metres, usual_m)),
            self.template,
            tuple(self.lines),
            (pictures or {}).get("logo"),
            (pictures or {}).get("portrait"),
            self.colour,
            self.typeface,
        )

    def request(self, name: str, wear: Wear | None = None) -> Request:
        """The library's request for a person of that name.

        Parameters
        ----------
        wear
            Of this wish, with its pictures.

        Raises
        ------
        SpecError
            As `clean_name` and `Wear.fit`.
        DesignError
            Where nothing works.
        """
        wish = Request(
            clean_name(name),
            printer_dpi=self.printer_dpi,
            paper=self.paper,
            family="spacing",
            axes=self.axes,
            markers=self.markers,
            lens_thickness_mm=self.lens_thickness_mm,
        )
        return (wear or self.wear()).fit(wish)


def _filled(given: tuple[float | None, float | None], usual: tuple[float, float]) -> list[str]:
    return [f"{one if one is not None else other:g}" for one, other in zip(given, usual, strict=True)]


class BadgeOrder(Wish):
    """One person's badge."""

    name: str = Field(max_length=2000, description="The person's name; 200 letters at most are set on a badge.")
    payload: str = Field("", max_length=200, description="The identity, 16 or 32 hex digits; else one is drawn.")
    portrait: PictureId | None = Field(None, description="A portrait, by the id that `POST /api/badges/pictures` gave.")

    def chosen(self) -> bytes | None:
        """The payload that is asked for.  Raises: CodeError where it is none."""
        return payload_from_hex(self.payload.strip(), family="spacing") if self.payload.strip() else None

    def of(self, badge: Badge) -> BadgeOrder:
        """The order of this very badge, so that no other identity is drawn when it is made."""
        return self.model_copy(update={"payload": badge.id})


@dataclass(frozen=True)
class CheckedOrder:
    """A badge that can be made, and what the visitor should know about it.

    rows: as `print-your-badge --explain`; links: link budget at each end of the range; namesakes: other badges issued
    to the name; look_alikes: badges of people whose names look like it.
    """

    plan: IssuePlan
    rows: list[tuple[str, str]]
    links: list[tuple[float, LinkBudget]]
    namesakes: list[Record]
    look_alikes: list[Record]

    @property
    def to_read(self) -> str | None:
        """What the issuer must have read before this badge is issued, as a mark of it; None where there is nothing."""
        notable = self.plan.holder or self.namesakes or self.look_alikes
        return f"{self.plan.badge.id} {self.plan.badge.name}" if notable else None


def plan_order(order: BadgeOrder, registry: Registry, pictures: Mapping[str, Path] | None = None) -> IssuePlan:
    """The badge of an order, and what goes with it; nothing is issued.

    Parameters
    ----------
    pictures
        As for `Wish.wear`.

    Notes
    -----
    Raises: SpecError, DesignError, CodeError, FabricationError or RegistryError, as the command does.
    """
    wear = order.wear(pictures)
    request = order.request(order.name, wear)
    return plan_badge(IssueOrder(request, wear, order.mount, MountFigures(), order.chosen()), registry.by_id)


def checked(order: BadgeOrder, registry: Registry, pictures: Mapping[str, Path] | None = None) -> CheckedOrder:
    """The badge of an order, if it can be made, and all that is known of it; nothing is issued.

    Raises: as `plan_order`.
    """
    plan = plan_order(order, registry, pictures)
    badge = plan.badge
    namesakes = [record for record in registry.named(badge.name) if record.id != badge.id]
    look_alikes = registry.look_alikes([badge.name]).get(badge.name, [])
    return CheckedOrder(plan, explain(badge), link_budgets(badge), namesakes, look_alikes)


def read_fields(model: type[BaseModel], fields: Mapping[str, str]) -> Any:
    """A wish or an order from a form: empty fields keep their defaults, and unknown fields are ignored; the field
    `lines` is one text with a line for each.

    Raises: SpecError that names the first field which cannot be used, and what it may be.
    """
    known = model.model_fields
    given: dict[str, Any] = {
        key: value.strip() if key != "name" else value for key, value in fields.items() if key in known
    }
    # Half of the world writes 0,5.
    given |= {key: value.replace(",", ".") for key, value in given.items() if key.endswith(("_m", "_mm", "_percent"))}
    if "lines" in given:
        given["lines"] = [line.strip() for line in given["lines"].splitlines() if line.strip()]
    try:
        return model.model_validate({key: value for key, value in given.items() if value or key == "name"})
    except ValidationError as error:
        first = error.errors()[0]
        key = str(first["loc"][0])
        words = first["msg"][0].lower() + first["msg"][1:]
        words = "it is no number such as 0.5" if first["type"] in ("float_parsing", "int_parsing") else words
        shown = str(first.get("input", ""))[:40]
        raise SpecError(f"{LABELS.get(key, key)} {shown!r} cannot be used: {words}; correct that field") from error


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
