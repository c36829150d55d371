"""The columns of a list of people that say how each badge looks: logo, portrait, colour, and line, line1 … line4.

Paths are relative to the list's folder and stay below it, since a list may come from elsewhere: it must not print other
files of this machine.  Where a cell is empty, the look of the whole list is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from moireid.artwork.content import Artwork, content_of, with_lines
from moireid.artwork.placing import Look
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.names import LINE_COLUMNS

#: The file of a picture, "logo" or "portrait", by what a cell says.
FindPicture = Callable[[str, str], Path]


def lines_in(cells: Mapping[str, str]) -> list[str]:
    """The lines of a row, from above to below; a role where there is no line."""
    lines = [cells[column] for column in LINE_COLUMNS if cells.get(column)]
    return lines or [role for role in [cells.get("role", "")] if role]


def dressed(
    badge: Badge, cells: Mapping[str, str], look: Look | None, lines: Sequence[str], find: FindPicture
) -> Badge:
    """A badge of a list with its lines and its look: that of the whole list, with its own pictures and colour.

    Parameters: look, lines: those of the whole list, used where a row has none; find: the file that a cell names.
    Raises: SpecError as `content_of`, `content.with_lines` and `find`.
    """
    badge = with_lines(badge, lines_in(cells) or lines)
    if look is None:
        return badge
    logo, portrait = (find(what, cell) if (cell := cells.get(what)) else None for what in ("logo", "portrait"))
    mine, given = content_of(logo, portrait, cells.get("colour") or cells.get("color")), look.content
    content = Artwork(mine.logo or given.logo, mine.portrait or given.portrait, mine.colour or given.colour)
    return replace(badge, look=replace(look, content=content))


def kept_pictures(badges: Sequence[Badge]) -> list[Path]:
    """The files of all pictures, which nothing may replace."""
    contents = [badge.look.content for badge in badges if badge.look is not None]
    return list({path for content in contents for path in (content.logo, content.portrait) if path is not None})


def files_below(folder: Path) -> FindPicture:
    """Finds the files of a list in its own folder; the error says where one is not."""

    def find(what: str, cell: str) -> Path:
        given = Path(cell)
        if given.is_absolute() or ".." in given.parts or not _below(folder / given, folder):
            raise SpecError(
                f"the file {cell[:80]!r} is not below the list's folder; put it there, and name it from there"
            )
        return folder / given

    return find


def _below(path: Path, folder: Path) -> bool:
    """Whether a path stays below a folder, wherever links lead."""
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # Links in a circle; letters that no path holds.
        return False
