"""Logos in SVG: refused where they need more than lines and colours, and drawn by resvg.

resvg runs no scripts.  A logo is refused before it is drawn if it would differ from machine to machine (letters that
need a font, other files next to it), open network addresses (links), or take hours (filters, copies of copies).  A logo
that still takes too long (hundreds of transparent layers) is stopped: it is drawn in a process of its own.
"""

from __future__ import annotations

import math
import re
import subprocess
import sys
from xml.etree import ElementTree

from moireid.errors import SpecError

#: Elements that are refused, and what to do about them.
REFUSED = {
    "script": "a script; save it without",
    "foreignObject": "a page of another kind; save it as a plain SVG",
    "text": "letters that need a font; turn text into paths",
    "image": "a picture within; give that picture itself as PNG or JPEG",
    "filter": "filters (shadows, blur); flatten them",
    "mask": "masks; flatten them",
    "marker": "markers (arrow heads); turn strokes into paths",
    "pattern": "patterns; turn them into paths",
    "animate": "animation; save it without",
    "set": "animation; save it without",
}
MOST_ELEMENTS, MOST_DEPTH, MOST_BYTES = 20_000, 100, 5_000_000
#: A logo of a thousand shapes takes 2 s; a see-through layer of full size takes 0.2 s.
MOST_SECONDS = 30.0
#: A see-through layer takes 16 MB at 2,000 pixels a side, and layers lie within each other `MOST_DEPTH` deep at most.
MOST_MEMORY_BYTES = 2 << 30
#: What an attribute or style may point at: a place within the file.
_OUTSIDE = re.compile(r"url\((?!\s*['\"]?#)|@import|expression\(|javascript:", re.IGNORECASE)
_POINTED_AT = re.compile(r"url\(\s*['\"]?#([^'\")]*)")
#: The refused elements as properties, where a filter needs no element: filter="blur(9)".
_PROPERTY = re.compile(r"filter|mask|marker(-start|-mid|-end)?")
_STYLED = re.compile(r"(?<![\w-])(filter|mask|marker)(-start|-mid|-end)?\s*:(?!\s*none)", re.IGNORECASE)
_NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", re.IGNORECASE)
#: Run in the process that draws: the SVG comes in, the PNG goes out; a side of 0 px follows the other.
_DRAW = """
import sys, resvg_py
most_bytes = int(sys.argv.pop())
if sys.platform != "win32":
    from moireid.sandbox.seal import ProcessLimits, confine
    confine(ProcessLimits(most_bytes))
wide, high = (int(side) or None for side in sys.argv[1:])
text = sys.stdin.buffer.read().decode("utf-8")
try:
    png = resvg_py.svg_to_bytes(svg_string=text, skip_system_fonts=True, width=wide, height=high)
except (ValueError, RuntimeError) as error:
    sys.exit(str(error))
sys.stdout.buffer.write(bytes(png))
"""


def draw_svg(data: bytes, whose: str, longer_px: int) -> bytes:
    """The drawing as a PNG whose longer side has that many pixels, made in a process of its own.

    Raises: SpecError for what is no SVG, for what this module refuses, and for what takes over `MOST_SECONDS`.
    """
    sides = _sides_px(data, whose, longer_px)
    # -P: a file next to the user's logo must not be imported as the program that draws.
    command = [sys.executable, "-P", "-c", _DRAW, *map(str, sides), str(MOST_MEMORY_BYTES)]
    try:
        done = subprocess.run(command, input=data, capture_output=True, timeout=MOST_SECONDS, check=False)
    except subprocess.TimeoutExpired as error:
        raise too_slow(whose) from error
    if done.returncode:
        raise _undrawn(whose, done.stderr.decode("utf-8", "replace"))
    return done.stdout


def draw_svg_here(data: bytes, whose: str, longer_px: int) -> bytes:
    """The same in this process, which was started for it within limits, and which its parent stops.

    Raises: SpecError as `draw_svg`, but for time.
    """
    import resvg_py

    wide, high = (side or None for side in _sides_px(data, whose, longer_px))
    try:
        return bytes(resvg_py.svg_to_bytes(data.decode("utf-8"), skip_system_fonts=True, width=wide, height=high))
    except (ValueError, RuntimeError) as error:
        raise _undrawn(whose, str(error)) from error


def too_slow(whose: str) -> SpecError:
    """The error of a drawing that takes over `MOST_SECONDS`."""
    return SpecError(
        f"{whose} takes more than {MOST_SECONDS:g} s to draw; simplify it (see-through layers take longest), or "
        "save it as PNG"
    )


def _undrawn(whose: str, reason: str) -> SpecError:
    return SpecError(f"{whose} cannot be drawn ({reason.strip()[-80:]}); save it as a plain SVG, or as PNG")


def _sides_px(data: bytes, whose: str, longer_px: int) -> tuple[int, int]:
    """Width and height to draw, px; 0 for the one that follows the other.  Raises: SpecError as `check_svg`."""
    width, height = check_svg(data, whose)
    return (longer_px, 0) if width >= height else (0, longer_px)


def check_svg(data: bytes, whose: str) -> tuple[float, float]:
    """Width over height of a drawing that may be drawn, in units of its own.

    Raises: SpecError with the first thing that may not be in it.
    """
    if len(data) > MOST_BYTES:
        raise SpecError(f"{whose} has more than {MOST_BYTES / 1e6:g} MB of SVG; simplify it, or save it as PNG")
    try:
        # The parser and resvg get one text, whatever encoding the file says of itself.
        text = data.decode("utf-8")
        if _defines_entities(text):
            raise SpecError(f"{whose} defines entities of its own; save it as a plain SVG")
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise SpecError(f"{whose} is no SVG ({str(error)[:80]}); save it as a plain SVG, or as PNG") from error
    if _plain(root.tag) != "svg":
        raise SpecError(f"{whose} is no SVG but {_plain(root.tag)!r}; save it as a plain SVG, or as PNG")
    for element in root.iter():
        _check_element(element, whose)
    _check_copies(root, whose)
    return _size(root, whose)


def _defines_entities(text: str) -> bool:
    """Whether there is an entity, or a document type with definitions of its own."""
    low = text.lower()
    types = low.split("<!doctype")[1:]
    return "<!entity" in low or any("[" in part.partition(">")[0] for part in types)


def _check_element(element: ElementTree.Element, whose: str) -> None:
    tag = _plain(element.tag)
    kind = next((name for name in REFUSED if tag.lower().startswith(name.lower())), None)
    if kind is not None:
        raise SpecError(f"{whose} holds {REFUSED[kind]}")
    if _OUTSIDE.search(element.text or "") and tag == "style":
        raise SpecError(f"{whose} asks for something outside of itself in its style; save it as a plain SVG")
    if tag == "style" and _STYLED.search(element.text or ""):
        raise SpecError(f"{whose} holds a filter, mask or marker in its style; flatten it")
    for key, value in element.attrib.items():
        name = _plain(key).lower()
        styled = name == "style" and _STYLED.search(value)
        if styled or (_PROPERTY.fullmatch(name) and value.strip() != "none"):
            raise SpecError(f"{whose} holds a filter, mask or marker ({name}={value[:40]!r}); flatten it")
        outside = name == "href" and not value.startswith("#") and tag != "a"
        if name.startswith("on") or outside or _OUTSIDE.search(value):
            raise SpecError(
                f"{whose} asks for something outside of itself ({name}={value[:40]!r}); save it as a plain SVG"
            )


def _check_copies(root: ElementTree.Element, whose: str) -> None:
    """Copies of copies grow without limit in a small file: count what would be drawn."""
    by_id = {element.get("id"): element for element in root.iter() if element.get("id")}
    counted: dict[ElementTree.Element, int] = {}

    def drawn(element: ElementTree.Element, depth: int) -> int:
        if depth > MOST_DEPTH:
            raise SpecError(f"{whose} is nested deeper than {MOST_DEPTH}; save it as a plain SVG, or as PNG")
        if element not in counted:
            inside = list(element)
            inside += [by_id[name] for name in _pointed_at(element) if name in by_id]
            counted[element] = 1 + sum(drawn(child, depth + 1) for child in inside)
        return counted[element]

    if drawn(root, 0) > MOST_ELEMENTS:
        raise SpecError(f"{whose} draws more than {MOST_ELEMENTS} shapes; simplify it, or save it as PNG")


def _pointed_at(element: ElementTree.Element) -> list[str]:
    """The ids of what an element draws apart from its content: copies, clip paths and gradients."""
    names = [name for value in element.attrib.values() for name in _POINTED_AT.findall(value)]
    if _plain(element.tag) == "use":
        names += [value[1:] for key, value in element.attrib.items() if _plain(key) == "href"]
    return names


def _size(root: ElementTree.Element, whose: str) -> tuple[float, float]:
    numbers = [float(part) for part in _NUMBER.findall(root.get("viewBox", ""))]
    if len(numbers) != 4:
        lengths = [_NUMBER.match(root.get(side, "").strip()) for side in ("width", "height")]
        numbers = [0.0, 0.0, *(float(found[0]) if found else 0.0 for found in lengths)]
    if not (min(numbers[2:]) > 0 and max(numbers[2:]) < math.inf and max(numbers[2:]) <= 50 * min(numbers[2:])):
        raise SpecError(f"{whose} says no size of a logo (viewBox); save it as a plain SVG, or as PNG")
    return numbers[2], numbers[3]


def _plain(tag: object) -> str:
    """A tag or key without its namespace."""
    return str(tag).rpartition("}")[2] if isinstance(tag, str) else ""
