"""The tables of tokens and sessions, and what an older file lacks of them."""

from __future__ import annotations

from sqlalchemy import Column, Engine, MetaData, Table, Text, inspect, text

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


def bring_up(engine: Engine, expires_at: str) -> None:
    """Make what is absent; tokens of a file in which none expired do so at `expires_at`."""
    metadata.create_all(engine)
    if "expires_at" not in {column["name"] for column in inspect(engine).get_columns(tokens.name)}:
        with engine.begin() as connection:
            connection.execute(text("ALTER TABLE tokens ADD COLUMN expires_at TEXT NOT NULL DEFAULT ''"))
            connection.execute(tokens.update().values(expires_at=expires_at))
