"""Logos in SVG: refused where they ask for more than lines and colours, and drawn by resvg.

resvg runs no scripts.  What would make a logo differ from machine to machine (letters that need a font, files beside
it), reach out (links), or take hours (filters, copies of copies) is refused before it is drawn.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree

from moireid.errors import SpecError

#: Elements that are refused, and what to do about them.
REFUSED = {
    "script": "a script; save it without",
    "foreignObject": "a page of another kind; save it as a plain SVG",
    "text": "letters that need a font; turn text into paths",
    "image": "a picture within; give that picture itself as PNG or JPEG",
    "filter": "filters (shadows, blur); flatten them",
    "animate": "animation; save it without",
    "set": "animation; save it without",
}
MOST_ELEMENTS, MOST_DEPTH = 20_000, 100
#: What an attribute or style may point at: a place within the file.
_OUTSIDE = re.compile(r"url\(\s*['\"]?(?!#)|@import|expression\(|javascript:", re.IGNORECASE)


def draw_svg(data: bytes, whose: str, longer_px: int) -> bytes:
    """The drawing as a PNG whose longer side has that many pixels.

    Raises: SpecError for what is no SVG, and for what this module refuses.
    """
    import resvg_py

    width, height = check_svg(data, whose)
    wide, high = (longer_px, None) if width >= height else (None, longer_px)
    try:
        text = data.decode("utf-8")
        return bytes(resvg_py.svg_to_bytes(svg_string=text, skip_system_fonts=True, width=wide, height=high))
    except (ValueError, RuntimeError, UnicodeDecodeError) as error:
        raise SpecError(f"{whose} cannot be drawn ({str(error)[:80]}); save it as a plain SVG, or as PNG") from error


def check_svg(data: bytes, whose: str) -> tuple[float, float]:
    """Width over height of a drawing that may be drawn, in units of its own.

    Raises: SpecError with the first thing that may not be in it.
    """
    if re.search(rb"<!(DOCTYPE[^>\[]*\[|ENTITY)", data, re.IGNORECASE):
        raise SpecError(f"{whose} defines entities of its own; save it as a plain SVG")
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise SpecError(f"{whose} is no SVG ({str(error)[:80]}); save it as a plain SVG, or as PNG") from error
    if _plain(root.tag) != "svg":
        raise SpecError(f"{whose} is no SVG but {_plain(root.tag)!r}; save it as a plain SVG, or as PNG")
    for element in root.iter():
        _check_element(element, whose)
    _check_copies(root, whose)
    return _size(root, whose)


def _check_element(element: ElementTree.Element, whose: str) -> None:
    tag = _plain(element.tag)
    kind = next((name for name in REFUSED if tag.lower().startswith(name.lower())), None)
    if kind is not None:
        raise SpecError(f"{whose} holds {REFUSED[kind]}")
    if _OUTSIDE.search(element.text or "") and tag == "style":
        raise SpecError(f"{whose} asks for something outside of itself in its style; save it as a plain SVG")
    for key, value in element.attrib.items():
        name = _plain(key).lower()
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
            if _plain(element.tag) == "use":
                href = next((value for key, value in element.attrib.items() if _plain(key) == "href"), "")
                inside += [by_id[href[1:]]] if href[1:] in by_id else []
            counted[element] = 1 + sum(drawn(child, depth + 1) for child in inside)
        return counted[element]

    if drawn(root, 0) > MOST_ELEMENTS:
        raise SpecError(f"{whose} draws more than {MOST_ELEMENTS} shapes; simplify it, or save it as PNG")


def _size(root: ElementTree.Element, whose: str) -> tuple[float, float]:
    numbers = [float(part) for part in re.findall(r"-?[\d.]+(?:e-?\d+)?", root.get("viewBox", ""))]
    if len(numbers) != 4:
        lengths = [re.match(r"\s*([\d.]+)", root.get(side, "")) for side in ("width", "height")]
        numbers = [0.0, 0.0, *(float(found[1]) if found else 0.0 for found in lengths)]
    if not (numbers[2] > 0 and numbers[3] > 0 and max(numbers[2:]) <= 50 * min(numbers[2:])):
        raise SpecError(f"{whose} says no size of a logo (viewBox); save it as a plain SVG, or as PNG")
    return numbers[2], numbers[3]


def _plain(tag: object) -> str:
    """A tag or key without its namespace."""
    return str(tag).rpartition("}")[2] if isinstance(tag, str) else ""
