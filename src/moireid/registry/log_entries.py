"""The log's entries for display: what was done to which badge, when, and by whom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import select

from moireid.registry.ledger import Ledger
from moireid.registry.log import ERASE_ACTOR
from moireid.registry.schema import actors, log


@dataclass(frozen=True)
class Entry:
    """One entry of the log.

    Attributes
    ----------
    seq : int
        Its number; the first is 1.
    time : str
        UTC, ISO 8601 to the second.
    action : str
        Such as "enroll", "revoke", "as_built", "import", "erase".
    subject : str
        The badge's id; of the first entry the authority's fingerprint, of "erase_actor" the actor's commitment.
    actor : str or None
        Who did it; None if they were erased, or the entry is of a version that named no actor.
    actor_erased : bool
        Whether they were erased.
    """

    seq: int
    time: str
    action: str
    subject: str
    actor: str | None
    actor_erased: bool

    def to_json(self) -> dict[str, Any]:
        """Make the JSON object that ``moireid registry log --json`` prints.

        Returns
        -------
        dict
            An object that JSON can hold.
        """
        return dict(vars(self))


def entries_of(ledger: Ledger, subject: str | None, limit: int | None) -> list[Entry]:
    """What `Registry.entries` does."""
    query = select(log, actors.c.name).outerjoin(actors, actors.c.commitment == log.c.actor)
    if subject is not None:
        query = query.where(log.c.subject == subject)
    rows = ledger.rows(query.order_by(log.c.seq.desc()).limit(limit))
    # Only a signed entry says that an actor was erased; else the name is missing, which the audit finds.
    gone = {row.subject for row in ledger.rows(select(log.c.subject).where(log.c.action == ERASE_ACTOR))}
    return [
        Entry(row.seq, row.time, row.action, row.subject, row.name, row.actor is not None and row.actor in gone)
        for row in rows
    ]
