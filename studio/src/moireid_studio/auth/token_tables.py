"""The tables of tokens and sessions, and what an older file lacks of them."""

from __future__ import annotations

from sqlalchemy import Column, Connection, MetaData, Table, Text, inspect, text

metadata = MetaData()
tokens = Table(
    "tokens",
    metadata,
    Column("sha256", Text, primary_key=True),
    Column("role", Text, nullable=False),
    Column("note", Text, nullable=False),
    Column("made_at", Text, nullable=False),
    Column("revoked_at", Text),
    Column("expires_at", Text, nullable=False),
)
sessions = Table(
    "sessions",
    metadata,
    Column("sha256", Text, primary_key=True),
    Column("token", Text, nullable=False),
    Column("expires_at", Text, nullable=False),
)


def bring_up(connection: Connection, expires_at: str) -> None:
    """Add what an older file lacks: tokens of one in which none expired do so at `expires_at`."""
    if "expires_at" not in {column["name"] for column in inspect(connection).get_columns(tokens.name)}:
        connection.execute(text("ALTER TABLE tokens ADD COLUMN expires_at TEXT NOT NULL DEFAULT ''"))
        connection.execute(tokens.update().values(expires_at=expires_at))
