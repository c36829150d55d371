"""The columns of a list of people that say how each badge looks: logo, portrait, colour, and line, line1 … line4.

Paths are relative to the list's folder and stay below it, since a list may come from elsewhere: it must not print other
files of this machine.  Where a cell is empty, the look of the whole list is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from moireid.artwork.content import Artwork, content_of, with_lines
from moireid.artwork.placing import Look
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.names import LINE_COLUMNS, PICTURE_COLUMNS


def lines_in(cells: Mapping[str, str]) -> list[str]:
    """The lines of a row, from above to below; a role where there is no line."""
    lines = [cells[column] for column in LINE_COLUMNS if cells.get(column)]
    return lines or [role for role in [cells.get("role", "")] if role]


def look_in(cells: Mapping[str, str], look: Look, folder: Path) -> Look:
    """The look of a row: that of the whole list, with the row's own pictures and colour.

    Raises: SpecError as `content_of`, and for a file that is not below the folder.
    """
    given = look.content
    colour = cells.get("colour") or cells.get("color")
    own = content_of(_path(cells.get("logo"), folder), _path(cells.get("portrait"), folder), colour)
    content = Artwork(own.logo or given.logo, own.portrait or given.portrait, own.colour or given.colour)
    return replace(look, content=content)


def dressed(
    badge: Badge, cells: Mapping[str, str], look: Look | None, lines: Sequence[str], folder: Path
) -> tuple[Badge, Look | None]:
    """A badge of a list with its lines, and its look.

    Parameters: look, lines: those of the whole list, used where a row has none.
    Raises: SpecError as `content_of` and `content.with_lines`, and for pictures on a board that has no template.
    """
    if look is None and (named := next((column for column in PICTURE_COLUMNS if cells.get(column)), None)):
        raise SpecError(f"the column {named} needs a template, so that all boards have room for it; give --template")
    badge = with_lines(badge, lines_in(cells) or lines)
    return badge, look and look_in(cells, look, folder)


def kept_pictures(looks: Sequence[Look | None]) -> list[Path]:
    """The files of all pictures, which nothing may replace."""
    contents = [look.content for look in looks if look is not None]
    return list({path for content in contents for path in (content.logo, content.portrait) if path is not None})


def _path(cell: str | None, folder: Path) -> Path | None:
    """The file that a cell names.  Raises: SpecError where it does not lie below the list's folder."""
    if not cell:
        return None
    given = Path(cell)
    if given.is_absolute() or ".." in given.parts or not _below(folder / given, folder):
        raise SpecError(f"the file {cell[:80]!r} is not below the list's folder; put it there, and name it from there")
    return folder / given


def _below(path: Path, folder: Path) -> bool:
    """Whether a path stays below a folder, wherever links lead."""
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # Links in a circle; letters that no path holds.
        return False
