"""Opening a registry: its tables are made if they are absent, and checked."""

from __future__ import annotations

from collections.abc import Callable

from sqlalchemy import Connection, Engine, insert, inspect, select
from sqlalchemy.exc import IntegrityError, ProgrammingError

from moireid.errors import RegistryError
from moireid.registry import schema
from moireid.registry.engine import writing
from moireid.registry.keys import new_key
from moireid.registry.log import first_rows

TABLES = set(schema.metadata.tables)
#: Makes and fills the tables of an empty database; returns whether it did, or another process was faster.
Make = Callable[[Engine], bool]


def prepare(engine: Engine, shown: str, make: Make | None) -> tuple[str | None, bool]:
    """Make the tables if there are none, and check them; `shown` names the registry in messages.

    Returns: the authority's public key, and whether they were made here.
    Raises: RegistryError if the database holds nothing, another program's tables, others than moireid made, or another
        version of ours.
    """
    made = make is not None and not _tables(engine) and make(engine)
    with engine.connect() as connection:
        names = _tables(connection)
        if not names:
            raise RegistryError(f"registry {shown} is empty; enroll someone first, or run `moireid registry init`")
        if not {schema.schema_version.name, schema.badges.name} <= names:
            raise RegistryError(
                f"registry {shown} is a database, but not one of moireid's; give another URL, or an empty database"
            )
        _check_version(connection, shown)
        if missing := TABLES - names:
            raise RegistryError(
                f"registry {shown} has tables that are not those that moireid made (there is no table "
                f"{min(missing)}); restore it from a copy, or give another URL",
                code="tables",
            )
        return connection.scalar(select(schema.authority.c.public_key)), made


def _tables(database: Engine | Connection) -> set[str]:
    return set(inspect(database).get_table_names())


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


def new_authority(actor: str, engine: Engine) -> bool:
    """Make a registry with a key pair of its own; actor: who does, as its log is to name them."""
    # The key is on the disk before the registry says that it is the authority's.
    signer, path = new_key()
    head, entry = first_rows(signer, actor)

    def fill(connection: Connection) -> None:
        connection.execute(insert(schema.authority).values(head))
        connection.execute(insert(schema.log).values(entry))

    made = False
    try:
        made = make_tables(engine, fill)
    finally:
        if not made:
            path.unlink(missing_ok=True)
    return made


def make_tables(engine: Engine, fill: Callable[[Connection], object]) -> bool:
    """Make the tables, and fill them, in one transaction, unless another process was faster; returns whether it did."""
    try:
        with writing(engine) as connection:
            # Another process may have made them while this one waited for the write lock.
            if _tables(connection):
                return False
            schema.metadata.create_all(connection)
            connection.execute(insert(schema.schema_version).values(version=schema.SCHEMA_VERSION))
            fill(connection)
        return True
    except (IntegrityError, ProgrammingError):
        # Databases without a single write lock, such as PostgreSQL, refuse the second of two makers here.  If the
        # other one has succeeded, nothing is left to do; otherwise this error is reported.
        if not _tables(engine) >= TABLES:
            raise
        return False
