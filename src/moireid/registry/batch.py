"""Many badges at once, in one transaction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from moireid.errors import RegistryError
from moireid.registry.ledger import Ledger
from moireid.registry.record import Record
from moireid.registry.schema import badges, select_records


@dataclass(frozen=True)
class Batch:
    """The result of enrolling a batch.

    Attributes
    ----------
    enrolled : int
        New records.
    unchanged : int
        Badges that were enrolled already.
    revoked : int
        Those of the unchanged that are revoked.
    """

    enrolled: int
    unchanged: int
    revoked: int


def same_or_conflict(record: Record, holder: Record) -> Record:
    """`holder`, the record that holds the id of `record`, if both are of the very same badge.

    Raises: RegistryError if they are not, or if `record` has another day of expiry than the one that was issued.
    """
    # Texts of one badge may differ if a whole number is written with or without its point.
    if holder.badge_json == record.badge_json or holder.badge == record.badge:
        if record.expires not in (None, holder.expires):
            now = f"expires on {holder.expires}" if holder.expires else "has no day of expiry"
            raise RegistryError(
                f"badge {record.id} of {holder.name!r} was issued on {holder.issued_at} and {now}, which stays; print "
                "another badge for another day, or leave expires= out",
                id=record.id,
                expires=holder.expires,
            )
        return holder
    other = "with another badge " if holder.name == record.name else ""
    raise RegistryError(
        f"id {record.id} is issued already to {holder.name!r} {other}({holder.issued_at}), so {record.name!r} "
        "cannot have this badge; print one with another payload=",
        id=record.id,
        holder=holder.name,
        issued_at=holder.issued_at,
    )


def enter(ledger: Ledger, records: Sequence[Record], actor: str) -> tuple[list[Record], list[Record]]:
    """Enter those records that are new, all of them or none.

    Returns: those entered, as they are stored, and the records that were there.
    Raises: RegistryError for the first that cannot be issued.
    """
    new: list[Record] = []
    there: list[Record] = []
    with ledger.writing(actor) as transaction:
        ids = [record.id for record in records]
        holders = {holder.id: holder for holder in transaction.records(select_records().where(badges.c.id.in_(ids)))}
        for record in records:
            holder = holders.setdefault(record.id, record)
            if holder is record:
                new.append(record)
            else:
                there.append(same_or_conflict(record, holder))
        return transaction.enter(new, "enroll"), there
