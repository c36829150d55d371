"""One-time links: who asked whom for a check, whether the link was opened and used, and what came out.

A link's secret is 256 random bits, shown once, to the one who asks; only its SHA-256 is kept.  It opens one check of
one claim, once, within half an hour, and nothing else.  Results are kept for `KEEP_DAYS`, and only the one who asked
can see them.  No name of a person is in the columns: a claim is the badge's id, as in `verdicts.py`.
"""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

from sqlalchemy import (
    Column,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    delete,
    func,
    insert,
    select,
    update,
)

from moireid.verifier.report.live_receipt import FilmAsked
from moireid_studio.store.database import database_of, secret_digest, utc_text

FILE = "links.sqlite3"
#: How long a link can be used, minutes; how long its result is kept, days; the most that one token may have waiting.
LASTS_MIN, KEEP_DAYS, MOST_WAITING = 30.0, 7.0, 50
#: A check that began so long ago, minutes, and has no end was broken off with its studio; none lasts so long.
BROKEN_MIN = 10.0
#: The most pictures of a check that are kept, where both agree.
MOST_PICTURES = 12

metadata = MetaData()
links = Table(
    "links",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("id", Text, nullable=False, unique=True),
    Column("sha256", Text, nullable=False, unique=True),
    Column("asked_by", Text, nullable=False, index=True),
    Column("asks", Text, nullable=False),
    Column("claim", Text, nullable=False),
    Column("ids", Integer, nullable=False),
    Column("wants_pictures", Integer, nullable=False),
    Column("agreed", Integer),
    Column("made_at", Text, nullable=False),
    Column("expires_at", Text, nullable=False),
    Column("opened_at", Text),
    Column("used_at", Text),
    Column("ended_at", Text),
    Column("report", Text),
    Column("film_name", Text),
    Column("film_sha256", Text),
)
pictures = Table(
    "link_pictures",
    metadata,
    Column("link", Text, primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("jpeg", LargeBinary, nullable=False),
)


@dataclass(frozen=True)
class OneTimeLink:
    """What is kept of a link; times are UTC, ISO 8601.

    asked_by: the token of the one who asks; asks: how they call themselves to the other person; claim: the badge's id;
    ids: whether who asks may learn ids; wants_pictures, agreed: what each of the two wants; report: the verdict's event
    as JSON, as it was given; film_name, film_sha256: of the film that the other person is asked about, if it is one.
    """

    id: str
    asked_by: str
    asks: str
    claim: str
    ids: bool
    wants_pictures: bool
    agreed: bool | None
    made_at: str
    expires_at: str
    opened_at: str | None
    used_at: str | None
    ended_at: str | None
    report: str | None
    film_name: str | None = None
    film_sha256: str | None = None

    @property
    def film(self) -> FilmAsked | None:
        """The film that the other person is asked about."""
        return None if self.film_sha256 is None else FilmAsked(self.film_name or "", self.film_sha256)

    @property
    def state(self) -> str:
        """waiting, opened, late, running, broken (it was used and gave no verdict), or done."""
        if self.report is not None:
            return "done"
        if self.used_at is not None:
            oldest = utc_text(-timedelta(minutes=BROKEN_MIN))
            return "broken" if self.ended_at is not None or self.used_at < oldest else "running"
        if self.expires_at <= utc_text():
            return "late"
        return "opened" if self.opened_at is not None else "waiting"

    @property
    def report_sha256(self) -> str | None:
        """The digest of the report's text in UTF-8."""
        return None if self.report is None else hashlib.sha256(self.report.encode()).hexdigest()


class Links:
    """The links of one studio, or of several that share a database; safe to use from any thread."""

    def __init__(self, folder: Path, state: str | None = None) -> None:
        """Open the database, make what tables are absent, and remove old links.

        Parameters
        ----------
        state
            A database of PostgreSQL, None for the folder's own file.

        Raises
        ------
        RegistryError
            Where the database cannot be made or read.
        """
        self._database = database_of(folder, FILE, state)
        self._database.make(metadata)
        self.remove_old()

    def close(self) -> None:
        """Close the connections."""
        self._database.close()

    def make(
        self,
        asked_by: str,
        asks: str,
        claim: str,
        *,
        ids: bool,
        wants_pictures: bool,
        film: FilmAsked | None = None,
    ) -> tuple[str, OneTimeLink] | None:
        """A new link: its secret, which can never be shown again, and what is kept; None where too many wait."""
        self.remove_old()
        waits = links.c.asked_by == asked_by, links.c.used_at.is_(None), links.c.expires_at > utc_text()
        if self._database.rows(select(func.count().label("count")).where(*waits))[0]["count"] >= MOST_WAITING:
            return None
        secret = secrets.token_urlsafe(32)
        row: dict[str, Any] = {
            "id": secrets.token_hex(8),
            "sha256": secret_digest(secret),
            "asked_by": asked_by,
            "asks": asks,
            "claim": claim,
            "film_name": film and film.name,
            "film_sha256": film and film.sha256,
        }
        row |= {"ids": int(ids), "wants_pictures": int(wants_pictures), "made_at": utc_text()}
        self._database.change(insert(links).values(row | {"expires_at": utc_text(timedelta(minutes=LASTS_MIN))}))
        found = self.by_secret(secret)
        return None if found is None else (secret, found)

    def by_secret(self, secret: str) -> OneTimeLink | None:
        """The link of a secret, also a late or used one."""
        return self._one(links.c.sha256 == secret_digest(secret))

    def find(self, link_id: str, asked_by: str) -> OneTimeLink | None:
        """A link by its id, for the one who asked."""
        return self._one(links.c.id == link_id, links.c.asked_by == asked_by)

    def of_asker(self, asked_by: str, limit: int) -> list[OneTimeLink]:
        """The links of one who asks, the newest first."""
        mine = select(links).where(links.c.asked_by == asked_by).order_by(links.c.number.desc()).limit(limit)
        return [_link(row) for row in self._database.rows(mine)]

    def about(self, film_sha256: str, asked_by: str) -> list[OneTimeLink]:
        """The links of one who asks about a film, the oldest first."""
        mine = links.c.asked_by == asked_by, links.c.film_sha256 == film_sha256
        return [_link(row) for row in self._database.rows(select(links).where(*mine).order_by(links.c.number))]

    def note_opened(self, link: OneTimeLink) -> None:
        """The other person has the link open; only the first time is kept."""
        self._database.change(
            update(links).where(links.c.id == link.id, links.c.opened_at.is_(None)).values(opened_at=utc_text())
        )

    def use(self, link: OneTimeLink, *, agreed: bool) -> bool:
        """Use the link up, if it was not used before and is not late: of two at once, one alone gets True."""
        unused = links.c.id == link.id, links.c.used_at.is_(None), links.c.expires_at > utc_text()
        return self._database.change(update(links).where(*unused).values(used_at=utc_text(), agreed=int(agreed))) == 1

    def note_end(self, link: OneTimeLink, report: Mapping[str, Any] | None, kept: list[bytes]) -> None:
        """The check is over.  report: its verdict's event, None where there is none; kept: JPEGs, if both agreed."""
        document = None if report is None else json.dumps(report, ensure_ascii=False, sort_keys=True)
        running = links.c.id == link.id, links.c.ended_at.is_(None)
        if self._database.change(update(links).where(*running).values(ended_at=utc_text(), report=document)) == 0:
            # It was removed meanwhile, or has its end: pictures without a link would never be removed.
            return
        for number, jpeg in enumerate(kept[:MOST_PICTURES]):
            self._database.change(insert(pictures).values(link=link.id, number=number, jpeg=jpeg))

    def pictures(self, link: OneTimeLink) -> list[bytes]:
        """The JPEGs that were kept of a check, in order."""
        kept = select(pictures.c.jpeg).where(pictures.c.link == link.id).order_by(pictures.c.number)
        return [row["jpeg"] for row in self._database.rows(kept)]

    def remove(self, link: OneTimeLink) -> None:
        """Remove a link with all that is kept of it; a secret that is still about opens nothing then."""
        self._database.change(delete(pictures).where(pictures.c.link == link.id))
        self._database.change(delete(links).where(links.c.id == link.id))

    def _one(self, *where: Any) -> OneTimeLink | None:
        rows = self._database.rows(select(links).where(*where))
        return _link(rows[0]) if rows else None

    def remove_old(self) -> None:
        """Remove links that are older than `KEEP_DAYS`, with all that is kept of them."""
        oldest = utc_text(-timedelta(days=KEEP_DAYS))
        old = select(links.c.id).where(links.c.made_at < oldest)
        self._database.change(delete(pictures).where(pictures.c.link.in_(old)))
        self._database.change(delete(links).where(links.c.made_at < oldest))


def _link(row: dict[str, Any]) -> OneTimeLink:
    values = {name: value for name, value in row.items() if name not in ("number", "sha256")}
    values |= {name: bool(row[name]) for name in ("ids", "wants_pictures")}
    return OneTimeLink(**values | {"agreed": None if row["agreed"] is None else bool(row["agreed"])})
