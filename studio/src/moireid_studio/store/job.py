"""A job as the database keeps it: who asked for what, how far it has come, and what came out."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import msgspec

from moireid.provenance import Revocation, Standing

#: What a job is called.
JOB_ID = re.compile("[0-9a-f]{32}")
State = Literal["receiving", "waiting", "working", "done", "failed"]
STATES: tuple[State, ...] = ("receiving", "waiting", "working", "done", "failed")
#: Work that badges are made by, and the films and pictures of issuers: verifiers' films never come before it.
ISSUE = frozenset({"badge", "event", "capture", "pictures"})
Lane = Literal["issue", "judge"]


@dataclass(frozen=True)
class JobCounts:
    """So many jobs of one token: on their way, or waiting and at work."""

    owner: str
    role: str
    receiving: bool
    count: int


@dataclass
class Job:
    """One job, as it was when it was read.

    folder: of its film, and of all that is kept; wish: what is to be done, as JSON; result: the JSON of the command;
    kept: what was kept with it; problem: code and sentence; begun: when it was asked for; film_name, claim: as the
    visitor gave them; barred: why the claimed badge does not count; standing: of the registry when the film was judged;
    film_sha256: of the film as it came; claimed_id, claim_source: the badge that the claim means, and who says so;
    taken: how often it was begun.
    """

    id: str
    kind: str
    owner: str
    folder: Path
    role: str = "verifier"
    label: str = ""
    begun: datetime = field(default_factory=lambda: datetime.now(UTC))
    film_name: str = ""
    claim: str = ""
    barred: Revocation | None = None
    standing: Standing | None = None
    film_sha256: str | None = None
    claimed_id: str | None = None
    claim_source: str | None = None
    wish: dict[str, Any] = field(default_factory=dict)
    video: str = ""
    bytes: int = 0
    state: State = "receiving"
    frames: tuple[int, int | None] = (0, None)
    result: dict[str, Any] | None = None
    kept: dict[str, Any] = field(default_factory=dict)
    problem: tuple[str, str] | None = None
    taken: int = 0

    @property
    def over(self) -> bool:
        """Whether the job has ended."""
        return self.state in ("done", "failed")

    @property
    def lane(self) -> Lane:
        """Which threads it is for."""
        return "issue" if self.kind in ISSUE else "judge"

    def about(self) -> dict[str, Any]:
        """What is known of it apart from its work, as JSON."""
        known: dict[str, Any] = msgspec.to_builtins({name: getattr(self, name) for name in ABOUT})
        return known


#: Columns of a job's row with the names of its fields; and the fields that are kept together.
OWN = ("id", "kind", "owner", "role", "wish", "bytes", "state", "result", "problem", "taken")
ABOUT = ("label", "begun", "film_name", "claim", "barred", "standing", "film_sha256", "claimed_id", "claim_source")


def job_of(row: Mapping[str, Any], folder: Path) -> Job:
    """The job of a row; folder: that of all jobs."""
    known = {name: row[name] for name in OWN} | row["about"]
    known |= {"folder": folder / row["id"], "frames": (row["read"], row["expected"])}
    return msgspec.convert(known | {"video": row["video"] or "", "kept": row["kept"] or {}}, Job)
