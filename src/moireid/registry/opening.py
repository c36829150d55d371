"""Opening a registry: its tables are made if they are absent, and checked."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Connection, Engine, insert, inspect, select
from sqlalchemy.exc import IntegrityError, ProgrammingError
from sqlalchemy.types import TypeEngine

from moireid.errors import RegistryError
from moireid.registry import schema
from moireid.registry.engine import writing
from moireid.registry.keys import new_key
from moireid.registry.log import first_rows

TABLES = set(schema.metadata.tables)


def prepare(engine: Engine, shown: str, *, create: bool, make_authority: bool, actor: str) -> tuple[str | None, bool]:
    """Make the tables if there are none and `create` is true, and check them.

    Returns: the authority's public key, and whether the authority was made here.

    A registry without an authority gets one, with a new key pair, if `create` and `make_authority` are true.  Else
    None is returned for it if `create` is true: it waits for an import.  `shown` names the registry in messages,
    `actor` is who makes it.
    Raises: RegistryError if the database holds nothing, another program's tables, others than moireid made, or another
        version of ours.
    """
    made = False
    if create:
        with engine.connect() as connection:
            names, public_key = look(connection)
        if not names or (public_key is None and make_authority and names >= TABLES):
            made = _create(engine, actor, make_authority=make_authority)
    with engine.connect() as connection:
        names, public_key = look(connection)
        if {schema.schema_version.name, schema.badges.name} <= names:
            _check_version(connection, shown)
            check_tables(connection, shown)
        elif names:
            raise RegistryError(
                f"registry {shown} is a database, but not one of moireid's; give another URL, or an empty database"
            )
    if not names or (public_key is None and not create):
        raise RegistryError(f"registry {shown} is empty; enroll someone first, or run `moireid registry init`")
    return public_key, made


def look(connection: Connection) -> tuple[set[str], str | None]:
    """The names of all tables, and the authority's public key if there is one."""
    names = set(inspect(connection).get_table_names())
    if not names >= TABLES:
        return names, None
    return names, connection.scalar(select(schema.authority.c.public_key))


def check_tables(connection: Connection, shown: str) -> None:
    """Raise RegistryError unless each table is there, with each of its columns, of its type.

    Only who writes to the database otherwise than by moireid makes it so.  It costs a millisecond, and lets all other
    code rely on the types.  A table or a column more is the operator's own.
    """
    found = {name: columns for (_, name), columns in inspect(connection).get_multi_columns().items()}
    for name in sorted(TABLES):
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


def _check_version(connection: Connection, shown: str) -> None:
    """Raise RegistryError unless the one version there is ours."""
    found = list(connection.scalars(select(schema.schema_version.c.version)))
    if found == [schema.SCHEMA_VERSION]:
        return
    raise RegistryError(
        f"registry {shown} has schema version {', '.join(map(str, found)) or 'none'}, and this moireid reads version "
        f"{schema.SCHEMA_VERSION}; open it with the moireid that wrote it, or a newer one",
        found=found,
        supported=schema.SCHEMA_VERSION,
    )


def _create(engine: Engine, actor: str, *, make_authority: bool) -> bool:
    """Make the tables, their version and the authority in one transaction, unless another process was faster.

    Returns: whether it made the authority.
    """
    # The key is on the disk before the registry says that it is the authority's.
    signer, path = new_key() if make_authority else (None, None)
    used = False
    try:
        with writing(engine) as connection:
            # Another process may have made them while this one waited for the write lock.
            names, public_key = look(connection)
            if not names:
                schema.metadata.create_all(connection)
                connection.execute(insert(schema.schema_version).values(version=schema.SCHEMA_VERSION))
            if signer is not None and public_key is None:
                head_row, entry = first_rows(signer, actor)
                connection.execute(insert(schema.authority).values(head_row))
                connection.execute(insert(schema.log).values(entry))
                used = True
    except (IntegrityError, ProgrammingError):
        # Databases without a single write lock, such as PostgreSQL, refuse the second of two makers here.  If the
        # other one has succeeded, nothing is left to do; otherwise this error is reported.
        used = False
        with engine.connect() as connection:
            names, public_key = look(connection)
        if not names >= TABLES or (make_authority and public_key is None):
            raise
    finally:
        if path is not None and not used:
            path.unlink(missing_ok=True)
    return used
