"""Template files: which piece of a badge is placed where, for landscape and portrait boards.

A template is a TOML or JSON file.  It says how much of the board's height is left above and below the fringes, and
lists places.  A place is one of the free areas of the board (`clear.areas_of`), or a rectangle of its own in shares of
the board or in mm from its upper left corner.  Its pieces are listed from left to right; where a badge lacks a piece,
the others get its room.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct
from msgspec.structs import force_setattr

from moireid.artwork.colours import Colour, colour_named
from moireid.errors import SpecError
from moireid.files import read_regular
from moireid.models import parse_json, read_model

TEMPLATES = (
    "plain",
    "conference",
    "newsroom",
    "court",
    "webcam",
    "banner",
    "campus",
    "minimal",
)
TYPEFACES = ("sans", "serif", "slab")
MOST_FILE_BYTES, MOST_PLACES = 100_000, 24

Orientation = Literal["landscape", "portrait"]
Piece = Literal["name", "words", "lines", "line1", "line2", "line3", "line4", "logo", "portrait", "qr", "id"]
#: One piece is written without a list.
Pieces = Piece | tuple[Piece, ...]
#: Share of the board's height.
Height = Annotated[float, Meta(ge=0, le=0.7)]


class Place(Struct, frozen=True, forbid_unknown_fields=True, rename={"needs": "with", "lacks": "without"}):
    """One place of a template.

    area: a free area of the board (`clear.areas_of`); what: pieces from left to right; ground: behind it; bleed: the
    ground reaches beyond the board's sides, where it is cut; rule: thin lines in the accent's colour; points: most
    height of the name's letters; needs, lacks: it is there only with, or only without these pieces.
    """

    area: Literal["head", "upper", "crown", "foot", "lower", "base"]
    what: Pieces = ()
    align: Literal["left", "center", "right"] = "center"
    ground: Literal["none", "accent", "tint", "paper"] = "none"
    bleed: bool = False
    rule: Literal["none", "above", "below", "both"] = "none"
    points: Annotated[float, Meta(ge=4, le=72)] = 48.0
    needs: Pieces = ()
    lacks: Pieces = ()

    def __post_init__(self) -> None:
        for name in ("what", "needs", "lacks"):
            pieces = getattr(self, name)
            if isinstance(pieces, str):
                force_setattr(self, name, (pieces,))


class Side(Struct, frozen=True, forbid_unknown_fields=True, rename={"places": "place"}):
    """A template for one orientation.

    head, foot: shares of the board's height above and below the fringes.
    """

    places: Annotated[tuple[Place, ...], Meta(min_length=1, max_length=MOST_PLACES)]
    head: Height = 0.0
    foot: Height = 0.0


class TemplateFile(Struct, forbid_unknown_fields=True):
    """What a template's file holds; words: about it, for people; colour: of its accents, where a person has none.

    typeface: of all words.
    """

    words: Any = None
    colour: str = "#1f2a37"
    typeface: Literal["sans", "serif", "slab"] = "sans"
    landscape: Side | None = None
    portrait: Side | None = None


@dataclass(frozen=True)
class BadgeTemplate:
    """A template; colour: of its accents, where a person has none; sides by orientation; typeface: of all words."""

    name: str
    colour: Colour
    sides: dict[Orientation, Side]
    typeface: str = "sans"

    def side(self, width_mm: float, height_mm: float) -> Side:
        """The side for a board; a square one is landscape.  Raises: SpecError where the template has none for it."""
        orientation: Orientation = "landscape" if width_mm >= height_mm else "portrait"
        if orientation not in self.sides:
            other = "portrait" if orientation == "landscape" else "landscape"
            raise SpecError(
                f"template {self.name} has no [{orientation}], which this board needs; add it, or take the badge in "
                f"{other} (orientation={other})"
            )
        return self.sides[orientation]


def template_named(name: str) -> BadgeTemplate:
    """A template that comes with the program, or the file at that path (it ends in .toml or .json).

    Raises: SpecError where there is none, and as `template_of`.
    """
    if name in TEMPLATES:
        return _shipped(name)
    path = Path(name)
    if path.suffix.lower() not in (".toml", ".json"):
        raise SpecError(
            f"template {name!r} is not known; choose one of {', '.join(TEMPLATES)}, or give a .toml or .json file"
        )
    try:
        data = read_regular(path, MOST_FILE_BYTES)
    except OSError as error:
        raise SpecError(f"template {path} cannot be read ({error.strerror}); give the path of a template") from error
    try:
        text = data.decode("utf-8-sig")
        if path.suffix.lower() == ".json":
            document = parse_json(text, f"template {path}", "give a template")
        else:
            document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SpecError(f"template {path} is not read as {path.suffix[1:].upper()}: {error}") from error
    return template_of(document, path.name)


@cache
def _shipped(name: str) -> BadgeTemplate:
    text = resources.files("moireid").joinpath(f"artwork/templates/{name}.toml").read_text(encoding="utf-8")
    return template_of(tomllib.loads(text), name)


def template_of(document: object, name: str) -> BadgeTemplate:
    """The template of a file's content; `name` is used in messages.  Raises: SpecError that names the key."""
    file = read_model(document, TemplateFile, f"template {name}", "correct that key", first=1)
    sides: dict[Orientation, Side] = {}
    if file.landscape:
        sides["landscape"] = file.landscape
    if file.portrait:
        sides["portrait"] = file.portrait
    if not sides:
        raise SpecError(f"template {name} has neither [landscape] nor [portrait]; add one")
    return BadgeTemplate(name, colour_named(file.colour), sides, file.typeface)
