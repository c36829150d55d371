"""What whoever imports is told of names: those that look alike, and those with letters that nobody sees."""

from __future__ import annotations

import unicodedata

from sqlalchemy import func, select

from moireid.names import hidden_words
from moireid.registry.ledger import Ledger
from moireid.registry.schema import badges

#: Of each kind so many are told.
TOLD = 20


def notes_on(ledger: Ledger) -> tuple[str, ...]:
    """A sentence for each group of names that look alike, and for each name with hidden letters, in all that is held.

    An import takes such names in: a registry of before may hold them, and a backup must come back whole.
    """
    found = []
    for look in (badges.c.skeleton, badges.c.folded):
        several = select(look).group_by(look).having(func.count(badges.c.name_nfc.distinct()) > 1).limit(TOLD)
        for row in ledger.rows(several):
            names = ledger.rows(select(badges.c.name_nfc).where(look == row[0]).distinct().limit(TOLD))
            listed = " and ".join(repr(one) for one in sorted(name for (name,) in names))
            found.append(f"the names {listed} look alike, and are of different people")
    for (name,) in ledger.rows(select(badges.c.name_nfc).where(badges.c.name_nfc.is_not(None))):
        if not name.isascii() and (words := hidden_words(unicodedata.normalize("NFC", name))):
            found.append(f"the name {name!r} {words}")
    return tuple(dict.fromkeys(found))
