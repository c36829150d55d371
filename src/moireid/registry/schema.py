"""The tables, their version, and the look at them on opening.

`badges` holds one row for each issued badge.  `badge_json` is the badge; the other columns are copies of what is
searched for, made on enrolment.  A later version may add tables, and then raises `SCHEMA_VERSION`; so must one that
changes what `Badge.layout_key` hashes, because the keys of old rows would no longer compare.
"""

from __future__ import annotations

from sqlalchemy import Column, Connection, Engine, Index, Integer, MetaData, Table, Text, insert, inspect, select
from sqlalchemy.exc import IntegrityError, ProgrammingError

from moireid.errors import RegistryError
from moireid.registry.engine import writing

SCHEMA_VERSION = 1

metadata = MetaData()

badges = Table(
    "badges",
    metadata,
    Column("id", Text, primary_key=True),
    Column("name_nfc", Text, nullable=False),
    Column("layout_key", Text, nullable=False),
    Column("badge_json", Text, nullable=False),
    Column("issued_at", Text, nullable=False),
)
# With the id behind them these indexes also serve the ordered list and the first id of each layout.
Index("badges_by_name", badges.c.name_nfc, badges.c.id)
Index("badges_by_layout", badges.c.layout_key, badges.c.id)

schema_version = Table("schema_version", metadata, Column("version", Integer, primary_key=True, autoincrement=False))


def prepare(engine: Engine, shown: str, *, create: bool) -> None:
    """Make the tables where there are none and `create` is true, then hold them against `SCHEMA_VERSION`.

    `shown` names the registry in messages.
    Raises: RegistryError where the database holds nothing, another program's tables, or another version of ours.
    """
    with engine.connect() as connection:
        names = _table_names(connection)
    if not names and create:
        names = _create(engine)
    if not names:
        raise RegistryError(f"registry {shown} is empty; enroll someone first, or run `moireid registry init`")
    if not set(metadata.tables) <= names:
        raise RegistryError(
            f"registry {shown} is a database, but not one of moireid's; give another URL, or an empty database"
        )
    with engine.connect() as connection:
        found = list(connection.scalars(select(schema_version.c.version)))
    if found != [SCHEMA_VERSION]:
        version = ", ".join(map(str, found)) or "none"
        raise RegistryError(
            f"registry {shown} has schema version {version}, and this moireid reads version {SCHEMA_VERSION}; "
            "open it with the moireid that wrote it, or a newer one",
            found=found,
            supported=SCHEMA_VERSION,
        )


def _create(engine: Engine) -> set[str]:
    """Make the tables and their version in one transaction; returns the names of the tables there are then."""
    try:
        with writing(engine) as connection:
            # Another process may have made them while this one waited for the write lock.
            if not _table_names(connection):
                metadata.create_all(connection)
                connection.execute(insert(schema_version).values(version=SCHEMA_VERSION))
    except (IntegrityError, ProgrammingError):
        # Databases without one write lock for all, as PostgreSQL, refuse the second of two makers here.  Where the
        # other one has succeeded there is nothing left to do; else this one's error is the one to tell.
        with engine.connect() as connection:
            if not set(metadata.tables) <= _table_names(connection):
                raise
    with engine.connect() as connection:
        return _table_names(connection)


def _table_names(connection: Connection) -> set[str]:
    return set(inspect(connection).get_table_names())
