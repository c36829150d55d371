"""One film scored by one pipeline: a row of figures, and its key.

A row depends on film, claim and program, and not on the manifest's labels, so a collection can be relabelled without
being scored again.
Convention: verdict "failed" if the film could not be scored, with the reason in `error` and its kind in `fault`; the
    published pipeline reads no identity, so its verdict is about the motion alone.  Labels and groups are in the
    manifest, and are joined to rows by `film`.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct
from msgspec.structs import asdict

from moireid.errors import MoireIdError
from moireid.question import Question
from moireid.result_cache import program_digest
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.reasons import json_number
from moireid.verifier.session.film import verify
from moireid.verifier.session.result import Report
from moireid_lab.archive.isolated import Fault, LostJob
from moireid_lab.baseline.corners import without_corners
from moireid_lab.baseline.pipeline import verify_published
from moireid_lab.evaluation.manifest import Entry

Pipeline = Literal["moireid", "published"]
PIPELINES: tuple[Pipeline, ...] = ("moireid", "published")
#: Spread over windows is the published pipeline's alone; null in ours.
FIGURES = (
    "score",
    "window_correlation_mean",
    "window_correlation_max",
    "window_correlation_min",
    "window_correlation_sd",
    "correlation",
    "gain_ratio",
    "gain_sd",
    "phase_residual_rad",
    "excitation_rad",
)
#: Format of a row; raise it if the content of rows changes.
FORMAT = 6
Row = dict[str, Any]
#: Temporary faults: the next run tries such a film again.
PASSING: frozenset[Fault] = frozenset({"worker", "program"})


@dataclass(frozen=True)
class Job:
    """A film to be scored by one pipeline."""

    entry: Entry
    pipeline: Pipeline


class ScoredRow(Struct, forbid_unknown_fields=True):
    """What scoring a film may answer; a row also has its key, film, claim, pipeline, program and worker.

    again: whether the next run tries it again; sealed: stated by the process that begins the one that reads the film.
    """

    verdict: Literal["accept", "reject", "inconclusive", "failed"]
    seconds: float
    sha256: Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")] | None = None
    motion: str | None = None
    identity: str | None = None
    score: float | None = None
    window_correlation_mean: float | None = None
    window_correlation_max: float | None = None
    window_correlation_min: float | None = None
    window_correlation_sd: float | None = None
    correlation: float | None = None
    gain_ratio: float | None = None
    gain_sd: float | None = None
    phase_residual_rad: float | None = None
    excitation_rad: float | None = None
    cover: float | None = None
    decoder: str | None = None
    frames: int | None = None
    tracked: int | None = None
    codes: list[str] = []
    reason: str | None = None
    error: str | None = None
    fault: Literal["film"] | None = None
    again: Literal[False] = False
    sealed: list[str] | None = None


def score_film(job: Job, film: str) -> Row:
    """The row of a film at the local path `film`; an unreadable film gets a row too."""
    begun = time.perf_counter()
    try:
        report = _report(job, Path(film))
    except MoireIdError as error:
        # The temporary folder of a fetched film has another name each time.
        words = " ".join(str(error).split()).replace(film, job.entry.video)
        sha256 = OpenedFile(Path(film)).sha256() if Path(film).is_file() else None
        return failed_row(LostJob(words, time.perf_counter() - begun, "film")) | {"sha256": sha256}
    figures = {name: json_number(getattr(report.invariant, name, None)) for name in FIGURES}
    against = [reason for reason in report.reasons if reason.level in ("fail", "undecided")]
    made = ScoredRow(
        report.verdict,
        round(time.perf_counter() - begun, 2),
        report.film["sha256"],
        report.invariant.verdict,
        report.identity.verdict,
        cover=json_number(report.cover.share) if report.cover else None,
        decoder=report.film["decoder"],
        frames=report.frames["read"],
        tracked=report.frames["tracked"],
        codes=[reason.code for reason in against],
        reason=against[0].text if against else None,
        **figures,
    )
    return asdict(made)


def failed_row(lost: LostJob) -> Row:
    """The row of a film that could not be scored; `again`: whether the next run tries it again."""
    found = asdict(ScoredRow("failed", round(lost.seconds, 2), error=lost.why))
    return found | {"fault": lost.fault, "again": lost.fault in PASSING}


def row_key(job: Job) -> str:
    """Key of a row, from the film's path and stamp, claim, corners, pipeline and scoring program."""
    entry = job.entry
    claimed, corners = entry.claimed, entry.corners
    parts = [
        FORMAT,
        entry.video,
        entry.stamp,
        job.pipeline,
        scorer(),
        claim_digest(entry),
        {frame: places.tolist() for frame, places in corners.items()} if corners else None,
        dataclasses.asdict(claimed.as_built) if claimed.as_built else None,
        *(dataclasses.asdict(one) for one in claimed.earlier),
        dataclasses.asdict(claimed.barred) if claimed.barred else None,
    ]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def claim_digest(entry: Entry) -> str:
    """Digest of the claim's content, so that two claims of one badge are equal."""
    return hashlib.sha256(entry.claimed.badge.to_json().encode()).hexdigest()[:16]


@cache
def scorer() -> str:
    """Digest of the scoring program."""
    return program_digest("verifier", "idcodes")


def _report(job: Job, film: Path) -> Report:
    entry = job.entry
    badge = entry.claimed.badge
    if job.pipeline == "published":
        return verify_published(film, Question(badge), corners=entry.corners)
    known = entry.claimed
    report = verify(
        film, Question(badge, badge.id, as_built=known.as_built, earlier=known.earlier, barred=known.barred)
    )
    return without_corners(report) if entry.corners else report
