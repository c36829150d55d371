"""The tables, their version, and their queries.

`badges` holds one row for each issued badge: its signed record (record.py).  `log` holds one for each action (log.py),
and `authority` a single row: the public key, and the log's head, signed.
A later version that changes tables must raise `SCHEMA_VERSION`; so must one that changes what `Badge.layout_key`
hashes, what is signed, or what names look like, because old keys, signatures and skeletons would no longer compare.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sqlalchemy import (
    BigInteger,
    CheckConstraint,
    Column,
    Connection,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    func,
    select,
)

from moireid.registry.engine import AnyRow, AnySelect

SCHEMA_VERSION = 8
#: Rows fetched at a time when all are read.
PAGE = 500


class PackedBytes(LargeBinary):
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
    Column("badge", PackedBytes, nullable=False),
    Column("issued_at", _text, nullable=False),
    Column("revoked_at", _text),
    Column("revoked_reason", _text),
    Column("as_built", PackedBytes),
    Column("as_built_at", _text),
    Column("as_built_reason", _text),
    Column("as_built_earlier", PackedBytes),
    Column("salt", _text),
    Column("skeleton", _text, nullable=False, server_default=""),
    Column("folded", _text, nullable=False, server_default=""),
    Column("signature", _text, nullable=False),
)
# With the id behind them these indexes also serve the ordered list and the first id of each layout.
Index("badges_by_name", badges.c.name_nfc, badges.c.id)
Index("badges_by_layout", badges.c.layout_key, badges.c.id)
# What a name looks like, and what it looks like in lower case and plain width.
Index("badges_by_skeleton", badges.c.skeleton)
Index("badges_by_folded", badges.c.folded)
log = Table(
    "log",
    metadata,
    Column("seq", _number, primary_key=True, autoincrement=False),
    Column("time", _text, nullable=False),
    Column("action", _text, nullable=False),
    Column("subject", _text, nullable=False),
    Column("record_sha256", _text, nullable=False),
    Column("actor", _text, nullable=False),
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


def pages(connection: Connection, query: AnySelect, key: Column[Any]) -> Iterator[AnyRow]:
    """The rows of a query in the order of its unique column `key`, fetched page by page within one transaction."""
    page = query.order_by(key).limit(PAGE)
    rows = list(connection.execute(page))
    while rows:
        yield from rows
        rows = list(connection.execute(page.where(key > rows[-1]._mapping[key.name])))


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
