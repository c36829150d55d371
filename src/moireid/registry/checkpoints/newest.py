"""The check that a record is the newest version in the log.

Reading a record compares it only with its newest entry among those that are present.  An attacker who can write to the
database could put back a record as it was before its revocation, and remove the revocation's entry from the middle of
the log.  The chain then has a gap, which the walk up to the signed head finds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from sqlalchemy import func, select

from moireid.errors import RegistryError
from moireid.registry.ledger import PAGE, Ledger
from moireid.registry.log import Head, followed
from moireid.registry.record import Fault, Record
from moireid.registry.schema import log


def check_newest(ledger: Ledger, record: Record) -> None:
    """Walk the log from the record's newest entry to its signed head.

    Raises: RegistryError if an entry on the way was changed or taken out, or is about another version of the record; or
        if witnesses must have seen it, and it is later than they have.  What bars a badge counts unseen.
    Source: each entry's hash holds that of the entry before, and the head is signed; so no signature on the way counts.
    A walk over 100,000 entries takes about a second.
    """
    with ledger.snapshot() as connection:
        head = ledger.head_in(connection)
        begin = select(func.max(log.c.seq)).where(log.c.subject == record.id).scalar_subquery()
        rows = connection.execution_options(yield_per=PAGE).execute(
            select(log).where(log.c.seq >= begin).order_by(log.c.seq)
        )
        names = list(rows.keys())
        entry = _follow((dict(zip(names, row, strict=True)) for row in rows), record, head, ledger.witnessed)
    if ledger.witnessed is not None and entry > ledger.witnessed.seq and record.barred() is None:
        raise RegistryError(
            f"the record of badge {record.id} is of log entry {entry}, and witnesses have seen {ledger.witnessed.seq} "
            "entries; get a newer checkpoint from those who run the registry",
            code="not_witnessed",
        )


def _follow(entries: Iterable[Mapping[str, Any]], record: Record, head: Head, witnessed: Head | None) -> int:
    """Follow the chain from the first of these entries, the record's own, to the head; its number.  Raises: Fault.

    Parameters: witnessed: the last entry that witnesses have seen, which must be on the way if it is not before it.
    """
    first, before = 0, None
    for entry in entries:
        if before is None and entry["record_sha256"] != record.digest():
            raise Fault("record_stale", f"the record of id {record.id} is not the version that the log has last")
        before = followed(entry, before)
        first = first or before.seq
        if witnessed is not None and before.seq == witnessed.seq and before != witnessed:
            raise Fault("forked", f"log entry {before.seq} is not the one that witnesses have seen")
    if before is None:
        raise Fault("record_unlogged", f"the log has no entry for the record of id {record.id}")
    if before != head:
        raise Fault("log_cut", f"the log does not lead from the record of id {record.id} to its signed head")
    return first
