"""Export to a file, and import of one: all of it or nothing.

An export is a registry in an SQLite file, without the private key; it can be opened as any other.  Before it gets its
name, it is audited.

An import:
1. The file is copied into a new registry in a temporary folder, and audited there.  If it was cut or changed, the
   import ends here, and nothing was written.
2. It is merged in one transaction, in the first of these ways that fits:
   - there is no registry yet: it becomes a copy of the export, with the export's authority and signatures.  Without
     the private key it can be read, and no more.
   - the export's log is a part of the registry's: there is nothing to do.
   - the registry's log is a part of the export's: it becomes a copy, too.
   Else both have grown on their own, and one of them is a fork: nothing is imported.
A person who was erased in the export is erased in the registry afterwards.

Where the authority's key was lost, or is in other hands, `sign_anew` enters the records into an empty registry under
its own key.  Readers must be given its fingerprint: they have no proof that it follows the other one.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from sqlalchemy import Connection, Engine, delete, insert, select
from sqlalchemy.engine import URL

from moireid.errors import RegistryError
from moireid.files import open_regular
from moireid.registry.audit import audit
from moireid.registry.bundle.publish import Progress
from moireid.registry.engine import chunks, clean, translated
from moireid.registry.ledger import Ledger, open_ledger
from moireid.registry.log import ERASE
from moireid.registry.opening import make_tables
from moireid.registry.record import Fault, record_of
from moireid.registry.schema import authority, badges, log, pages, select_records

#: The tables of which a copy is made, and the key of each.
COPIED = ((badges, badges.c.id), (log, log.c.seq), (authority, authority.c.one))


@contextmanager
def checked_copy(path: Path) -> Iterator[Ledger]:
    """A registry that holds what the export at `path` does, and is sound; it is gone afterwards.

    Raises: RegistryError if the file cannot be read, is no export, or its content is not sound.
    """
    with tempfile.TemporaryDirectory(prefix="moireid-import-", ignore_cleanup_errors=True) as folder:
        try:
            open_regular(path).close()
        except OSError as error:
            raise RegistryError(f"export {path} cannot be read ({error.strerror}); give the path of one") from error
        # What others exported is compared with what was seen when it is merged.
        source = open_ledger(_url_of(path), None, checked=False)
        try:
            with audited_copy(source, Path(folder) / "copy.sqlite3") as copy:
                yield copy
        except Fault as fault:
            raise RegistryError(
                f"export {path} was tampered with or is damaged ({fault.text}); nothing was imported, so get another "
                "copy",
                code=fault.code,
            ) from fault
        finally:
            source.engine.dispose()


@contextmanager
def audited_copy(source: Ledger, path: Path, progress: Progress | None = None) -> Iterator[Ledger]:
    """A new registry in an SQLite file, with all that another one holds at this moment.

    Its own tables and indexes are new, so what a hostile database hides by its own is not hidden here.
    Raises: Fault if it is not sound.
    """
    copy = open_ledger(_url_of(path), partial(make_copy, source), checked=False)
    try:
        seen = audit(copy, progress)
        if not seen.sound:
            more = f", and {seen.found - 1} more" if seen.found > 1 else ""
            raise Fault(seen.findings[0].code, f"{seen.findings[0].text}{more}")
        yield copy
    finally:
        copy.engine.dispose()


def _url_of(path: Path) -> URL:
    return URL.create("sqlite", database=str(path.absolute()))


def merge(source: Ledger, target: Ledger, actor: str) -> None:
    """Take all that `source`, which is sound, holds into `target`, in one transaction; `actor` does it."""
    if target.made:
        # As a copy of it.
        return
    with source.snapshot() as there:
        if target.authority.public_hex != source.authority.public_hex:
            raise RegistryError(
                f"registry {target.shown} is of authority {target.authority.fingerprint}, and this export is of "
                f"{source.authority.fingerprint}; import it into an empty registry"
            )
        with target.writing(actor, older=True) as transaction:
            theirs, ours, here = source.tree_in(there), transaction.tree, transaction.connection
            if ours.extends(theirs.head):
                return
            if not theirs.extends(ours.head):
                raise RegistryError(
                    f"registry {target.shown} holds log entries that this export lacks, and lacks others of it: one of "
                    "the two is a fork; import the export into an empty registry, and enroll and revoke there what is "
                    "missing",
                    code="forked",
                )
            for table, _ in COPIED:
                here.execute(delete(table))
            _copy(there, here)
    # Of people who were erased in the export nothing stays.
    clean(target.engine)


def sign_anew(source: Ledger, target: Ledger, actor: str) -> None:
    """Enter all records of `source`, which is sound, into `target`, which is empty, under the key of that one.

    Raises: RegistryError if it is not empty, or its private key is not on this machine.
    """
    with source.snapshot() as there, target.writing(actor) as transaction:
        if transaction.tree.head.seq > 1:
            raise RegistryError(
                f"registry {target.shown} is not empty, and records are signed anew in an empty one alone; give "
                "another URL"
            )
        for rows in chunks(pages(there, select_records(), badges.c.id)):
            transaction.enter([record_of(row, source.authority) for row in rows], "import")
        # Their ids are not issued again here either.
        for erased in there.scalars(select(log.c.subject).where(log.c.action == ERASE)).all():
            transaction.log(ERASE, erased)


def make_copy(source: Ledger, engine: Engine) -> bool:
    """Make a registry of all that another one holds at this moment."""
    with source.snapshot() as there, translated(engine.url):
        return make_tables(engine, partial(_copy, there))


def _copy(there: Connection, here: Connection) -> None:
    """Copy all tables as they are into empty ones."""
    for table, key in COPIED:
        for rows in chunks(pages(there, select(table), key)):
            here.execute(insert(table), [dict(row._mapping) for row in rows])
