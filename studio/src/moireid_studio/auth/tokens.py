"""Access tokens and the sessions of browsers: their tables, and how they are made, found and ended.

A token is shown only once, when it is made; only its hash, a role and times are kept.  It is 256 random bits, so no one
can find it from its plain SHA-256: neither salt nor a slow hash is needed.  The file is in the studio's folder and not
in the registry, which is copied and exported to others; or all is in a database of PostgreSQL (`serve --state`).

A token lasts until it expires or is revoked.  A browser that signs in with one gets a session of its own, and keeps no
token: signing out ends that session, so what was in its cookie opens nothing any more.  A session ends with its token.
"""

from __future__ import annotations

import secrets
from contextlib import closing
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any, Literal, get_args

from sqlalchemy import (
    Column,
    MetaData,
    Table,
    Text,
    delete,
    insert,
    select,
    update,
)

from moireid.errors import SpecError
from moireid_studio.store.database import database_of, secret_digest, utc_text

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


Role = Literal["issuer", "verifier", "monitor", "admin"]
ROLES: tuple[Role, ...] = get_args(Role)
PREFIX = "moireid_"
#: A token's id is this many hex digits of its hash: enough to name it, and useless for signing in.
ID_DIGITS = 12
LONGEST_NOTE = 100
#: How long a token lasts by default, and how long at most, days; a session, hours.
DEFAULT_DAYS, MOST_DAYS, SESSION_H = 90.0, 3650.0, 12.0


@dataclass(frozen=True)
class Token:
    """What is stored about a token; the token itself is not."""

    id: str
    role: Role
    note: str
    made_at: str
    expires_at: str
    revoked_at: str | None


class Tokens:
    """The tokens of one studio's folder."""

    def __init__(self, folder: Path, state: str | None = None) -> None:
        """Open the database, and make what tables are absent.

        Parameters
        ----------
        state
            A database of PostgreSQL, None for the folder's own file.

        Raises
        ------
        RegistryError
            Where the database cannot be made or read.
        """
        self.path = folder / "tokens.sqlite3"
        self._database = database_of(folder, self.path.name, state)
        self._database.make(metadata)

    def close(self) -> None:
        """Close the connections."""
        self._database.close()

    def create(self, role: str, note: str = "", days: float = DEFAULT_DAYS) -> tuple[str, Token]:
        """A new token that lasts so many days, and what is stored about it; the token can never be shown again.

        Raises: SpecError where there is no such role, the note is no line of text, or the days are too many.
        """
        if role not in ROLES:
            raise SpecError(f"role {role[:40]!r} is none; give one of {', '.join(ROLES)}")
        if len(note) > LONGEST_NOTE or not note.isprintable() or PREFIX in note:
            raise SpecError(
                f"note {note[:80]!r} is none; give one line of at most {LONGEST_NOTE} letters, and no token"
            )
        if not 0 < days <= MOST_DAYS:
            raise SpecError(f"a token cannot last {days:g} days; give more than 0 and at most {MOST_DAYS:g}")
        secret = PREFIX + secrets.token_urlsafe(32)
        row: dict[str, Any] = {"sha256": secret_digest(secret), "role": role, "note": note, "made_at": utc_text()}
        row |= {"expires_at": utc_text(timedelta(days=days)), "revoked_at": None}
        self._database.change(insert(tokens).values(row))
        return secret, _token(row)

    def find(self, secret: str) -> Token | None:
        """The token that is shown, unless it is unknown, has expired or was revoked."""
        return self._valid(secret_digest(secret))

    def begin_session(self, secret: str) -> str | None:
        """A session for a browser that shows a token: the secret for its cookie; None where the token is not valid."""
        if self.find(secret) is None:
            return None
        session, now = PREFIX + secrets.token_urlsafe(32), utc_text()
        # Those that have ended are of no use.
        self._database.change(delete(sessions).where(sessions.c.expires_at <= now))
        row = {
            "sha256": secret_digest(session),
            "token": secret_digest(secret),
            "expires_at": utc_text(timedelta(hours=SESSION_H)),
        }
        self._database.change(insert(sessions).values(row))
        return session

    def of_session(self, session: str) -> Token | None:
        """The token that a session was begun with, as long as both last."""
        still = sessions.c.expires_at > utc_text()
        rows = self._database.rows(select(sessions.c.token).where(sessions.c.sha256 == secret_digest(session), still))
        return self._valid(rows[0]["token"]) if rows else None

    def end_session(self, session: str) -> None:
        """End a session, for good; one that is none is left alone."""
        self._database.change(delete(sessions).where(sessions.c.sha256 == secret_digest(session)))

    def all(self) -> list[Token]:
        """All tokens, expired and revoked ones too, oldest first."""
        return [_token(row) for row in self._database.rows(select(tokens).order_by(tokens.c.made_at, tokens.c.sha256))]

    def revoke(self, token_id: str) -> Token:
        """Revoke a token by its id, for good; again changes nothing.  Raises: SpecError where there is none."""
        found = [token for token in self.all() if token.id == token_id.lower()]
        if not found:
            raise SpecError(f"no token has the id {token_id[:40]!r}; `moireid token list` shows them")
        if found[0].revoked_at is None:
            same = tokens.c.sha256.startswith(found[0].id, autoescape=True)
            self._database.change(update(tokens).where(same).values(revoked_at=utc_text()))
        return next(token for token in self.all() if token.id == found[0].id)

    def _valid(self, sha256: str) -> Token | None:
        still = tokens.c.expires_at > utc_text(), tokens.c.revoked_at.is_(None)
        rows = self._database.rows(select(tokens).where(tokens.c.sha256 == sha256, *still))
        return _token(rows[0]) if rows else None


def open_tokens(folder: Path | None, state: str | None = None) -> closing[Tokens]:
    """The tokens in a studio's folder, the default one for None; or in a database of PostgreSQL."""
    from moireid_studio.settings import default_data

    return closing(Tokens(folder or default_data(), state))


def _token(row: dict[str, Any]) -> Token:
    return Token(
        row["sha256"][:ID_DIGITS], row["role"], row["note"], row["made_at"], row["expires_at"], row["revoked_at"]
    )
