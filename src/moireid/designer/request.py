"""The request for a badge, its payload, and the checks of names, ranges, scales and sizes.

Everyone who knows a payload can print its pattern.  So where none is given, the payload comes from the system's random
source alone: no name, no seed and no clock enters it.
"""

from __future__ import annotations

import hashlib
import math
import secrets
import unicodedata
from dataclasses import dataclass, field

from moireid.errors import CodeError, SpecError
from moireid.names import NAME_LIMIT, hidden_words, unprintable

#: The focal length, px, of the camera that a design must suffice for: 1080p with the angle of view of a phone's main
#: camera.
DESIGN_FOCAL_PX = 1450.0
#: White at the edges of the published board.
MARGIN_MM = 5.0
#: Printers are off by some tenths of a percent; 5 % means that the page was fitted to the paper, and must be reprinted.
MAX_SCALE_OFF = 0.05


@dataclass(frozen=True)
class FringeBorder:
    """The room around the fringes: margin, markers, head and foot.

    Parameters
    ----------
    margin_mm : float
        White at the board's edges, mm.
    marker_mm : float, optional
        Side of a marker's black square, mm; None for the prototype's share of the board's smaller side.
    head, foot : float
        Shares of the board's height above and below the fringes; less than the markers need is as much as they need.
    """

    margin_mm: float = MARGIN_MM
    marker_mm: float | None = None
    head: float = 0.0
    foot: float = 0.0


@dataclass(frozen=True)
class Request:
    """A wish for a badge: whose, on which sheet and printer, of what size, read from how far.

    Parameters
    ----------
    name : str
        Who will wear it; at most 200 characters.
    lens : str
        Label of a lens sheet, or the path of a lens profile.  The default is the published prototype's sheet, on which
        films of the tests and benches are; commands, studio and `moireid.design` take the format's, which is sold.
    printer_dpi : int
        Dots to the inch of the printer.
    paper : str
        "a4" or "letter".
    range_m : (float, float)
        Nearest and farthest camera, m.
    size_mm : (float, float)
        Width and height of the board, mm.
    family : str, optional
        "pitch" or "spacing"; None for the one that carries a payload of the given length.
    axes : str
        Directions that the fringes sense: "x" (across the page), "xy" for two gratings, or "hex" for three at 0, 60 and
        120 degrees.
    form : str
        Of the printed lines, one of `moireid.profiles.FORMS`.
    front : str
        "lens", or "mask" for a line mask of the same pitch on an acrylic spacer.
    gap_mm : float
        Thickness of that spacer, mm.
    lens_thickness_mm : float, optional
        Thickness of the lens sheet by a calliper, mm; None for that of its label.
    frame : FringeBorder
        Margin, markers, and the room above and below the fringes.
    ink_growth_um : float
        By how much the printer widens a line, both edges together, micrometres; the page has narrower lines for that.
    markers : str
        How the page is found in a film: "squares" in the corners, or a thin coded "frame" around the fringes.
    pattern : str, optional
        "cells", whose lines end at their borders, or "silk", whose lines bend from one to the next; None for silk where
        lines may bend: a spacing code, a lens sheet, and no fields that are turned.
    """

    name: str
    lens: str = "50lpi"
    printer_dpi: int = 1200
    paper: str = "a4"
    range_m: tuple[float, float] = (0.8, 2.5)
    size_mm: tuple[float, float] = (146.0, 160.0)
    family: str | None = None
    axes: str = "x"
    form: str = "dots"
    front: str = "lens"
    gap_mm: float = 1.5
    lens_thickness_mm: float | None = None
    frame: FringeBorder = field(default_factory=FringeBorder)
    ink_growth_um: float = 0.0
    markers: str = "squares"
    pattern: str | None = None


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
    return cleaned


def parse_range_m(text: str) -> tuple[float, float]:
    """'0.8-2.5' as (0.8, 2.5) metres.  Raises: SpecError where it is not two rising positive numbers."""
    return _two_numbers(text, "-", "range", "two distances in metres such as 0.8-2.5", rising=True)


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


def parse_size_mm(text: str) -> tuple[float, float]:
    """'146x160' as (146, 160) mm.  Raises: SpecError where it is not two positive numbers."""
    return _two_numbers(text.lower(), "x", "size", "width and height in mm such as 146x160", rising=False)


def _two_numbers(text: str, separator: str, what: str, form: str, *, rising: bool) -> tuple[float, float]:
    parts = text.split(separator)
    try:
        low, high = (float(part) for part in parts)
    except ValueError as error:
        raise SpecError(f"{what} {text!r} is not understood; give {form}") from error
    if not (math.isfinite(low) and math.isfinite(high) and low > 0 and high > 0 and (high >= low or not rising)):
        raise SpecError(f"{what} {text!r} is not possible; give {form}")
    return low, high


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
