"""Template files: which piece of a badge is placed where, for landscape and portrait boards.

A template is a TOML or JSON file.  It says how much of the board's height is left above and below the fringes, and
lists places.  A place is one of the free areas of the board (`clear.areas_of`), or a rectangle of its own in shares of
the board or in mm from its upper left corner.  Its pieces are listed from left to right; where a badge lacks a piece,
the others get its room.
"""

from __future__ import annotations

import json
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, Literal

from moireid.artwork.colours import Colour, colour_named
from moireid.errors import SpecError
from moireid.files import read_regular

TEMPLATES = ("plain", "conference", "newsroom", "court", "webcam")
PIECES = ("name", "words", "lines", "line1", "line2", "line3", "line4", "logo", "portrait", "qr", "id")
AREAS = ("head", "upper", "crown", "foot", "lower", "base")
GROUNDS = ("none", "accent", "tint")
RULES = ("none", "above", "below", "both")
UNITS = ("share", "mm")
ALIGNS = ("left", "center", "right")
MOST_FILE_BYTES, MOST_PLACES, MOST_SHARE = 100_000, 24, 0.7
#: Letters of a place are at most so large, points, unless it says so.
POINTS = (4.0, 72.0)
_PLACE_KEYS = {"what", "area", "at", "unit", "align", "ground", "rule", "points", "bleed", "with", "without"}

Orientation = Literal["landscape", "portrait"]


@dataclass(frozen=True)
class Place:
    """One place of a template.

    what: pieces from left to right; area: one of `AREAS`, or None where `at` gives (x0, y0, x1, y1) in `unit`; ground:
    behind it, one of `GROUNDS`; bleed: the ground reaches beyond the board's sides, where it is cut; rule: thin lines
    in the accent's colour, one of `RULES`; points: most height of the name's letters; needs, lacks: it is there only
    with, or only without these pieces.
    """

    what: tuple[str, ...]
    area: str | None = None
    at: tuple[float, float, float, float] | None = None
    unit: str = "share"
    align: str = "center"
    ground: str = "none"
    bleed: bool = False
    rule: str = "none"
    points: float = 48.0
    needs: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Side:
    """A template for one orientation; head, foot: shares of the board's height above and below the fringes."""

    head: float
    foot: float
    places: tuple[Place, ...]


@dataclass(frozen=True)
class BadgeTemplate:
    """A template; colour: of its accents, where a person has none; sides by orientation."""

    name: str
    colour: Colour
    sides: dict[Orientation, Side]

    def side(self, width_mm: float, height_mm: float) -> Side:
        """The side for a board; a square one is landscape.  Raises: SpecError where the template has none for it."""
        orientation: Orientation = "landscape" if width_mm >= height_mm else "portrait"
        if orientation not in self.sides:
            other = "portrait" if orientation == "landscape" else "landscape"
            raise SpecError(
                f"template {self.name} has no [{orientation}], which this board needs; add it, or take the badge in "
                f"{other} (--orientation {other})"
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
    if len(data) > MOST_FILE_BYTES:
        raise SpecError(f"template {path} is larger than {MOST_FILE_BYTES // 1000} kB; give a template")
    try:
        text = data.decode("utf-8-sig")
        document = json.loads(text) if path.suffix.lower() == ".json" else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SpecError(f"template {path} is not read as {path.suffix[1:].upper()}: {error}") from error
    return template_of(document, path.name)


@cache
def _shipped(name: str) -> BadgeTemplate:
    text = resources.files("moireid").joinpath(f"artwork/templates/{name}.toml").read_text(encoding="utf-8")
    return template_of(tomllib.loads(text), name)


def template_of(document: object, name: str) -> BadgeTemplate:
    """The template of a file's content; `name` is used in messages.  Raises: SpecError that names the key."""
    table = _table(document, name, {"words", "colour", "landscape", "portrait"})
    sides: dict[Orientation, Side] = {}
    for orientation in ("landscape", "portrait"):
        if orientation in table:
            sides[orientation] = _side(table[orientation], f"{name}: {orientation}")
    if not sides:
        raise SpecError(f"template {name} has neither [landscape] nor [portrait]; add one")
    return BadgeTemplate(name, colour_named(_text(table.get("colour", "#1f2a37"), f"{name}: colour")), sides)


def _side(entry: object, where: str) -> Side:
    table = _table(entry, where, {"head", "foot", "place"})
    head, foot = (_number(table.get(key, 0.0), f"{where}.{key}", 0.0, MOST_SHARE) for key in ("head", "foot"))
    places = table.get("place", [])
    if not isinstance(places, list) or not 1 <= len(places) <= MOST_PLACES:
        raise SpecError(f"template {where}.place must list 1 to {MOST_PLACES} places")
    return Side(head, foot, tuple(_place(place, f"{where}.place {k}") for k, place in enumerate(places, start=1)))


def _place(entry: object, where: str) -> Place:
    table = _table(entry, where, _PLACE_KEYS)
    if ("area" in table) == ("at" in table):
        raise SpecError(f"template {where} must say area or at, one of the two")
    unit = _choice(table.get("unit", "share"), f"{where}.unit", UNITS)
    ground = _text(table.get("ground", "none"), f"{where}.ground")
    if ground not in GROUNDS:
        raise SpecError(f"template {where}.ground {ground[:40]!r} is not known; choose one of {', '.join(GROUNDS)}")
    bleed = table.get("bleed", False)
    if not isinstance(bleed, bool):
        raise SpecError(f"template {where}.bleed must be true or false")
    return Place(
        what=_pieces(table.get("what", []), f"{where}.what"),
        area=_choice(table["area"], f"{where}.area", AREAS) if "area" in table else None,
        at=_rect(table["at"], f"{where}.at", 1.0 if unit == "share" else 1000.0) if "at" in table else None,
        unit=unit,
        align=_choice(table.get("align", "center"), f"{where}.align", ALIGNS),
        ground=ground,
        bleed=bleed,
        rule=_choice(table.get("rule", "none"), f"{where}.rule", RULES),
        points=_number(table.get("points", 48.0), f"{where}.points", *POINTS),
        needs=_pieces(table.get("with", []), f"{where}.with"),
        lacks=_pieces(table.get("without", []), f"{where}.without"),
    )


def _table(entry: object, where: str, keys: set[str]) -> dict[str, Any]:
    if not isinstance(entry, dict):
        raise SpecError(f"template {where} must be a table of keys and values")
    if unknown := sorted(set(entry) - keys):
        raise SpecError(
            f"template {where} has the unknown key {unknown[0][:40]!r}; allowed are {', '.join(sorted(keys))}"
        )
    return entry


def _pieces(entry: object, where: str) -> tuple[str, ...]:
    words = [entry] if isinstance(entry, str) else entry
    if not isinstance(words, list) or any(word not in PIECES for word in words):
        raise SpecError(f"template {where} must list pieces out of {', '.join(PIECES)}, got {str(entry)[:60]!r}")
    return tuple(words)


def _rect(entry: object, where: str, most: float) -> tuple[float, float, float, float]:
    if not isinstance(entry, list) or len(entry) != 4:
        raise SpecError(f"template {where} must be four numbers: left, top, right, bottom")
    x0, y0, x1, y1 = (_number(value, where, 0.0, most) for value in entry)
    if x0 >= x1 or y0 >= y1:
        raise SpecError(f"template {where} must run from left to right and from top to bottom, got {entry}")
    return x0, y0, x1, y1


def _number(value: object, where: str, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise SpecError(f"template {where} must be a number from {low:g} to {high:g}, got {str(value)[:40]}")
    return float(value)


def _text(value: object, where: str) -> str:
    if not isinstance(value, str):
        raise SpecError(f"template {where} must be text, got {str(value)[:40]}")
    return value


def _choice(value: object, where: str, allowed: tuple[str, ...]) -> str:
    if value not in allowed:
        raise SpecError(f"template {where} {str(value)[:40]!r} is not known; choose one of {', '.join(allowed)}")
    return str(value)
