"""The verdicts that a studio gave: who asked and when, which film by its digest, which claim, what came out.

No film is kept, no name of a file, and no name of a person: a claim is kept as the badge's id, and whose that is, the
registry says as long as it knows.  So nothing here need be erased with a person.  Entries go after `keep_days`.

The file lies in the studio's folder.  It is the studio's own note and bears no signature: `moireid verify --sign` makes
a verdict that others can check.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from sqlalchemy import Column, Engine, Integer, MetaData, Table, Text, create_engine, delete, event, insert, select
from sqlalchemy.engine import URL
from sqlalchemy.exc import SQLAlchemyError

from moireid.errors import RegistryError

FILE = "verdicts.sqlite3"
#: What a verdict may be; the process that decodes strangers' films cannot have others written down.
WORDS = frozenset({"accept", "reject", "inconclusive", "found", "nobody"})
_ID = re.compile(r"[0-9a-f]{6}|[0-9a-f]{16}|[0-9a-f]{32}")

metadata = MetaData()
verdicts = Table(
    "verdicts",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("at", Text, nullable=False, index=True),
    Column("token", Text, nullable=False),
    Column("kind", Text, nullable=False),
    Column("film_sha256", Text),
    Column("claim", Text),
    Column("claim_source", Text),
    Column("verdict", Text, nullable=False),
    Column("read", Text),
    Column("registry", Text),
    Column("moireid", Text, nullable=False),
)


@dataclass(frozen=True)
class Given:
    """One verdict that was given.

    at: UTC, ISO 8601; token: the id of whoever asked, "loopback" where the studio asks for none; kind: verify,
    identify, live, call or link; film_sha256: of the film as it came, None of live pictures; claim: the claimed badge's
    id, None where nobody was claimed; claim_source: "registry", "file" or None; read: the id that the film was found to
    show; registry: the fingerprint and head that were asked; moireid: the version.
    """

    number: int
    at: str
    token: str
    kind: str
    film_sha256: str | None
    claim: str | None
    claim_source: str | None
    verdict: str
    read: str | None
    registry: str | None
    moireid: str

    def to_json(self) -> dict[str, Any]:
        """As the API, the command and its exports tell it."""
        return asdict(self)


class Verdicts:
    """The verdicts of one studio's folder; safe to use from any thread."""

    def __init__(self, folder: Path, keep_days: float | None) -> None:
        """keep_days: older ones are removed, None where nothing is (a command that only reads).

        Raises: RegistryError where the file cannot be made or read.
        """
        self.path, self._keep_days = folder / FILE, keep_days
        try:
            self._engine: Engine = create_engine(URL.create("sqlite", database=str(self.path.absolute())))
            event.listen(self._engine, "connect", lambda raw, _: raw.execute("PRAGMA secure_delete = ON"))
            metadata.create_all(self._engine)
            # Who asks for what is their own business.
            self.path.chmod(0o600)
            self._remove_old()
        except (OSError, SQLAlchemyError) as error:
            raise self._broken(error) from error

    def close(self) -> None:
        """Close the connections."""
        self._engine.dispose()

    def note(self, **given: Any) -> None:
        """Write one down, as `Given` without its number and time.  Raises: RegistryError where that fails."""
        if self._keep_days == 0:
            return
        try:
            with self._engine.begin() as connection:
                connection.execute(insert(verdicts).values(given | {"at": _text(datetime.now(UTC))}))
            self._remove_old()
        except SQLAlchemyError as error:
            raise self._broken(error) from error

    def given(self, limit: int, before: int | None = None, since: str | None = None) -> list[Given]:
        """The newest first; before: only those of a lower number; since: only from that time on."""
        query = select(verdicts).order_by(verdicts.c.number.desc()).limit(limit)
        query = query if before is None else query.where(verdicts.c.number < before)
        query = query if since is None else query.where(verdicts.c.at >= since)
        try:
            with self._engine.connect() as connection:
                return [Given(**row._mapping) for row in connection.execute(query)]
        except SQLAlchemyError as error:
            raise self._broken(error) from error

    def _remove_old(self) -> None:
        if self._keep_days is not None:
            oldest = _text(datetime.now(UTC) - timedelta(days=self._keep_days))
            with self._engine.begin() as connection:
                connection.execute(delete(verdicts).where(verdicts.c.at < oldest))

    def _broken(self, error: Exception) -> RegistryError:
        reason = str(getattr(error, "orig", None) or getattr(error, "strerror", None) or error)
        return RegistryError(f"the verdicts in {self.path} cannot be used ({reason}); give another folder with --data")


def said(result: Mapping[str, Any]) -> dict[str, Any]:
    """Verdict and identity of a report, of which only what can be one is taken: a decoder made it."""
    word = result.get("finding") or result.get("verdict")
    identity = result.get("identity")
    read = result.get("found_id") or (identity.get("decoded_id") if isinstance(identity, Mapping) else None)
    known = isinstance(read, str) and _ID.fullmatch(read)
    return {"verdict": word if word in WORDS else "unknown", "read": read if known else None}


def _text(moment: datetime) -> str:
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")
