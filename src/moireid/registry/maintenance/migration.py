"""From an older schema version to this one, in one transaction: all of it or nothing.

A step changes tables and what is derived.  It touches no signed text, no entry and no signature, so it needs no key,
and checkpoints from before still hold.  A record that would be signed otherwise stays as it is until it changes.
"""

from __future__ import annotations

from collections.abc import Callable

from sqlalchemy import Column, Connection, Engine, Table, bindparam, select, text, update
from sqlalchemy.schema import CreateColumn

from moireid.registry import schema
from moireid.registry.engine import writing
from moireid.registry.look_alikes import folded_skeleton, skeleton

#: Names whose skeletons are written at a time.
CHUNK = 1000


def migrate(engine: Engine) -> None:
    """Take the steps from the version that is found to ours; another process may have taken them meanwhile."""
    with writing(engine) as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(text(f"LOCK TABLE {schema.schema_version.name} IN ACCESS EXCLUSIVE MODE"))
        while step := STEPS.get(version := connection.scalars(select(schema.schema_version.c.version)).one()):
            step(connection)
            connection.execute(update(schema.schema_version).values(version=version + 1))


def _to_3(connection: Connection) -> None:
    """Salts of records, skeletons of names, and who did what."""
    new = schema.badges.c.salt, schema.badges.c.skeleton, schema.badges.c.folded, schema.log.c.actor
    for column in new:
        _add(connection, column)
    schema.actors.create(connection)
    write_skeletons(connection)
    for index in sorted(schema.badges.indexes, key=lambda one: str(one.name)):
        if index.name in ("badges_by_skeleton", "badges_by_folded"):
            index.create(connection)


def _to_4(connection: Connection) -> None:
    """Suspensions, days of expiry, and since when a revoked badge is compromised."""
    badges = schema.badges.c
    for column in (badges.suspended_at, badges.suspended_reason, badges.expires, badges.compromised_since):
        _add(connection, column)


def _add(connection: Connection, column: Column[object]) -> None:
    table = column.table
    assert isinstance(table, Table)
    words = CreateColumn(column).compile(dialect=connection.dialect)
    connection.execute(text(f"ALTER TABLE {table.name} ADD COLUMN {words}"))


def write_skeletons(connection: Connection) -> None:
    """Compute what every name looks like."""
    badges = schema.badges
    known = connection.execute(select(badges.c.id, badges.c.name_nfc)).all()
    change = update(badges).where(badges.c.id == bindparam("of_id"))
    change = change.values(skeleton=bindparam("seen"), folded=bindparam("plain"))
    for begin in range(0, len(known), CHUNK):
        rows = known[begin : begin + CHUNK]
        looks = [{"of_id": r.id, "seen": skeleton(r.name_nfc), "plain": folded_skeleton(r.name_nfc)} for r in rows]
        connection.execute(change, looks)


#: The step that leads on from a version.
STEPS: dict[int, Callable[[Connection], None]] = {2: _to_3, 3: _to_4}
