"""One film with one pipeline: a row of figures.

A row holds what the film, the claim and the program make of it, and nothing of the manifest's labels, so that a
collection can be labelled anew without being scored anew.

Convention: verdict "failed" where the film could not be scored at all, with the reason in `error`; the published
pipeline reads no identity and is asked for none, so its verdict is that of the motion alone.
"""

from __future__ import annotations

import hashlib
import json
import time
from dataclasses import asdict, dataclass
from typing import Any, Literal

from moireid.errors import MoireIdError
from moireid.evaluation.manifest import Entry
from moireid.kept import program_digest
from moireid.verifier.published import verify_published
from moireid.verifier.reasons import json_number
from moireid.verifier.verify import Report, verify

Pipeline = Literal["moireid", "published"]
PIPELINES: tuple[Pipeline, ...] = ("moireid", "published")
FIGURES = (
    "score", "window_correlation_mean", "correlation", "gain_ratio", "gain_sd", "phase_residual_rad", "excitation_rad",
)  # fmt: skip
#: Of a row; to be raised where rows come to hold other things.  Figures drawn from rows may change without that.
FORMAT = 1
Row = dict[str, Any]


@dataclass(frozen=True)
class Job:
    """A film to be scored by one pipeline."""

    entry: Entry
    pipeline: Pipeline


def score_film(job: Job) -> Row:
    """The row of a film.  Whatever goes wrong becomes a row too: one film must not end a run over thousands."""
    begun = time.perf_counter()
    try:
        report = _report(job)
    except MoireIdError as error:
        return failed_row(" ".join(str(error).split()), time.perf_counter() - begun)
    # Here a fault of ours is caught: it is told with its film, and the film is tried again by the next run.
    except Exception as error:  # noqa: BLE001
        words = f"something went wrong inside moireid ({type(error).__name__}: {' '.join(str(error).split())[:300]})"
        return failed_row(words, time.perf_counter() - begun, again=True)
    figures = {name: json_number(getattr(report.invariant, name)) for name in FIGURES}
    told = [reason for reason in report.reasons if reason.level in ("fail", "undecided")]
    return {
        "verdict": report.verdict, "motion": report.invariant.verdict, "identity": report.identity.verdict, **figures,
        "frames": report.frames["read"], "tracked": report.frames["tracked"],
        "seconds": round(time.perf_counter() - begun, 2), "codes": [reason.code for reason in told],
        "reason": told[0].text if told else None, "error": None, "again": False,
    }  # fmt: skip


def failed_row(why: str, seconds: float, *, again: bool = False) -> Row:
    """The row of a film that could not be scored; `again`: the next run tries once more."""
    return {
        "verdict": "failed", "motion": None, "identity": None, **dict.fromkeys(FIGURES), "frames": None,
        "tracked": None, "seconds": round(seconds, 2), "codes": [], "reason": None, "error": why, "again": again,
    }  # fmt: skip


def row_key(job: Job, film_sha256: str) -> str:
    """What names a row: the film's content, the claim's, the corners, the pipeline, and the program that scores."""
    claimed, corners = job.entry.claimed, job.entry.corners
    parts = [
        FORMAT, film_sha256, job.pipeline, program_digest("verifier", "idcodes"), claim_text(job.entry),
        {frame: places.tolist() for frame, places in corners.items()} if corners else None,
        asdict(claimed.as_built) if claimed.as_built else None, claimed.revoked,
    ]  # fmt: skip
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def claim_text(entry: Entry) -> str:
    """The claim's content: two claims of one badge are one."""
    return entry.claimed.badge.to_json()


def _report(job: Job) -> Report:
    entry = job.entry
    badge = entry.claimed.badge
    if job.pipeline == "published":
        return verify_published(entry.video, badge, claimed_id=None, corners=entry.corners)
    return verify(
        entry.video, badge, claimed_id=badge.id, as_built=entry.claimed.as_built, revoked=entry.claimed.revoked,
        corners=entry.corners,
    )  # fmt: skip
