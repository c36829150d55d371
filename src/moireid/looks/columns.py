"""What a list of people says of their looks: the columns logo, portrait, colour, and line, line1 … line4.

Paths are relative to the list's folder.  An empty cell leaves what holds for all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.looks.content import Content, content_of, with_lines
from moireid.looks.placing import Look
from moireid.names import LINE_COLUMNS

PICTURES = ("logo", "portrait", "colour", "color")


def lines_in(cells: Mapping[str, str]) -> list[str]:
    """The lines of a row, from above to below; a role where there is no line."""
    lines = [cells[column] for column in LINE_COLUMNS if cells.get(column)]
    return lines or [role for role in [cells.get("role", "")] if role]


def look_in(cells: Mapping[str, str], look: Look, folder: Path) -> Look:
    """The look of a row: that of all, with the row's own pictures and colour.  Raises: SpecError as `content_of`."""
    given = look.content
    colour = cells.get("colour") or cells.get("color")
    own = content_of(_path(cells.get("logo"), folder), _path(cells.get("portrait"), folder), colour)
    content = Content(own.logo or given.logo, own.portrait or given.portrait, own.colour or given.colour)
    return Look(look.template, content, look.corner_mm)


def dressed(
    badge: Badge, cells: Mapping[str, str], look: Look | None, lines: Sequence[str], folder: Path
) -> tuple[Badge, Look | None]:
    """A badge of a list with its lines, and its look.

    Parameters: look, lines: what holds for all.
    Raises: SpecError as `content_of` and `content.with_lines`, and for pictures on a board that has no template.
    """
    if look is None and (named := next((column for column in PICTURES if cells.get(column)), None)):
        raise SpecError(f"the column {named} needs a template, so that all boards have room for it; give --template")
    badge = with_lines(badge, lines_in(cells) or lines)
    return badge, look and look_in(cells, look, folder)


def kept_pictures(looks: Sequence[Look | None]) -> list[Path]:
    """The files of all pictures, which nothing may replace."""
    contents = [look.content for look in looks if look is not None]
    return list({path for content in contents for path in (content.logo, content.portrait) if path is not None})


def _path(cell: str | None, folder: Path) -> Path | None:
    return folder / cell if cell else None
