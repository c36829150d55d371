"""From a claim (a name or an id) to the one record that it means.

Convention: names are compared exactly after Unicode NFC, ids in lower case; nothing else is folded or trimmed.
"""

from __future__ import annotations

import difflib
import unicodedata

from sqlalchemy import or_, select

from moireid.errors import RegistryError
from moireid.names import NAME_LIMIT, id_with_line
from moireid.registry.ledger import Ledger
from moireid.registry.record import Record, storable
from moireid.registry.schema import badges, select_records

#: More matches than this are counted, not listed, in a message.
LISTED = 10
#: So many near names are suggested, found among so many records.
NEAR, MOST_COMPARED = 3, 2000


def find_record(claim: str, ledger: Ledger) -> Record:
    """The one record that `claim` means.

    Raises: RegistryError if there is none, or more than one; `error.details["ids"]` lists those.
    """
    name = unicodedata.normalize("NFC", claim)
    means = or_(badges.c.name_nfc == name, badges.c.id == as_id(claim))
    matches = ledger.records(select_records().where(means).order_by(badges.c.id)) if storable(name) else []
    if not matches:
        near = _near(name, ledger) if storable(name) and len(name) <= NAME_LIMIT else ""
        raise RegistryError(
            f"no one named {name[:80]!r} and no such id is in registry {ledger.shown}{near}; `moireid registry list` "
            "shows who is",
            claim=claim,
            ids=[],
        )
    if len(matches) > 1:
        ids = [one.id for one in matches]
        listed = ", ".join(id_with_line(one.id, one.line) for one in matches[:LISTED])
        listed += f" and {len(ids) - LISTED} more" if len(ids) > LISTED else ""
        text = f"{len(ids)} people are named {name[:80]!r}, with ids {listed}; claim one of these ids"
        if (other := next((one for one in matches if one.name != name), None)) is not None:
            text = f"{name[:80]!r} is the id of {other.name!r} and also a name: {listed}; claim the other id"
        raise RegistryError(text, claim=claim, ids=ids)
    return matches[0]


def _near(name: str, ledger: Ledger) -> str:
    """Names like this one, or that hold it, for a person who mistyped; empty where there are none or too many."""
    held = ledger.rows(select(badges.c.name_nfc).order_by(badges.c.id).limit(MOST_COMPARED))
    by_fold = {row.name_nfc.casefold(): row.name_nfc for row in held}
    folded = name.casefold()
    near = (
        difflib.get_close_matches(folded, by_fold, n=NEAR) or [one for one in by_fold if folded in one.split()][:NEAR]
    )
    return f" (did you mean {' or '.join(repr(by_fold[one][:40]) for one in near)}?)" if near else ""


def as_id(claim: str) -> str:
    """The claim in the form of an id."""
    return claim.lower()
