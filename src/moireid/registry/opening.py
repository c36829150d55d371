"""Opening a registry: its tables are made if they are absent, migrated from an older schema version, and checked.

A migration runs in one transaction: all of it or nothing.  A step changes tables and derived columns.  It touches no
signed text, no entry and no signature, so it needs no key, and checkpoints from before stay valid.  A record whose
signed text would be different in this version stays as it is until it changes.  The last step is taken by the first
write, which signs the tree's root: until then a registry of the version before can be read where it cannot be written.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sqlalchemy import Column, Connection, Engine, Table, bindparam, delete, insert, inspect, select, text, update
from sqlalchemy.exc import IntegrityError, ProgrammingError, SQLAlchemyError
from sqlalchemy.schema import CreateColumn
from sqlalchemy.types import TypeEngine

from moireid.errors import RegistryError
from moireid.registry import schema
from moireid.registry.engine import writing
from moireid.registry.keys import actor_row
from moireid.registry.log import first_rows
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.signing.client import make_key

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


def _to_5(connection: Connection) -> None:
    """Why measured figures took the place of others, and those others."""
    for column in (schema.badges.c.as_built_reason, schema.badges.c.as_built_earlier):
        _add(connection, column)


def add_nodes(connection: Connection) -> None:
    """The table of the tree's nodes, empty; the caller fills it."""
    schema.nodes.create(connection, checkfirst=True)
    connection.execute(delete(schema.nodes))
    connection.execute(update(schema.schema_version).values(version=schema.SCHEMA_VERSION))


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


#: The tables without which a registry cannot be read.
NEEDED = set(schema.metadata.tables) - {schema.nodes.name}
#: The step that leads on from a version.
STEPS: dict[int, Callable[[Connection], None]] = {2: _to_3, 3: _to_4, 4: _to_5}


def prepare(engine: Engine, shown: str, *, create: bool, make_authority: bool, actor: str) -> tuple[str | None, bool]:
    """Make the tables if there are none and `create` is true, and check them.

    Returns: the authority's public key, and whether the authority was made here.

    A registry without an authority gets one, with a new key pair, if `create` and `make_authority` are true.  Else
    None is returned for it if `create` is true: it waits for an import.  `shown` names the registry in messages,
    `actor` is who makes it.  A registry of an older version that has its step is brought to this one.
    Raises: RegistryError if the database holds nothing, another program's tables, others than moireid made, or another
        version of ours.
    """
    with engine.connect() as connection:
        names, public_key = look(connection)
    made = False
    if create and (not names or (public_key is None and make_authority and names >= NEEDED)):
        made = _create(engine, actor, make_authority=make_authority)
        with engine.connect() as connection:
            names, public_key = look(connection)
    if not names:
        raise _empty(shown)
    if {schema.schema_version.name, schema.badges.name} <= names:
        _bring_up(engine, shown)
        with engine.connect() as connection:
            names, public_key = look(connection)
            check_tables(connection, shown)
    if not names >= NEEDED:
        raise RegistryError(
            f"registry {shown} is a database, but not one of moireid's; give another URL, or an empty database"
        )
    if public_key is None and not create:
        raise _empty(shown)
    return public_key, made


def _bring_up(engine: Engine, shown: str) -> None:
    """Check the version, and bring an older one to ours.  Raises: RegistryError if it is none of those."""
    with engine.connect() as connection:
        found = list(connection.scalars(select(schema.schema_version.c.version)))
    if len(found) != 1 or found[0] not in STEPS:
        _check_version(found, shown)
        return
    try:
        migrate(engine)
    except SQLAlchemyError as error:
        reason = str(getattr(error, "orig", None) or error).strip().split("\n")[0]
        raise RegistryError(
            f"registry {shown} is of schema version {found[0]} and must be brought to {schema.CHAINED_VERSION} once, "
            f"which failed ({reason}); open it with any command where it may be written and no one else writes",
            found=found,
            supported=schema.SCHEMA_VERSION,
        ) from error


def _empty(shown: str) -> RegistryError:
    return RegistryError(f"registry {shown} is empty; enroll someone first, or run `moireid registry init`")


def look(connection: Connection) -> tuple[set[str], str | None]:
    """The names of all tables, and the authority's public key if there is one."""
    names = set(inspect(connection).get_table_names())
    if not names >= NEEDED:
        return names, None
    return names, connection.scalar(select(schema.authority.c.public_key))


def check_tables(connection: Connection, shown: str) -> None:
    """Raise RegistryError unless each table is there, with each of its columns, of its type.

    Only who writes to the database otherwise than by moireid makes it so.  It costs a millisecond, and lets all other
    code rely on the types.  A table or a column more is the operator's own.
    """
    found = {name: columns for (_, name), columns in inspect(connection).get_multi_columns().items()}
    chained = schema.schema_version.name in found and list(
        connection.scalars(select(schema.schema_version.c.version))
    ) == [schema.CHAINED_VERSION]
    for name in sorted(NEEDED if chained else schema.metadata.tables):
        types = {column["name"]: _type(column["type"], connection) for column in found.get(name, ())}
        for column in schema.metadata.tables[name].columns:
            if (wanted := _type(column.type, connection)) != types.get(column.name):
                is_now = f"is of type {types[column.name]}, not {wanted}" if column.name in types else "is missing"
                what = f"column {name}.{column.name} {is_now}" if types else f"there is no table {name}"
                raise RegistryError(
                    f"registry {shown} has tables that are not those that moireid made ({what}); restore it from a "
                    "copy, or give another URL",
                    code="tables",
                )


def _type(kind: TypeEngine[Any], connection: Connection) -> str:
    """A column's type as this database writes it, without its collation."""
    return kind.compile(connection.dialect).split(" ")[0]


def _check_version(found: list[int], shown: str) -> None:
    """Raise unless the one version found is ours."""
    if found in ([schema.SCHEMA_VERSION], [schema.CHAINED_VERSION]):
        return
    version = ", ".join(map(str, found)) or "none"
    if found == [1]:
        remedy = "its records bear no signatures, so enroll the badges anew in another registry"
    else:
        remedy = "open it with the moireid that wrote it, or a newer one"
    raise RegistryError(
        f"registry {shown} has schema version {version}, and this moireid reads version {schema.SCHEMA_VERSION}; "
        f"{remedy}",
        found=found,
        supported=schema.SCHEMA_VERSION,
    )


def _create(engine: Engine, actor: str, *, make_authority: bool) -> bool:
    """Make the tables, their version and the authority in one transaction, unless another process was faster.

    Returns: whether it made the authority.
    """
    # The key is on the disk before the registry says that it is the authority's.
    signer, path = make_key() if make_authority else (None, None)
    used = False
    try:
        with writing(engine) as connection:
            # Another process may have made them while this one waited for the write lock.
            names, public_key = look(connection)
            if not names:
                schema.metadata.create_all(connection)
                connection.execute(insert(schema.schema_version).values(version=schema.SCHEMA_VERSION))
            if signer is not None and public_key is None:
                row = actor_row(actor)
                head_row, entry = first_rows(signer, row["commitment"])
                connection.execute(insert(schema.actors).values(row))
                connection.execute(insert(schema.authority).values(head_row))
                connection.execute(insert(schema.log).values(entry))
                used = True
    except (IntegrityError, ProgrammingError):
        # Databases without a single write lock, such as PostgreSQL, refuse the second of two makers here.  If the
        # other one has succeeded, nothing is left to do; otherwise this error is reported.
        used = False
        with engine.connect() as connection:
            names, public_key = look(connection)
        if not names >= NEEDED or (make_authority and public_key is None):
            raise
    finally:
        if path is not None and not used:
            path.unlink(missing_ok=True)
    return used
