"""Import of an export: all of it or nothing.

1. The file is read into its own registry in a temporary folder, and audited there.  If it was cut or changed, the
   import ends here, and nothing was written.
2. It is merged in one transaction, in the first of these ways that fits:
   - the registry has no authority, or nothing in it but its own first entry: it becomes a copy of the export, with the
     export's authority and signatures.  Without the private key it can be read, and no more.
   - the export's log is a part of the registry's: there is nothing to do.
   - the registry's log is a part of the export's: the entries that follow and their records are taken as signed.
   - both have grown on their own under one key: records that differ are united and signed anew, with an entry
     `import` for each.  A revocation stays, the earlier if there are two; so does a suspension, because it is unknown
     whether it came after a reinstatement; of two days the earlier stays, and of measured figures the
     newer, next to which all others of both stay on record.
A person who was erased on either side is erased on both afterwards.
"""

from __future__ import annotations

import json
import tempfile
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sqlalchemy import Column, ColumnElement, Connection, Table, delete, func, insert, select
from sqlalchemy.engine import URL

from moireid.errors import RegistryError
from moireid.names import hidden_words
from moireid.registry import schema
from moireid.registry.audit import audit
from moireid.registry.batch import same_or_conflict
from moireid.registry.canonical import canonical_json
from moireid.registry.engine import chunks, clean
from moireid.registry.erased import erased_among
from moireid.registry.export_file import load
from moireid.registry.keys import account
from moireid.registry.ledger import Ledger, Transaction, open_ledger
from moireid.registry.log import ERASE, NO_RECORD
from moireid.registry.log_tree import grow
from moireid.registry.merkle import Tree
from moireid.registry.record import REVOKED, SUSPENDED, Fault, Record
from moireid.registry.schema import actors, badges, log, pages, select_records


@dataclass(frozen=True)
class Import:
    """The result of an import.

    Attributes
    ----------
    added : int
        Records that are new here.
    changed : int
        Records that were here and are changed.
    unchanged : int
        Records that were here already, without a difference.
    erased : int
        Records that were here, of people who were erased meanwhile.
    notes : tuple of str
        If records were added: names that look like others here, or hold invisible letters; and that this state is
        older than one that was seen, so that every reader refuses it.
    """

    added: int
    changed: int
    unchanged: int
    erased: int = 0
    notes: tuple[str, ...] = ()


@contextmanager
def checked_copy(path: Path) -> Iterator[Ledger]:
    """A registry that holds what the export at `path` does, and is sound; it is gone afterwards.

    Raises: RegistryError if the file cannot be read, is no export, or its content is not sound.
    """
    with tempfile.TemporaryDirectory(prefix="moireid-import-", ignore_cleanup_errors=True) as folder:
        url = URL.create("sqlite", database=str(Path(folder) / "export.sqlite3"))
        # What others exported is compared with what was seen when it is merged.
        copy = open_ledger(url, create=True, make_authority=False, actor=account()).unchecked()
        try:
            load(path, copy)
            seen = audit(copy, None)
            if not seen.sound:
                more = f", and {seen.found - 1} more" if seen.found > 1 else ""
                raise RegistryError(
                    f"export {path} was tampered with or is damaged ({seen.findings[0].text}{more}); nothing was "
                    "imported, so get another copy",
                    code=seen.findings[0].code,
                )
            yield copy
        finally:
            copy.engine.dispose()


def merge(source: Ledger, target: Ledger, actor: str) -> Import:
    """Take all that `source`, which is sound, holds into `target`, in one transaction; `actor` does it."""
    done = _merged(source, target, actor)
    if done.erased:
        clean(target.engine)
    return replace(done, notes=(*_refused(target), *notes_on(target.unchecked()))) if done.added else done


def _refused(target: Ledger) -> list[str]:
    """The sentence by which each reader refuses a registry that took in an older state than was seen; else nothing."""
    try:
        target.standing()
    except RegistryError as error:
        return [str(error)]
    return []


def _merged(source: Ledger, target: Ledger, actor: str) -> Import:
    with source.snapshot() as there:
        if not target.has_authority or target.authority.public_hex != source.authority.public_hex:
            former = [one.old.public_hex for one in source.rotations()]
            if target.has_authority and target.authority.public_hex in former:
                return _follow(there, source, target, actor)
            return _adopt(there, source, target)
        with target.writing(actor, older=True) as transaction:
            theirs, ours = source.tree_in(there), transaction.tree
            if ours.consistency(theirs.size, theirs.root) is not None:
                return Import(0, 0, _count(there))
            if theirs.consistency(ours.size, ours.root) is not None:
                return _catch_up(there, transaction, resigned=False)
            return _unite(there, source, transaction)


def _adopt(there: Connection, source: Ledger, target: Ledger) -> Import:
    """Make `target`, which must be empty, a copy."""
    with target.clearing(source.authority) as here:
        _copy_log(there, here)
        grow(here, Tree())
        added = _copy(there, here, badges, badges.c.id)
    return Import(added, 0, 0)


def _follow(there: Connection, source: Ledger, target: Ledger, actor: str) -> Import:
    """Take in the later entries of an authority that has changed its key and so has signed all records anew."""
    with target.writing(actor, older=True) as transaction:
        ours = transaction.tree
        if source.tree_in(there).consistency(ours.size, ours.root) is None:
            raise RegistryError(
                f"registry {target.shown} holds log entries that this export lacks, and its authority has changed its "
                "key since; import the export into an empty registry, and enter what is missing there"
            )
        done = _catch_up(there, transaction, resigned=True)
        transaction.successor = source.authority.public_hex
    return done


def _catch_up(there: Connection, transaction: Transaction, *, resigned: bool) -> Import:
    """Copy the source's later log entries, and the records that they are about; all records if `resigned`."""
    here, tree = transaction.connection, transaction.growing()
    newer = log.c.seq > tree.size
    said, gone, before = set(there.scalars(select(log.c.subject).where(newer))), set(_erased_in(there)), _count(here)
    # A registry may hold millions of badges; of these, only what the later entries are about is looked at.
    known = {found for ids in chunks(sorted(said | gone)) for found in _held(here, ids)}
    erased, changed = known & gone, known & said - gone
    if resigned:
        here.execute(delete(badges))
    for ids in chunks(sorted(changed | erased)):
        here.execute(delete(badges).where(badges.c.id.in_(ids)))
    _copy(there, here, badges, badges.c.id, None if resigned else badges.c.id.in_(select(log.c.subject).where(newer)))
    _copy_log(there, here, newer)
    grow(here, tree)
    kept = before - len(erased)
    return Import(_count(there) - kept, len(changed), kept - len(changed), len(erased))


def _held(here: Connection, ids: Iterable[str]) -> list[str]:
    """Those of some ids of which there is a record here."""
    return list(here.scalars(select(badges.c.id).where(badges.c.id.in_(ids))))


def _unite(there: Connection, source: Ledger, transaction: Transaction) -> Import:
    """Enter the source's records that we lack, and unite those that both hold and that differ."""
    added = changed = unchanged = erased = 0
    # What is changed is signed anew, so it must be the newest version, whatever the database's index shows.
    versions = transaction.tree.versions()
    for badge_id in _erased_in(there):
        if transaction.connection.execute(delete(badges).where(badges.c.id == badge_id)).rowcount:
            transaction.log(ERASE, badge_id)
            erased += 1
    for rows in chunks(pages(there, select_records(), badges.c.id)):
        ids = [row.id for row in rows]
        held = {record.id: record for record in transaction.records(select_records().where(badges.c.id.in_(ids)))}
        new, gone = [], set(erased_among(transaction.connection, ids))
        gone |= {one for one in ids if versions.get(one) == NO_RECORD}
        for theirs in map(source.record, (row for row in rows if row.id not in gone)):
            ours = held.get(theirs.id)
            united = None if ours is None else _united(ours, theirs)
            if united is None:
                new.append(theirs)
            elif united == ours:
                unchanged += 1
            else:
                if ours is not None and versions.get(ours.id) != ours.digest():
                    raise Fault("record_stale", f"the record of id {ours.id} is not the version that the log has last")
                transaction.change(united, "import")
                changed += 1
        transaction.enter(new, "import")
        added += len(new)
    return Import(added, changed, unchanged, erased)


def _erased_in(there: Connection) -> list[str]:
    """The ids of badges whose holders were erased in the source."""
    return list(there.scalars(select(log.c.subject).where(log.c.action == ERASE).distinct()))


def _united(ours: Record, theirs: Record) -> Record:
    """One record of two of the same badge: the same whichever is ours, and again the same when united again.

    Raises: RegistryError if they hold one id for different badges.
    """
    if ours == theirs:
        return ours
    same_or_conflict(replace(theirs, expires=None), ours)
    # Between equal ones the text decides, so that every registry that unites them gets the same record.
    first, second = sorted((ours, theirs), key=_order)
    revoked, suspended = _first_of(REVOKED, first, second), _first_of(SUSPENDED, first, second)
    sets = _all_figures(first, second)
    return replace(
        first.with_figure_sets(sets) if sets else first,
        salt=first.salt or second.salt,
        compromised_since=_earlier(first.compromised_since, second.compromised_since),
        expires=_earlier(first.expires, second.expires),
        **revoked,
        **suspended,
    )


def _all_figures(*records: Record) -> list[dict[str, Any]]:
    """All sets of measured figures of some records, the newest last."""
    sets: Counter[tuple[str, str]] = Counter()
    for record in records:
        # What both have is had once, and what one of them has twice, twice.
        sets |= Counter((one["as_built_at"] or "", canonical_json(one)) for one in record.figure_sets)
    return [json.loads(text) for _, text in sorted(sets.elements())]


def _first_of(names: tuple[str, str], *records: Record) -> dict[str, Any]:
    """Day and reason of what was done to one of these records first, as fields; None of both if it was done to none."""
    done = [(getattr(one, names[0]), getattr(one, names[1])) for one in records if getattr(one, names[0]) is not None]
    return dict(zip(names, min(done, key=lambda pair: (pair[0], pair[1] or ""), default=(None, None)), strict=True))


def _earlier(one: str | None, other: str | None) -> str | None:
    return min((day for day in (one, other) if day is not None), default=None)


def _order(record: Record) -> tuple[str, str, str]:
    return record.issued_at, record.badge_json, record.salt or ""


def _copy(
    there: Connection, here: Connection, table: Table, key: Column[Any], condition: ColumnElement[bool] | None = None
) -> int:
    """Copy the rows of a table, or those of a condition, as they are; returns how many."""
    query = select(table) if condition is None else select(table).where(condition)
    copied = 0
    for rows in chunks(pages(there, query, key)):
        here.execute(insert(table), [dict(row._mapping) for row in rows])
        copied += len(rows)
    return copied


def _copy_log(there: Connection, here: Connection, newer: ColumnElement[bool] | None = None) -> None:
    """Copy the log's entries, or the newer ones; actors and head take the place of those that are here."""
    _copy(there, here, log, log.c.seq, newer)
    for table, key in ((actors, actors.c.commitment), (schema.authority, schema.authority.c.one)):
        here.execute(delete(table))
        _copy(there, here, table, key)


def _count(connection: Connection) -> int:
    return connection.scalar(select(func.count()).select_from(badges)) or 0


#: At most this many groups of names of each kind are reported, with at most this many names each.
MOST_NAMES = 20


def notes_on(ledger: Ledger) -> tuple[str, ...]:
    """A sentence for each group of names in the registry that look alike, and for each name with hidden letters.

    An import accepts such names: an older registry may hold them, and a backup must be restored whole.
    """
    found = []
    for look in (badges.c.skeleton, badges.c.folded):
        several = select(look).group_by(look).having(func.count(badges.c.name_nfc.distinct()) > 1).limit(MOST_NAMES)
        for row in ledger.rows(several):
            names = ledger.rows(select(badges.c.name_nfc).where(look == row[0]).distinct().limit(MOST_NAMES))
            listed = " and ".join(repr(one) for one in sorted(name for (name,) in names))
            found.append(f"the names {listed} look alike, and are of different people")
    for (name,) in ledger.rows(select(badges.c.name_nfc).where(badges.c.name_nfc.is_not(None))):
        if not name.isascii() and (words := hidden_words(unicodedata.normalize("NFC", name))):
            found.append(f"the name {name!r} {words}")
    return tuple(dict.fromkeys(found))
