"""The verdicts that a studio gave: who asked and when, which film by its digest, which claim, what came out.

No film is kept, no name of a file, and no name of a person: a claim is kept as the badge's id, and whose that is, the
registry says as long as it knows.  So nothing here need be erased with a person.  Entries go after `keep_days`.

The file is in the studio's folder.  It is the studio's own note and bears no signature: `moireid verify --sign` makes
a verdict that others can check.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

from sqlalchemy import Column, Connection, Integer, MetaData, Table, Text, delete, select
from sqlalchemy.dialects import postgresql, sqlite

from moireid import __version__
from moireid.provenance import Standing
from moireid_studio.store.database import database_of, utc_text
from moireid_studio.store.job import Job

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
    # Of a film's job, so that one that was done twice is written down once; None of live checks.
    Column("job", Text, unique=True),
)


@dataclass(frozen=True)
class StoredVerdict:
    """One verdict that was given.

    at: UTC, ISO 8601; token: the id of the token that asked, "loopback" where the studio asks for none; kind: verify,
    identify, live, call, link or enroll; film_sha256: of the film as it came, None of live pictures; claim: the claimed
    badge's id, None where no one was claimed; claim_source: "registry", "file" or None; read: the id that the film
    shows; registry: the fingerprint and head that were asked; moireid: the version.
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
        """As the API, the command and its exports show it."""
        return asdict(self)


class Verdicts:
    """The verdicts of one studio's folder; safe to use from any thread."""

    def __init__(self, folder: Path, keep_days: float | None, state: str | None = None) -> None:
        """Open the database, make what tables are absent, and remove old verdicts.

        Parameters
        ----------
        keep_days
            Older ones are removed, None where nothing is (a command that only reads).
        state
            A database of PostgreSQL, None for the folder's own file.

        Raises
        ------
        RegistryError
            Where the database cannot be made or read.
        """
        self.path, self._keep_days = folder / FILE, keep_days
        # Who asks for what is their own business: the file is closed to others.
        self._database = database_of(folder, FILE, state)
        self._database.make(metadata)
        with self._database.writing() as connection:
            self._remove_old(connection)

    def close(self) -> None:
        """Close the connections."""
        self._database.close()

    def note(self, **given: Any) -> None:
        """Save one, as `StoredVerdict` without its number and time; a job's verdict once.  Raises: RegistryError."""
        if self._keep_days == 0:
            return
        insert = postgresql.insert if self._database.shared else sqlite.insert
        new = insert(verdicts).values(given | {"at": utc_text()})
        with self._database.writing() as connection:
            connection.execute(new.on_conflict_do_nothing(index_elements=["job"]))
            self._remove_old(connection)

    def note_result(self, asked_by: str, kind: str, result: Mapping[str, Any], **about: Any) -> None:
        """Write down what a check found; about: film_sha256, claim, claim_source, job, and the `standing` it asked.

        Raises: RegistryError.
        """
        standing: Standing | None = about.pop("standing")
        asked = None if standing is None else f"{standing.fingerprint} {standing.head}"
        self.note(token=asked_by, kind=kind, **about | said(result) | {"registry": asked, "moireid": __version__})

    def note_job(self, job: Job) -> None:
        """Write down what a film's job found, once; of other jobs nothing.  Raises: RegistryError."""
        if job.kind in ("verify", "identify") and isinstance(job.result, dict):
            about = {"film_sha256": job.film_sha256, "claim": job.claimed_id, "claim_source": job.claim_source}
            self.note_result(job.owner, job.kind, job.result, **about, standing=job.standing, job=job.id)

    def given(self, limit: int, before: int | None = None, since: str | None = None) -> list[StoredVerdict]:
        """The newest first; before: only those of a lower number; since: only from that time on."""
        query = (
            select(*(verdicts.c[name] for name in StoredVerdict.__annotations__))
            .order_by(verdicts.c.number.desc())
            .limit(limit)
        )
        query = query if before is None else query.where(verdicts.c.number < before)
        query = query if since is None else query.where(verdicts.c.at >= since)
        return [StoredVerdict(**row) for row in self._database.rows(query)]

    def _remove_old(self, connection: Connection) -> None:
        if self._keep_days is not None:
            oldest = utc_text(-timedelta(days=self._keep_days))
            connection.execute(delete(verdicts).where(verdicts.c.at < oldest))


def said(result: Mapping[str, Any]) -> dict[str, Any]:
    """Verdict and identity of a report, of which only what can be one is taken: a decoder made it."""
    word = result.get("finding") or result.get("verdict")
    identity = result.get("identity")
    read = result.get("found_id") or (identity.get("decoded_id") if isinstance(identity, Mapping) else None)
    known = isinstance(read, str) and _ID.fullmatch(read)
    return {"verdict": word if word in WORDS else "unknown", "read": read if known else None}
