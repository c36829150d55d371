"""Import of an export: all of it or nothing.

1. The file is read into its own registry in a temporary folder, and audited there.  If it was cut or changed, the
   import ends here, and nothing was written.
2. It is merged in one transaction, in the first of these ways that fits:
   - the registry has no authority, or nothing in it but its own first entry: it becomes a copy of the export, with the
     export's authority and signatures.  Without the private key it can be read, and no more.
   - the export's log is a part of the registry's: there is nothing to do.
   - the registry's log is a part of the export's: the entries that follow and their records are taken as signed; all
     records, if the authority has changed its key since.
   Else both have grown on their own, and one of them is a fork: nothing is imported.
A person who was erased in the export is erased in the registry afterwards.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import Column, ColumnElement, Connection, Table, delete, func, insert, select
from sqlalchemy.engine import URL

from moireid.errors import RegistryError
from moireid.registry import schema
from moireid.registry.audit import audit
from moireid.registry.engine import chunks, clean
from moireid.registry.export_file import load
from moireid.registry.keys import account
from moireid.registry.ledger import Ledger, Transaction, open_ledger
from moireid.registry.log import ERASE
from moireid.registry.schema import actors, badges, log, pages


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
    """

    added: int
    changed: int
    unchanged: int
    erased: int = 0


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
            seen = audit(copy)
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
    return done


def _merged(source: Ledger, target: Ledger, actor: str) -> Import:
    with source.snapshot() as there:
        own = target.authority.public_hex if target.has_authority else None
        if own not in (source.authority.public_hex, *(one.old.public_hex for one in source.rotations())):
            return _adopt(there, source, target)
        with target.writing(actor, older=True) as transaction:
            theirs, ours = source.tree_in(there), transaction.tree
            if ours.consistency(theirs.size, theirs.root) is not None:
                return Import(0, 0, _count(there))
            if theirs.consistency(ours.size, ours.root) is None:
                raise RegistryError(
                    f"registry {target.shown} holds log entries that this export lacks, and lacks others of it: one of "
                    "the two is a fork; import the export into an empty registry, and enroll and revoke there what is "
                    "missing",
                    code="forked",
                )
            resigned = own != source.authority.public_hex
            done = _catch_up(there, transaction, resigned=resigned)
            if resigned:
                transaction.successor = source.authority.public_hex
            return done


def _adopt(there: Connection, source: Ledger, target: Ledger) -> Import:
    """Make `target`, which must be empty, a copy."""
    with target.clearing(source.authority) as here:
        _copy_log(there, here)
        added = _copy(there, here, badges, badges.c.id)
    return Import(added, 0, 0)


def _catch_up(there: Connection, transaction: Transaction, *, resigned: bool) -> Import:
    """Copy the source's later log entries, and the records that they are about; all records if `resigned`."""
    here, newer = transaction.connection, log.c.seq > transaction.tree.size
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
    kept = before - len(erased)
    return Import(_count(there) - kept, len(changed), kept - len(changed), len(erased))


def _held(here: Connection, ids: Iterable[str]) -> list[str]:
    """Those of some ids of which there is a record here."""
    return list(here.scalars(select(badges.c.id).where(badges.c.id.in_(ids))))


def _erased_in(there: Connection) -> list[str]:
    """The ids of badges whose holders were erased in the source."""
    return list(there.scalars(select(log.c.subject).where(log.c.action == ERASE).distinct()))


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
