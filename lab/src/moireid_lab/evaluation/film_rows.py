"""One film scored by one pipeline: a row of figures, and its key.

A row depends on film, claim and program, and not on the manifest's labels, so a collection can be relabelled without
being scored again.
Convention: verdict "failed" if the film could not be scored, with the reason in `error` and its kind in `fault`; the
    published pipeline reads no identity, so its verdict is about the motion alone.  Labels and groups are in the
    manifest, and are joined to rows by `film`.
"""

from __future__ import annotations

import hashlib
import json
import time
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

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
    return {
        "sha256": report.film["sha256"],
        "verdict": report.verdict,
        "motion": report.invariant.verdict,
        "identity": report.identity.verdict,
        **figures,
        "cover": json_number(report.cover.share) if report.cover else None,
        "decoder": report.film["decoder"],
        "frames": report.frames["read"],
        "tracked": report.frames["tracked"],
        "seconds": round(time.perf_counter() - begun, 2),
        "codes": [reason.code for reason in against],
        "reason": against[0].text if against else None,
        "error": None,
        "fault": None,
        "again": False,
    }


def failed_row(lost: LostJob) -> Row:
    """The row of a film that could not be scored; `again`: whether the next run tries it again."""
    return {
        "sha256": None,
        "verdict": "failed",
        "motion": None,
        "identity": None,
        **dict.fromkeys((*FIGURES, "cover", "sealed", "decoder")),
        "frames": None,
        "tracked": None,
        "seconds": round(lost.seconds, 2),
        "codes": [],
        "reason": None,
        "error": lost.why,
        "fault": lost.fault,
        "again": lost.fault in PASSING,
    }


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
        asdict(claimed.as_built) if claimed.as_built else None,
        *(asdict(one) for one in claimed.earlier),
        asdict(claimed.barred) if claimed.barred else None,
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


class ScoredRow(Struct, forbid_unknown_fields=True):
    """What scoring a film may answer; a row also has its key, film, claim, pipeline, program and worker.

    sealed: stated by the process that begins the one that reads the film.
    """

    sha256: Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")] | None
    verdict: Literal["accept", "reject", "inconclusive", "failed"]
    motion: str | None
    identity: str | None
    score: float | None
    window_correlation_mean: float | None
    window_correlation_max: float | None
    window_correlation_min: float | None
    window_correlation_sd: float | None
    correlation: float | None
    gain_ratio: float | None
    gain_sd: float | None
    phase_residual_rad: float | None
    excitation_rad: float | None
    cover: float | None
    decoder: str | None
    frames: int | None
    tracked: int | None
    seconds: float
    codes: list[str]
    reason: str | None
    error: str | None
    fault: Literal["film"] | None
    again: Literal[False]
    sealed: list[str] | None = None
