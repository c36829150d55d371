"""The tables, their version, and their check on opening.

`badges` holds one row for each issued badge: its signed record (record.py).  `log` holds one for each thing done, in a
chain (log.py), and `authority` one row in all: the public key, and the log's head, signed.  A later version may add
tables, and then raises `SCHEMA_VERSION`; so must one that changes what `Badge.layout_key` hashes or what is signed,
because old keys and signatures would no longer compare.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import (
    BigInteger,
    CheckConstraint,
    Column,
    ColumnElement,
    Connection,
    Engine,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    and_,
    func,
    insert,
    inspect,
    literal_column,
    or_,
    select,
)
from sqlalchemy.exc import IntegrityError, ProgrammingError

from moireid.errors import RegistryError
from moireid.registry.engine import AnySelect, writing
from moireid.registry.log import first_rows
from moireid.registry.signing.client import make_key

SCHEMA_VERSION = 2


class Packed(LargeBinary):
    """Bytes as the driver gives them; record.py reports values that are not bytes."""

    cache_ok = True

    def result_processor(self, dialect: Any, coltype: Any) -> None:
        """None: values are not converted."""


# By default PostgreSQL orders text by the rules of a language; SQLite and Python order by code point.
_text = Text().with_variant(Text(collation="C"), "postgresql")
# Only a column of the very type INTEGER is SQLite's own row number.
_number = BigInteger().with_variant(Integer(), "sqlite")

metadata = MetaData()

badges = Table(
    "badges",
    metadata,
    Column("id", _text, primary_key=True),
    Column("name_nfc", _text, nullable=False),
    Column("layout_key", _text, nullable=False),
    Column("badge", Packed, nullable=False),
    Column("issued_at", _text, nullable=False),
    Column("revoked_at", _text),
    Column("revoked_reason", _text),
    Column("as_built", Packed),
    Column("as_built_at", _text),
    Column("signature", _text, nullable=False),
)
# With the id behind them these indexes also serve the ordered list and the first id of each layout.
Index("badges_by_name", badges.c.name_nfc, badges.c.id)
Index("badges_by_layout", badges.c.layout_key, badges.c.id)
#: An id is also found by any of its first parts of this many digits: a damaged reading may have one part right.
PART_DIGITS, PARTS = 4, 4


def id_part(place: int) -> ColumnElement[str]:
    """Part `place` of an id, as the indexes hold it."""
    begin: ColumnElement[int] = literal_column(str(1 + PART_DIGITS * place))
    digits: ColumnElement[int] = literal_column(str(PART_DIGITS))
    # Named as plain text, or an order of its own would be asked for where PostgreSQL's index takes none.
    return func.substr(badges.c.id, begin, digits, type_=Text())


# The first part needs none: it is the beginning of the primary key.
for _place in range(1, PARTS):
    Index(f"badges_by_part{_place}", id_part(_place))

log = Table(
    "log",
    metadata,
    Column("seq", _number, primary_key=True, autoincrement=False),
    Column("time", _text, nullable=False),
    Column("action", _text, nullable=False),
    Column("subject", _text, nullable=False),
    Column("record_sha256", _text, nullable=False),
    Column("previous", _text, nullable=False),
    Column("hash", _text, nullable=False),
    Column("signature", _text, nullable=False),
)
# Serves the newest entry of a record, which every reading compares.
Index("log_by_subject", log.c.subject, log.c.seq)

authority = Table(
    "authority",
    metadata,
    Column("one", Integer, CheckConstraint("one = 1"), primary_key=True, autoincrement=False),
    Column("public_key", _text, nullable=False),
    Column("head_seq", _number, nullable=False),
    Column("head_hash", _text, nullable=False),
    Column("head_signature", _text, nullable=False),
)

schema_version = Table("schema_version", metadata, Column("version", Integer, primary_key=True, autoincrement=False))


def select_records() -> AnySelect:
    """The rows that `record_of` reads: all columns of `badges`, and `newest`, the digest in each one's newest entry."""
    newest = (
        select(log.c.record_sha256)
        .where(log.c.subject == badges.c.id)
        .order_by(log.c.seq.desc())
        .limit(1)
        .scalar_subquery()
    )
    return select(badges, newest.label("newest"))


def select_alike(parts: Mapping[int, str]) -> AnySelect:
    """The ids that have one of these parts (place -> digits)."""
    # The sign ~ sorts after all digits.
    begins = [and_(badges.c.id >= digits, badges.c.id <= f"{digits}~") for place, digits in parts.items() if place == 0]
    inside = [id_part(place) == digits for place, digits in parts.items() if place > 0]
    return select(badges.c.id).where(or_(*begins, *inside)).order_by(badges.c.id)


def select_layouts() -> AnySelect:
    """As `select_records`, of the lowest id of each layout.

    Steps from key to key through the index, because a GROUP BY would walk over every record: a million of them share
    a handful of layouts.
    """
    keys = select(func.min(badges.c.layout_key).label("key")).cte("keys", recursive=True)
    following = select(func.min(badges.c.layout_key)).where(badges.c.layout_key > keys.c.key).scalar_subquery()
    keys = keys.union_all(select(following).where(keys.c.key.is_not(None)))
    first = select(func.min(badges.c.id)).where(badges.c.layout_key == keys.c.key).scalar_subquery()
    return select_records().where(badges.c.id.in_(select(first).where(keys.c.key.is_not(None)))).order_by(badges.c.id)


def prepare(engine: Engine, shown: str, *, create: bool, make_authority: bool) -> str | None:
    """Make the tables where there are none and `create` is true, and look at them; returns the authority's public key.

    A registry without an authority gets one, with a new key pair, where `create` and `make_authority` are true.  Else
    None is returned for it where `create` is true: it waits for an import.  `shown` names the registry in messages.
    Raises: RegistryError where the database holds nothing, another program's tables, or another version of ours.
    """
    with engine.connect() as connection:
        names, public_key = _look(connection)
    if create and (not names or (public_key is None and make_authority and set(metadata.tables) <= names)):
        _create(engine, make_authority=make_authority)
        with engine.connect() as connection:
            names, public_key = _look(connection)
    if not names:
        raise _empty(shown)
    if {schema_version.name, badges.name} <= names:
        with engine.connect() as connection:
            _check_version(list(connection.scalars(select(schema_version.c.version))), shown)
    if not set(metadata.tables) <= names:
        raise RegistryError(
            f"registry {shown} is a database, but not one of moireid's; give another URL, or an empty database"
        )
    if public_key is None and not create:
        raise _empty(shown)
    return public_key


def _empty(shown: str) -> RegistryError:
    return RegistryError(f"registry {shown} is empty; enroll someone first, or run `moireid registry init`")


def _look(connection: Connection) -> tuple[set[str], str | None]:
    """The names of all tables, and the authority's public key where there is one."""
    names = set(inspect(connection).get_table_names())
    if not set(metadata.tables) <= names:
        return names, None
    return names, connection.scalar(select(authority.c.public_key))


def _check_version(found: list[int], shown: str) -> None:
    """Raise unless the one version found is ours."""
    if found == [SCHEMA_VERSION]:
        return
    version = ", ".join(map(str, found)) or "none"
    if found == [1]:
        remedy = "its records bear no signatures, so enroll the badges anew in another registry"
    else:
        remedy = "open it with the moireid that wrote it, or a newer one"
    raise RegistryError(
        f"registry {shown} has schema version {version}, and this moireid reads version {SCHEMA_VERSION}; {remedy}",
        found=found,
        supported=SCHEMA_VERSION,
    )


def _create(engine: Engine, *, make_authority: bool) -> None:
    """Make the tables, their version and the authority in one transaction, unless another process was faster."""
    # The key is on the disk before the registry says that it is the authority's.
    signer, path = make_key() if make_authority else (None, None)
    used = False
    try:
        with writing(engine) as connection:
            # Another process may have made them while this one waited for the write lock.
            names, public_key = _look(connection)
            if not names:
                metadata.create_all(connection)
                connection.execute(insert(schema_version).values(version=SCHEMA_VERSION))
            if signer is not None and public_key is None:
                head_row, entry = first_rows(signer)
                connection.execute(insert(authority).values(head_row))
                connection.execute(insert(log).values(entry))
                used = True
    except (IntegrityError, ProgrammingError):
        # Databases without a single write lock, such as PostgreSQL, refuse the second of two makers here.  If the
        # other one has succeeded, nothing is left to do; otherwise this error is reported.
        used = False
        with engine.connect() as connection:
            names, public_key = _look(connection)
        if not set(metadata.tables) <= names or (make_authority and public_key is None):
            raise
    finally:
        if path is not None and not used:
            path.unlink(missing_ok=True)
