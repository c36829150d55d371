"""Names: their invisible letters, and the line below a name.

With hidden letters one name passes for another.  Allowed are the few that a script or a picture letter is spelled
with, after a letter beyond ASCII.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from typing import Any

#: Code points that are drawn as nothing (Default_Ignorable_Code_Point of Unicode), first and last of each range.
INVISIBLE = (
    (0x00AD, 0x00AD),
    (0x034F, 0x034F),
    (0x061C, 0x061C),
    (0x115F, 0x1160),
    (0x17B4, 0x17B5),
    (0x180B, 0x180F),
    (0x200B, 0x200F),
    (0x202A, 0x202E),
    (0x2060, 0x206F),
    (0x3164, 0x3164),
    (0xFE00, 0xFE0F),
    (0xFEFF, 0xFEFF),
    (0xFFA0, 0xFFA0),
    (0xFFF0, 0xFFF8),
    (0x1BCA0, 0x1BCA3),
    (0x1D173, 0x1D17A),
    (0xE0000, 0xE0FFF),
)
JOINERS = "\u200c\u200d"
#: Letters that a script or a picture letter is spelled with: joiners, and variation selectors of both.
SPELLING = JOINERS + "\ufe0e\ufe0f\u180b\u180c\u180d\u180e\u180f"
#: A longer name or line does not fit on a badge, and is too long to type as a claim.
NAME_LIMIT, MOST_LINES = 200, 4
#: The columns of a list that hold the lines below a name, from above to below.
PICTURE_COLUMNS = ("logo", "portrait", "colour", "color")
LINE_COLUMNS = ("line", *(f"line{number}" for number in range(1, MOST_LINES + 1)))
#: Unicode categories that no name needs: control, format (which can turn text round), surrogates, private use,
#: unassigned, and line and paragraph ends.  The joiners that some scripts spell with are let through.
UNPRINTABLE = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")


def hidden_letters(name: str) -> list[str]:
    """The invisible letters of a name that its spelling does not need.

    Returns: their Unicode names, each once, in the order of the name; directional marks are among them.
    """
    found = (letter for place, letter in enumerate(name) if _invisible(letter) and not _spells(name, place))
    return [unicodedata.name(letter, f"U+{ord(letter):04X}") for letter in dict.fromkeys(found)]


def hidden_words(name: str) -> str | None:
    """What is said of a name with hidden letters, as a part of a sentence; None where it has none."""
    found = hidden_letters(name)
    if not found:
        return None
    more = f" and {len(found) - 3} more" if len(found) > 3 else ""
    return f"holds invisible letters ({', '.join(found[:3])}{more})"


def unprintable(text: str) -> bool:
    """Whether a name or line holds letters that no text needs, or is of joiners alone."""
    visible = text.strip(JOINERS)
    return not visible or any(
        unicodedata.category(letter) in UNPRINTABLE and letter not in JOINERS for letter in visible
    )


def encoded_twice(text: str) -> str | None:
    """What a text was before its UTF-8 was read as Windows-1252 ("JosÃ©" for "José"); None where it is itself.

    No name is spelled so: each letter beyond ASCII would have to be followed by the signs that UTF-8 continues with.
    """
    if text.isascii():
        return None
    for encoding in ("cp1252", "latin-1"):
        try:
            return text.encode(encoding).decode("utf-8")
        except UnicodeError:
            continue
    return None


def line_fault(line: object) -> str | None:
    """Why something cannot be printed below a name, as a part of a sentence; None where it can."""
    if not isinstance(line, str):
        return "is no text"
    if len(line) > NAME_LIMIT:
        return f"has {len(line)} characters, at most {NAME_LIMIT} fit"
    if line.strip() and unprintable(line.strip()):
        return "holds control, invisible or unassigned characters"
    if (meant := encoded_twice(line)) is not None:
        return f"was encoded twice, and is probably {meant[:40]!r}"
    return hidden_words(line)


def _invisible(letter: str) -> bool:
    return any(first <= ord(letter) <= last for first, last in INVISIBLE)


def _spells(name: str, place: int) -> bool:
    """Whether the letter at `place` may belong there: other scripts join and vary their letters, ASCII never does.

    What it lets through at a wrong place, look-alikes find: they are compared without such letters.
    """
    return name[place] in SPELLING and not name[place - 1 : place].isascii()


def line_of(print_data: Mapping[str, Any] | None) -> str | None:
    """The first line below the name on a badge, None where there is none, or
    none of plain text: the writer of a badge's file can put anything there.

    Parameters: print_data: `Badge.print`, whose key "lines" holds the lines from above to below.
    """
    lines = (print_data or {}).get("lines")
    first = lines[0] if isinstance(lines, list | tuple) and lines else None
    if not isinstance(first, str) or line_fault(first) is not None:
        return None
    return unicodedata.normalize("NFC", first).strip() or None


def name_with_line(name: str, line: str | None) -> str:
    """A person by name and line, for people who know several of one name."""
    return name if line is None else f"{name}, {line}"


def id_with_line(badge_id: str, line: str | None) -> str:
    """An id with the line on its badge, for a list of namesakes."""
    return badge_id if line is None else f"{badge_id} ({line[:60]})"
