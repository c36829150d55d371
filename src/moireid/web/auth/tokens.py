"""Tokens: shown only once, when they are made; only a hash, a role and times are kept.

A token is 256 random bits, so nobody can find it from its plain SHA-256: neither salt nor a slow hash is needed.
The file lies in the studio's folder and not in the registry, which is copied and exported to others.
"""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, get_args

from sqlalchemy import Column, Engine, Executable, MetaData, Table, Text, create_engine, insert, select, update
from sqlalchemy.engine import URL
from sqlalchemy.exc import SQLAlchemyError

from moireid.errors import RegistryError, SpecError

Role = Literal["issuer", "verifier", "admin"]
ROLES: tuple[Role, ...] = get_args(Role)
PREFIX = "moireid_"
#: A token's id is this many hex digits of its hash: enough to name it, and useless for signing in.
ID_DIGITS = 12
LONGEST_NOTE = 100

metadata = MetaData()
tokens = Table(
    "tokens",
    metadata,
    Column("sha256", Text, primary_key=True),
    Column("role", Text, nullable=False),
    Column("note", Text, nullable=False),
    Column("made_at", Text, nullable=False),
    Column("revoked_at", Text),
)


@dataclass(frozen=True)
class Token:
    """What is stored about a token; the token itself is not."""

    id: str
    role: Role
    note: str
    made_at: str
    revoked_at: str | None


class Tokens:
    """The tokens of one studio's folder."""

    def __init__(self, folder: Path) -> None:
        """Raises: RegistryError where the folder or its file cannot be made or read."""
        self.path = folder / "tokens.sqlite3"
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._engine: Engine = create_engine(URL.create("sqlite", database=str(self.path.absolute())))
            metadata.create_all(self._engine)
        except (OSError, SQLAlchemyError) as error:
            raise self._broken(error) from error

    def close(self) -> None:
        """Close the connections."""
        self._engine.dispose()

    def create(self, role: str, note: str = "") -> tuple[str, Token]:
        """A new token, and what is stored about it; the token can never be shown again.

        Raises: SpecError where there is no such role, or the note is no line of text.
        """
        if role not in ROLES:
            raise SpecError(f"role {role[:40]!r} is none; give one of {', '.join(ROLES)}")
        if len(note) > LONGEST_NOTE or not note.isprintable():
            raise SpecError(f"note {note[:80]!r} is none; give one line of at most {LONGEST_NOTE} letters")
        secret = PREFIX + secrets.token_urlsafe(32)
        row = {"sha256": _hash(secret), "role": role, "note": note, "made_at": _now(), "revoked_at": None}
        self._write(insert(tokens).values(row))
        return secret, _token(row)

    def find(self, secret: str) -> Token | None:
        """The token that is shown, unless it is unknown or revoked."""
        rows = self._rows(select(tokens).where(tokens.c.sha256 == _hash(secret), tokens.c.revoked_at.is_(None)))
        return _token(rows[0]) if rows else None

    def all(self) -> list[Token]:
        """All tokens, revoked ones too, oldest first."""
        return [_token(row) for row in self._rows(select(tokens).order_by(tokens.c.made_at, tokens.c.sha256))]

    def revoke(self, token_id: str) -> Token:
        """Revoke a token by its id, for good; again changes nothing.  Raises: SpecError where there is none."""
        found = [token for token in self.all() if token.id == token_id.lower()]
        if not found:
            raise SpecError(f"no token has the id {token_id[:40]!r}; `moireid token list` shows them")
        if found[0].revoked_at is None:
            same = tokens.c.sha256.startswith(found[0].id, autoescape=True)
            self._write(update(tokens).where(same).values(revoked_at=_now()))
        return next(token for token in self.all() if token.id == found[0].id)

    def _rows(self, query: Executable) -> list[dict[str, Any]]:
        try:
            with self._engine.connect() as connection:
                return [dict(row._mapping) for row in connection.execute(query)]
        except SQLAlchemyError as error:
            raise self._broken(error) from error

    def _write(self, statement: Executable) -> None:
        try:
            with self._engine.begin() as connection:
                connection.execute(statement)
        except SQLAlchemyError as error:
            raise self._broken(error) from error

    def _broken(self, error: Exception) -> RegistryError:
        reason = str(getattr(error, "orig", None) or getattr(error, "strerror", None) or error)
        return RegistryError(f"the tokens in {self.path} cannot be used ({reason}); give another folder with --data")


@contextmanager
def open_tokens(folder: Path | None) -> Iterator[Tokens]:
    """The tokens in a studio's folder, the default one for None."""
    from moireid.web.settings import default_data

    found = Tokens(folder or default_data())
    try:
        yield found
    finally:
        found.close()


def _token(row: dict[str, Any]) -> Token:
    return Token(row["sha256"][:ID_DIGITS], row["role"], row["note"], row["made_at"], row["revoked_at"])


def _hash(secret: str) -> str:
    return hashlib.sha256(secret.encode("utf-8", "surrogatepass")).hexdigest()


def _now() -> str:
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
