"""What one badge shows apart from the name: logo, portrait and colour; and the lines below the name.

The lines are in `Badge.print` ("lines"), since they distinguish people of one name.  Pictures are stored as paths and
loaded when they are drawn, since a list of people may name thousands.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.artwork.colours import Colour, colour_named
from moireid.artwork.pictures import as_portrait, load_picture, picture_of
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.files import AnyPath, as_path
from moireid.names import MOST_LINES, line_fault

if TYPE_CHECKING:
    from PIL import Image

MOST_LETTERS = 80


@dataclass(frozen=True)
class Artwork:
    """Paths of the pictures, and the colour of the template's accents; None where there is none."""

    logo: Path | None = None
    portrait: Path | None = None
    colour: Colour | None = None

    def picture(self, what: str) -> Image.Image | None:
        """The logo, or the portrait in its shape, RGBA.  Raises: SpecError as `load_picture`."""
        path = self.logo if what == "logo" else self.portrait
        return None if path is None else _loaded(path, what)


@lru_cache(maxsize=8)
def _loaded(path: Path, what: str) -> Image.Image:
    picture = load_picture(path, what)
    return as_portrait(picture) if what == "portrait" else picture


def forget_pictures() -> None:
    """Drop all loaded pictures, in a long-running program that serves many users."""
    _loaded.cache_clear()
    picture_of.cache_clear()


def content_of(logo: AnyPath | None = None, portrait: AnyPath | None = None, colour: str | None = None) -> Artwork:
    """The content that options or a row of a list give.

    Raises: SpecError for what is no picture or no colour.
    """
    logo, portrait = (None if one is None else as_path(one) for one in (logo, portrait))
    content = Artwork(logo, portrait, colour_named(colour) if colour else None)
    for what in ("logo", "portrait"):
        content.picture(what)
    return content


def with_lines(badge: Badge, lines: Sequence[str]) -> Badge:
    """The badge with these lines below its name.  Raises: SpecError as `clean_lines`."""
    cleaned = clean_lines(lines)
    return replace(badge, print=(badge.print or {}) | {"lines": list(cleaned)}) if cleaned else badge


def lines_of(badge: Badge) -> tuple[str, ...]:
    """The lines below a badge's name, from above to below."""
    lines = (badge.print or {}).get("lines")
    return tuple(line for line in lines if isinstance(line, str)) if isinstance(lines, list | tuple) else ()


def clean_lines(lines: Sequence[str]) -> tuple[str, ...]:
    """The lines in NFC, without surrounding space and empty ones.

    Raises: SpecError for too many or too long lines, and for what is no plain text.
    """
    cleaned = [unicodedata.normalize("NFC", line).strip() for line in lines]
    cleaned = [line for line in cleaned if line]
    if len(cleaned) > MOST_LINES:
        raise SpecError(f"{len(cleaned)} lines are too many, at most {MOST_LINES} fit on a badge; leave some out")
    for line in cleaned:
        if len(line) > MOST_LETTERS:
            raise SpecError(
                f"line {line[:30]!r}… has {len(line)} characters, at most {MOST_LETTERS} can be read; shorten it"
            )
        if (fault := line_fault(line)) is not None:
            raise SpecError(f"line {line[:30]!r} {fault}; give plain text")
    return tuple(cleaned)
