"""The order for a badge, its payload, and the checks of names, ranges, scales and sizes.

Everyone who knows a payload can print its pattern.  So where none is given, the payload comes from the system's random
source alone: no name, no seed and no clock enters it.
"""

from __future__ import annotations

import hashlib
import math
import secrets
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from moireid.arguments import Bounds, check_values
from moireid.errors import CodeError, SpecError
from moireid.files import AnyPath
from moireid.names import NAME_LIMIT, encoded_twice, hidden_words, unprintable
from moireid.profiles import DPI_RANGE, FORMS, PAPERS_MM, SHEET_RANGES

#: The focal length, px, of the camera that a design must suffice for: 1080p with the angle of view of a phone's main
#: camera.
DESIGN_FOCAL_PX = 1450.0
#: White at the edges of the published board.
MARGIN_MM = 5.0
#: Thickness of a mask's spacer, where none is given.
GAP_MM = 1.5
#: Printers are off by some tenths of a percent; 5 % means that the page was fitted to the paper, and must be reprinted.
MAX_SCALE_OFF = 0.05
#: What the fields of an order may be.
BOUNDS: dict[str, Bounds] = {
    "lens_thickness_mm": SHEET_RANGES[1],
    "printer_dpi": DPI_RANGE,
    "ink_growth_um": (-100, 150),
    "paper": tuple(PAPERS_MM),
    "code": ("spacing", "pitch"),
    "axes": ("x", "xy", "hex"),
    "form": FORMS,
    "front": ("lens", "mask"),
    "markers": ("squares", "frame"),
    "pattern": ("silk", "cells"),
    "head": (0, 1),
    "foot": (0, 1),
    "mount": ("lanyard", "clip", "stand", "none"),
}


Pair = tuple[float, float]
#: A figure of a mount, mm, or width and height of its slot.
MountFigure = float | Pair
#: What pairs of numbers are, and what is between them where they are typed.
_PAIRS = {
    "range_m": ("range", "-", "two distances in metres such as 0.8-2.5"),
    "size_mm": ("size", "x", "width and height in mm such as 146x160"),
}


@dataclass(frozen=True)
class Order:
    """What a badge is to be: whose, of which size and looks, for which printer, read from how far.

    Command, studio and Python fill it; it is checked as it is made.  None leaves the choice to the format.

    Parameters
    ----------
    name : str
        Who will wear it; at most 200 characters.
    format : str, optional
        A size for which holders are sold (`designer.formats.FORMATS`), with a sheet and a range that suit it; None for
        a board.
    orientation : {"landscape", "portrait"}, optional
        Whether it is wide or high; None for what is usual for the format.
    size_mm : (float, float), optional
        Width and height, mm, for a badge of no format.
    lens : str or Path, optional
        A label such as "62lpi-27mil", or the file of a lens profile.
    lens_thickness_mm : float, optional
        Thickness of the sheet by a calliper, or of a mask's spacer, mm; None for that of the label, or `GAP_MM`.
    range_m : (float, float), optional
        Nearest and farthest camera, m; None for the format's, as far as it can be read.
    printer_dpi : int
        Dots to the inch of the printer.
    ink_growth_um : float
        By how much the printer widens a line, both edges together, micrometres; lines are drawn narrower by that.
    paper : str
        The page, one of `profiles.PAPERS_MM`.
    code : {"spacing", "pitch"}, optional
        How lines carry the identity: by their places, or by their pitch; None for what carries one of its length.
    axes : {"x", "xy", "hex"}
        Directions of motion that the fringes sense: across the page, also down it, or 0, 60 and 120 degrees.
    form : {"dots", "vector"}
        How lines are drawn: on the printer's grid, or free of it.
    front : {"lens", "mask"}
        What is on top of the print: a lenticular sheet, or a line mask of the same pitch on an acrylic spacer.
    markers : {"squares", "frame"}
        What a film finds the badge by: squares in the corners, or a thin coded frame around the fringes.
    pattern : {"silk", "cells"}, optional
        Whether lines bend from cell to cell, or end at its border; None for silk where they may bend: a spacing code, a
        lens sheet, and no fields that are turned.
    template : str or Path, optional
        Where name, lines and pictures go, by name or file.
    head, foot : float
        Shares of the height that the template keeps above and below the fringes.
    lines : sequence of str
        Lines below the name.
    logo, portrait : str or Path, optional
        Pictures on the badge.
    colour : str, optional
        The template's accent colour, as "#134e8c" or "teal".
    payload : str or bytes, optional
        The identity, in hex digits or as bytes; None for one that is drawn at random.
    mount : {"lanyard", "clip", "stand", "none"}, optional
        What holds the badge; None for a lanyard, or what fits the format instead.
    mount_mm : mapping of str to float or (float, float)
        Dimensions of the mount, mm, by name, such as {"card_mm": 0.5}.

    Raises
    ------
    SpecError
        For a name, a pair of numbers or an identity that is none.
    """

    name: str
    format: str | None = None
    orientation: str | None = None
    size_mm: Pair | None = None
    lens: AnyPath | None = None
    lens_thickness_mm: float | None = None
    range_m: Pair | None = None
    printer_dpi: int = 1200
    ink_growth_um: float = 0.0
    paper: str = "a4"
    code: str | None = None
    axes: str = "x"
    form: str = "dots"
    front: str = "lens"
    markers: str = "squares"
    pattern: str | None = None
    template: AnyPath | None = None
    head: float = 0.0
    foot: float = 0.0
    lines: Sequence[str] = ()
    logo: AnyPath | None = None
    portrait: AnyPath | None = None
    colour: str | None = None
    payload: str | bytes | None = None
    mount: str | None = None
    mount_mm: Mapping[str, MountFigure] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for what in _PAIRS:
            if (pair := getattr(self, what)) is not None:
                object.__setattr__(self, what, _checked_pair(pair, what))
        check_values(type(self), vars(self), BOUNDS)
        object.__setattr__(self, "name", clean_name(self.name))
        if isinstance(self.payload, str):
            object.__setattr__(self, "payload", payload_from_hex(self.payload, family=self.code or "spacing"))

    @property
    def identity(self) -> bytes | None:
        """The payload as bytes."""
        assert not isinstance(self.payload, str)
        return self.payload

    @property
    def files(self) -> list[Path]:
        """The files that it names."""
        named = [Path(one) for one in (self.logo, self.portrait, self.template, self.lens) if one is not None]
        return [path for path in named if path.is_file()]


def clean_name(name: str, what: str = "name") -> str:
    """The name in Unicode NFC without surrounding space.

    Parameters: what: the word for it in messages.
    Raises: SpecError where it is empty, longer than `NAME_LIMIT`, or holds control or invisible characters.
    """
    cleaned = unicodedata.normalize("NFC", name).strip()
    if not cleaned:
        raise SpecError("the name is empty; give the name of the person who will wear the badge")
    if len(cleaned) > NAME_LIMIT:
        raise SpecError(f"the {what} has {len(cleaned)} characters, at most {NAME_LIMIT} fit; shorten it")
    if unprintable(cleaned):
        raise SpecError(f"the {what} holds control, invisible or unassigned characters; give plain text")
    if (hidden := hidden_words(cleaned)) is not None:
        raise SpecError(f"the {what} {cleaned[:80]!r} {hidden}, so it passes for another; give it without them")
    if (meant := encoded_twice(cleaned)) is not None:
        raise SpecError(f"the {what} {cleaned[:80]!r} was encoded twice, and is probably {meant[:80]!r}; give that")
    return cleaned


def parse_pair(text: str, what: str) -> Pair:
    """'0.8-2.5' as a "range_m", '146x160' as a "size_mm".  Raises: SpecError where it is not two such numbers."""
    word, between, advice = _PAIRS[what]
    try:
        first, second = (float(part) for part in text.lower().split(between))
    except ValueError as error:
        raise SpecError(f"{word} {text!r} is not understood; give {advice}") from error
    return _checked_pair((first, second), what)


def _checked_pair(pair: Pair, what: str) -> Pair:
    """Two positive numbers, of a range rising.  Raises: SpecError."""
    word, between, advice = _PAIRS[what]
    try:
        low, high = (float(one) for one in pair)
    except (TypeError, ValueError) as error:
        raise SpecError(f"{what}={pair!r:.60} is no pair of numbers; give {advice}") from error
    if not (math.isfinite(low) and math.isfinite(high) and low > 0 and high > 0 and (high >= low or what != "range_m")):
        raise SpecError(f"{word} {low:g}{between}{high:g} is not possible; give {advice}")
    return low, high


def parse_scale(text: str) -> tuple[float, float]:
    """'0.9973' as (0.9973, 0.9973), '0.9973,0.9981' as x and y; what was measured over what should have been.

    Raises: SpecError where it is neither, or off by more than `MAX_SCALE_OFF`, which no printer is.
    """
    parts = text.split(",")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2) or not all(1 - MAX_SCALE_OFF <= number <= 1 + MAX_SCALE_OFF for number in numbers):
        raise SpecError(
            f"scale {text[:40]!r} must be one or two shares within {1 - MAX_SCALE_OFF:g} and {1 + MAX_SCALE_OFF:g}, "
            "such as 0.9973 or 0.9973,0.9981: the bar's measured length over 150 mm, across and down"
        )
    return numbers[0], numbers[-1]


#: Payload bytes of each code family, the usual one first.
FAMILY_BYTES = {"spacing": (8, 16), "pitch": (3,)}


def random_payload(size_bytes: int = 8) -> bytes:
    """Draw an identity that no one can guess.

    Parameters
    ----------
    size_bytes : int
        8 or 16, or 3 for the pitch family's code.

    Returns
    -------
    bytes
        From the system's random source; no seed reproduces it.

    Raises
    ------
    CodeError
        Where no code family carries so many bytes.

    Notes
    -----
    Convention: `size_bytes` are whole bytes of a payload, as `FAMILY_BYTES` lists them.
    Source: `secrets.token_bytes`.
    """
    sizes = sorted(size for family in FAMILY_BYTES.values() for size in family)
    if size_bytes not in sizes:
        raise CodeError(f"a payload of {size_bytes!r} bytes is not possible; codes carry {', '.join(map(str, sizes))}")
    return secrets.token_bytes(size_bytes)


def payload_from_hex(text: str, *, family: str = "spacing") -> bytes:
    """Read a payload from hex digits.

    Parameters
    ----------
    text : str
        16 or 32 digits for the spacing family, 6 for the pitch family; of any case, without spaces.
    family : {"spacing", "pitch"}
        The code family.

    Returns
    -------
    bytes
        8 or 16 bytes, or 3.

    Raises
    ------
    CodeError
        Where the text is not so many hex digits.

    Notes
    -----
    Convention: the first two digits are the first byte.
    Source: `FAMILY_BYTES`.
    """
    allowed = [2 * count for count in FAMILY_BYTES[family]]
    try:
        payload = bytes.fromhex(text) if len(text) in allowed else b""
    except ValueError:
        payload = b""
    # bytes.fromhex lets spaces pass, which would make a shorter payload.
    if 2 * len(payload) not in allowed:
        digits = " or ".join(map(str, allowed))
        raise CodeError(
            f"payload {text[:40]!r} is not possible; the {family} code takes {digits} hex digits such as "
            f"{hashlib.sha256(b'example').hexdigest()[: allowed[0]]}"
        )
    return payload
