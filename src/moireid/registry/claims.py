"""From a claim, a name or an id, to the one record it means.

Convention: names are compared exactly after Unicode NFC, ids in lower case; nothing else is folded or trimmed.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable

from sqlalchemy import or_

from moireid.errors import RegistryError
from moireid.registry.engine import AnyRow, AnySelect
from moireid.registry.record import storable
from moireid.registry.schema import badges, select_records

#: More matches than this are counted, not listed, in a message.
LISTED = 10


def find_row(claim: str, rows: Callable[[AnySelect], list[AnyRow]], shown: str) -> AnyRow:
    """The one row of `select_records` that `claim` means; `rows` runs a query in the registry called `shown`.

    Raises: RegistryError where there is none, or more than one; `error.details["ids"]` lists those.
    """
    name = unicodedata.normalize("NFC", claim)
    matches = []
    if storable(name):
        means = or_(badges.c.name_nfc == name, badges.c.id == as_id(claim))
        matches = rows(select_records().where(means).order_by(badges.c.id))
    if not matches:
        raise RegistryError(
            f"nobody named {name[:80]!r} and no such id is in registry {shown}; `moireid registry list` shows who is",
            claim=claim,
            ids=[],
        )
    if len(matches) > 1:
        raise _ambiguous(claim, name, matches)
    return matches[0]


def as_id(claim: str) -> str:
    """The claim in the form of an id."""
    return claim.lower()


def _ambiguous(claim: str, name: str, matches: list[AnyRow]) -> RegistryError:
    """The error that lists the several records which a claim may mean."""
    ids = [row.id for row in matches]
    named = [row.id for row in matches if row.name_nfc == name]
    listed = ", ".join(named[:LISTED]) + (f" and {len(named) - LISTED} more" if len(named) > LISTED else "")
    of_id = [row for row in matches if row.id not in named]
    if not of_id:
        message = f"{len(named)} people are named {name[:80]!r}, with ids {listed}; claim one of these ids"
    else:
        message = (
            f"{name[:80]!r} is the id of {of_id[0].name_nfc!r} and also the name on {listed}; "
            f"claim the name {of_id[0].name_nfc!r}, or the id {named[0]}"
        )
    return RegistryError(message, claim=claim, ids=ids)
