"""Many badges at once: a thousand to a transaction."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from moireid.badge import Badge
from moireid.errors import MoireIdError, RegistryError
from moireid.registry.canonical import utc_now
from moireid.registry.ledger import Ledger, erased_among, erased_id
from moireid.registry.record import Record, new_record
from moireid.registry.schema import badges, select_records

#: Records to a transaction: others who want to write wait for about half a second.
CHUNK = 1000


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


def new_records(
    issued: Iterable[Badge], shown: str, expires: str | None
) -> Iterator[tuple[list[Record], MoireIdError | None]]:
    """Records in chunks; the last chunk ends before the first badge that cannot be issued, and has the reason."""
    records: list[Record] = []
    for badge in issued:
        try:
            records.append(new_record(badge, shown, utc_now(), expires))
        except MoireIdError as refusal:
            yield records, refusal
            return
        if len(records) == CHUNK:
            yield records, None
            records = []
    yield records, None


def enter(
    ledger: Ledger, records: Sequence[Record], actor: str
) -> tuple[list[Record], list[Record], RegistryError | None]:
    """Enter those records that are new, up to the first conflict.

    Returns: those entered, as they are stored, the records that were there, and the conflict or None.
    """
    if not records:
        return [], [], None
    new: list[Record] = []
    there: list[Record] = []
    conflict = None
    with ledger.writing(actor) as transaction:
        ids = [record.id for record in records]
        holders = {holder.id: holder for holder in transaction.records(select_records().where(badges.c.id.in_(ids)))}
        erased = set(erased_among(transaction.connection, ids))
        for record in records:
            if record.id in erased:
                conflict = erased_id(record.id)
                break
            holder = holders.setdefault(record.id, record)
            if holder is record:
                new.append(record)
                continue
            try:
                there.append(same_or_conflict(record, holder))
            except RegistryError as error:
                conflict = error
                break
        return transaction.enter(new, "enroll"), there, conflict
