"""From a claim (a name or an id) to the one record that it means.

Convention: names and the lines below them are compared exactly after Unicode NFC, ids in lower case; nothing else is
folded or trimmed.  "Ana Silva, Reporter" means a person of that whole name, or a person named Ana Silva with the line
Reporter; if both exist, the claim is refused.  It is also refused if the line looks like that of a namesake.
"""

from __future__ import annotations

import difflib
import json
import unicodedata
from collections.abc import Callable

from sqlalchemy import or_

from moireid.errors import RegistryError
from moireid.names import claim_text, id_with_line, line_of, named_by
from moireid.registry.canonical import unpack
from moireid.registry.engine import AnyRow, AnySelect
from moireid.registry.look_alikes import by_line, line_alike
from moireid.registry.record import storable
from moireid.registry.schema import badges, select_records

#: More matches than this are counted, not listed, in a message.
LISTED = 10
#: So many near names are suggested, found among so many records.
NEAR, MOST_COMPARED = 3, 2000


def find_row(claim: str, rows: Callable[[AnySelect], list[AnyRow]], shown: str) -> AnyRow:
    """The one row of `select_records` that `claim` means; `rows` runs a query in the registry called `shown`.

    Raises: RegistryError if there is none, or more than one; `error.details["ids"]` lists those.  Also as
        `claim_text`.
    """
    name = claim_text(claim)
    matches = []
    if storable(name):
        pairs = named_by(name)
        names = [name, *(first for first, _ in pairs)]
        means = or_(badges.c.name_nfc.in_(names), badges.c.id == as_id(claim))
        found = rows(select_records().where(means).order_by(badges.c.id))
        matches = [
            row
            for row in found
            if row.name_nfc == name or row.id == as_id(claim) or (row.name_nfc, row_line(row)) in pairs
        ]
    if not matches:
        near = _near(name, rows) if storable(name) else ""
        raise RegistryError(
            f"no one named {name[:80]!r} and no such id is in registry {shown}{near}; `moireid registry list` shows "
            "who is",
            claim=claim,
            ids=[],
        )
    if len(matches) > 1:
        raise _ambiguous(claim, name, matches)
    _check_line(claim, matches[0], found)
    return matches[0]


def _near(name: str, rows: Callable[[AnySelect], list[AnyRow]]) -> str:
    """Names like this one, or that hold it, for a person who mistyped; empty where there are none or too many."""
    held = rows(select_records().order_by(badges.c.id).limit(MOST_COMPARED))
    by_fold = {row.name_nfc.casefold(): row.name_nfc for row in held}
    folded = name.casefold()
    near = (
        difflib.get_close_matches(folded, by_fold, n=NEAR) or [one for one in by_fold if folded in one.split()][:NEAR]
    )
    return f" (did you mean {' or '.join(repr(by_fold[one][:40]) for one in near)}?)" if near else ""


def chosen_line(claim: str, name: str, badge_id: str, line: str | None) -> str | None:
    """The line by which a claim chose the person of this name, id and line; None if it is the name or the id."""
    return None if unicodedata.normalize("NFC", claim) == name or as_id(claim) == badge_id else line


def _check_line(claim: str, row: AnyRow, found: list[AnyRow]) -> None:
    """Raise RegistryError if a row was chosen by a line that looks like that of a namesake among those found."""
    line = chosen_line(claim, row.name_nfc, row.id, row_line(row))
    others = [one for one in found if one.name_nfc == row.name_nfc and line_alike(line, [row_line(one)])]
    if others:
        alike = [row, *others]
        listed = ", ".join(id_with_line(one.id, row_line(one)) for one in alike[:LISTED])
        raise RegistryError(
            f"{len(alike)} people are named {row.name_nfc[:80]!r} with lines that look alike, with ids {listed}; claim "
            "one of these ids",
            claim=claim,
            ids=[one.id for one in alike],
            by_line="",
        )


def as_id(claim: str) -> str:
    """The claim in the form of an id."""
    return claim.lower()


def _ambiguous(claim: str, name: str, matches: list[AnyRow]) -> RegistryError:
    """The error that lists the several records which a claim may mean."""
    ids = [row.id for row in matches]
    of_id = [row for row in matches if row.id == as_id(claim) and row.name_nfc != name]
    others = [row for row in matches if row not in of_id]
    named = [row.id for row in others]
    listed = ", ".join(id_with_line(row.id, row_line(row)) for row in others[:LISTED])
    listed += f" and {len(named) - LISTED} more" if len(named) > LISTED else ""
    also = by_line([(row.name_nfc, row_line(row)) for row in others])
    if not of_id:
        message = f"{len(named)} people are named {name[:80]!r}, with ids {listed}; claim one of these ids"
        message += also
    else:
        message = (
            f"{name[:80]!r} is the id of {of_id[0].name_nfc!r} and also the name on {listed}; "
            f"claim the name {of_id[0].name_nfc!r}, or the id {named[0]}"
        )
    return RegistryError(message, claim=claim, ids=ids, by_line=also)


def row_line(row: AnyRow) -> str | None:
    """The line below the name on a row's badge, as its document has it; None if there is none, or no such document.

    Whether the authority signed it is checked when the one row that is meant is read.
    """
    try:
        return line_of(json.loads(unpack(row.badge)).get("print"))
    except (ValueError, AttributeError):
        return None
