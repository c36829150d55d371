"""Many badges at once: a thousand to a transaction, and one full check for each layout.

Badges of one layout differ only in id, name, line spacings and line edges.  So the first badge of each layout gets the
full check, through JSON and the schema (2 to 12 ms).  Its document is kept as a template, here called a mould.  In the
next ones only those figures are written anew (0.6 ms).  A badge that may not fit the mould, for example with a spacing
that is not a float, gets the full check too, and is refused there if it is wrong.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence, Sized
from dataclasses import dataclass, fields, replace
from operator import attrgetter

from moireid.badge import Badge, Cell, Grating
from moireid.errors import MoireIdError, RegistryError
from moireid.registry.canonical import canonical_json, utc_now
from moireid.registry.erased import erased_among, erased_id
from moireid.registry.ledger import Ledger
from moireid.registry.record import Record, claimable_name, new_record
from moireid.registry.schema import badges, select_records

#: Records to a transaction: others who want to write wait for about half a second.
CHUNK = 1000
#: Number of moulds kept; a batch with more layouts is only slower.
MOULDS = 256
#: Limits within which the schema accepts any figures: letters of a name, mm of spacing, mm of an edge.
NAME_LETTERS, PITCH_MM, EDGE_MM = 200, (0.05, 10.0), 1000.0

_CELL_LAYOUT = attrgetter(*[field.name for field in fields(Cell) if field.name not in ("pitch_mm", "edge_mm")])
_GRATING_LAYOUT = attrgetter(*[field.name for field in fields(Grating) if field.name not in ("pitch_mm", "cells")])


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


class _Mould:
    """A badge that passed the full check: its record, and its document, in which badges of its layout are written."""

    def __init__(self, record: Record) -> None:
        self.record = record
        self._document = json.loads(record.badge_json)

    def pour(self, badge: Badge) -> str:
        """The canonical JSON of a badge of this layout whose figures are finite floats."""
        document = self._document
        document["id"], document["name"] = badge.id, badge.name
        for grating, place in zip(badge.gratings, document["gratings"], strict=True):
            place["pitch_mm"] = grating.pitch_mm
            for cell, inner in zip(grating.cells, place["cells"], strict=True):
                inner["pitch_mm"], inner["edge_mm"] = cell.pitch_mm, cell.edge_mm
        return canonical_json(document)


class Issuer:
    """Makes records of badges, cheaply for those of a layout it has seen."""

    def __init__(self, shown: str, expires: str | None = None) -> None:
        self._shown, self._expires = shown, expires
        self._moulds: dict[Hashable, _Mould] = {}

    def record(self, badge: Badge, issued_at: str) -> Record:
        """The record of a badge that is about to be issued; the same as `new_record` makes, and raises as that does."""
        try:
            layout = _layout(badge)
            mould = self._moulds.get(layout)
        except TypeError:
            # A list in place of a tuple cannot be a key; the full check decides whether the badge can be issued.
            return new_record(badge, self._shown, issued_at, self._expires)
        if mould is not None and _fits(badge, mould):
            name = claimable_name(badge, self._shown)
            return replace(mould.record, id=str(badge.id), name=name, badge_json=mould.pour(badge), issued_at=issued_at)
        record = new_record(badge, self._shown, issued_at, self._expires)
        if len(self._moulds) >= MOULDS:
            self._moulds.clear()
        self._moulds[layout] = _Mould(record)
        return record


def enroll_many(
    ledger: Ledger,
    issued: Iterable[Badge],
    actor: str,
    progress: Callable[[int, int | None], None] | None,
    entered: Callable[[Sequence[Record]], None],
    expires: str | None,
) -> Batch:
    """What `Registry.enroll_many` does; entered: called with each chunk's new records; expires: the last day of all."""
    total = len(issued) if isinstance(issued, Sized) else None
    enrolled = unchanged = revoked = 0
    for records, refusal in _chunks(issued, Issuer(ledger.shown, expires)):
        new, holders, conflict = enter(ledger, records, actor)
        entered(new)
        enrolled += len(new)
        unchanged += len(holders)
        revoked += sum(holder.revoked_at is not None for holder in holders)
        if progress:
            progress(enrolled + unchanged, total)
        fault = conflict or refusal
        if fault:
            raise fault
    return Batch(enrolled, unchanged, revoked)


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
                "another badge for another day, or leave --expires out",
                id=record.id,
                expires=holder.expires,
            )
        return holder
    other = "with another badge " if holder.name == record.name else ""
    raise RegistryError(
        f"id {record.id} is issued already to {holder.name!r} {other}({holder.issued_at}), so {record.name!r} "
        "cannot have this badge; print one with another --payload",
        id=record.id,
        holder=holder.name,
        issued_at=holder.issued_at,
    )


def _chunks(issued: Iterable[Badge], issuer: Issuer) -> Iterator[tuple[list[Record], MoireIdError | None]]:
    """Records in chunks; the last chunk ends before the first badge that cannot be issued, and has the reason."""
    records: list[Record] = []
    for badge in issued:
        try:
            records.append(issuer.record(badge, utc_now()))
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


def _layout(badge: Badge) -> Hashable:
    """All that a badge and its mould must share: every field except those that `pour` fills in."""
    bare = replace(badge, id=None, name="", gratings=(), print=None)
    # If a grating carries no code, its spacings are part of its layout.
    gratings = tuple(
        (_GRATING_LAYOUT(grating), tuple(map(_CELL_LAYOUT, grating.cells)) if grating.code else grating.cells)
        for grating in badge.gratings
    )
    return bare, gratings, repr(badge.print)


def _fits(badge: Badge, mould: _Mould) -> bool:
    """Whether the schema surely allows the figures that `pour` puts in."""
    digits = len(mould.record.id)
    if not isinstance(badge.id, str) or not re.fullmatch(f"[0-9a-f]{{{digits}}}", badge.id):
        return False
    cells = [cell for grating in badge.gratings for cell in grating.cells]
    pitches_mm = [grating.pitch_mm for grating in badge.gratings] + [cell.pitch_mm for cell in cells]
    return (
        len(badge.name) <= NAME_LETTERS
        and _all_floats(pitches_mm, *PITCH_MM)
        and _all_floats([cell.edge_mm for cell in cells], -EDGE_MM, EDGE_MM)
    )


def _all_floats(values: list[float], least: float, most: float) -> bool:
    """Whether all values are floats, not whole numbers, from `least` to `most`; NaN is not, but hides from min."""
    in_range = all(type(value) is float for value in values) and least <= min(values) and max(values) <= most
    return in_range and math.isfinite(sum(values))
