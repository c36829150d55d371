"""Erasing a person or an actor on their request: the data are deleted, the chain stays, and a log entry says so.

For a person, the row is deleted: name, badge, reason of a revocation, measured figures, and the salt.  The log keeps
the badge's identity, which is a random number, and hashes against which no one can test names without that salt.  The
signed entry `erase` stays as a marker.  The identity is never issued again.

Records of schema version 2 had no salt.  A person who has the log and such an identity can still test a name against
the hashes in its old entries, which cannot change without breaking every checkpoint.  `ErasureResult.guessable` says
so.

The data are also removed from the disk, because a database keeps old rows in unused pages.  SQLite overwrites what it
deletes (`secure_delete`, set in engine.py), and VACUUM writes the file anew without what older versions left in it.
PostgreSQL writes the tables anew, and its statistics, which hold values of columns.  Not removed: copies and backups,
PostgreSQL's write-ahead log until it is recycled, and blocks that a disk keeps by itself.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Engine, delete, func, select
from sqlalchemy.exc import SQLAlchemyError

from moireid.errors import RegistryError
from moireid.registry.canonical import utc_now
from moireid.registry.claims import as_id, find_row
from moireid.registry.keys import Authority
from moireid.registry.ledger import Ledger
from moireid.registry.log import ERASE, ERASE_ACTOR, check_signed
from moireid.registry.record import Fault, storable, tampered
from moireid.registry.schema import actors, badges, log, select_records

#: The tables that hold names.
NAMING = ("badges", "actors")


def clean(engine: Engine) -> bool:
    """Write the tables with names anew; returns whether it worked: not if others use the database, or it is full."""
    try:
        if engine.dialect.name == "sqlite":
            # Not by SQLAlchemy's connection: it begins a transaction, in which SQLite refuses this.
            with closing(engine.raw_connection()) as raw:
                assert raw.driver_connection is not None
                raw.driver_connection.execute("VACUUM")
            return True
        if engine.dialect.name == "postgresql":
            with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
                for table in NAMING:
                    connection.exec_driver_sql(f"VACUUM (FULL, ANALYZE) {table}")
            return True
    except (sqlite3.Error, SQLAlchemyError):
        return False
    return False


@dataclass(frozen=True)
class ErasureResult:
    """The result of an erasure.

    Attributes
    ----------
    subject : str
        The badge's id, or an actor's commitment.
    erased_at : str
        UTC, ISO 8601 to the second.
    again : bool
        Whether it was erased before; then only the database was cleaned.
    cleaned : bool
        Whether the database was written anew, so that no page of it holds what was erased.
    guessable : bool
        Whether entries of an older version remain by which a guessed name can be confirmed.
    """

    subject: str
    erased_at: str
    again: bool
    cleaned: bool
    guessable: bool

    def to_json(self) -> dict[str, Any]:
        """Make the JSON object that ``moireid registry erase --json`` prints.

        Returns
        -------
        dict
            An object that JSON can hold.
        """
        return dict(vars(self))


def erase_person(ledger: Ledger, claim: str, actor: str) -> ErasureResult:
    """What `Registry.erase` does."""
    before = erased_at(ledger, claim)
    if before is not None:
        return ErasureResult(as_id(claim), before, True, clean(ledger.engine), _guessable(ledger, as_id(claim)))
    record = ledger.record(find_row(claim, ledger.rows, ledger.shown))
    with ledger.writing(actor) as transaction:
        if not transaction.records(select_records().where(badges.c.id == record.id)):
            raise RegistryError(f"badge {record.id} was taken out of registry {ledger.shown} meanwhile")
        transaction.connection.execute(delete(badges).where(badges.c.id == record.id))
        transaction.log(ERASE, record.id)
    return ErasureResult(record.id, utc_now(), False, clean(ledger.engine), _guessable(ledger, record.id))


def erase_actor(ledger: Ledger, name: str, actor: str) -> ErasureResult:
    """What `Registry.erase_actor` does."""
    with ledger.writing(actor) as transaction:
        who = transaction.connection.scalar(select(actors.c.commitment).where(actors.c.name == name))
        if who is None:
            raise RegistryError(
                f"no one named {name[:80]!r} has done anything in registry {ledger.shown}; see who has with "
                "`moireid registry log`"
            )
        if name == actor:
            raise RegistryError(
                f"{name!r} would erase themself, and the entry of that would name them again; let somebody else do it "
                "(--actor)"
            )
        transaction.connection.execute(delete(actors).where(actors.c.commitment == who))
        transaction.log(ERASE_ACTOR, who)
    return ErasureResult(who, utc_now(), False, clean(ledger.engine), False)


def erased_at(ledger: Ledger, badge_id: str) -> str | None:
    """When the holder of a badge was erased; None if the holder was not erased.

    Raises: RegistryError if the entry that says so is not as the authority signed it.
    """
    if not storable(badge_id):
        return None
    rows = ledger.rows(select(log).where(log.c.subject == as_id(badge_id)).order_by(log.c.seq.desc()).limit(1))
    if not rows or rows[0].action != ERASE:
        return None
    try:
        check_signed(dict(rows[0]._mapping), _authority_at(ledger, rows[0].seq))
    except Fault as fault:
        raise tampered(ledger.shown, fault) from fault
    return str(rows[0].time)


def _authority_at(ledger: Ledger, seq: int) -> Authority:
    """The authority whose key signed a log entry: the old key of the next change of key after it."""
    return next((one.old for one in ledger.rotations() if one.seq > seq), ledger.authority)


def _guessable(ledger: Ledger, badge_id: str) -> bool:
    """Whether the log has entries of a record without a salt."""
    old = select(func.count()).select_from(log).where(log.c.subject == badge_id, log.c.actor.is_(None))
    return bool(ledger.rows(old)[0][0])
