"""Every row of a collection, kept as it is made, so that a run that was broken off goes on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from moireid.errors import SpecError
from moireid.evaluation.manifest import Entry
from moireid.evaluation.rows import Job, Pipeline, Row, claim_text, failed_row, row_key, score_film
from moireid.evaluation.workers import Lost, run_jobs
from moireid.kept import keep_row, kept_rows
from moireid.verifier.video import file_sha256

Progress = Callable[[int, int | None], None]


@dataclass(frozen=True)
class Scored:
    """A film of the collection with its row by one pipeline."""

    entry: Entry
    pipeline: Pipeline
    sha256: str
    row: Row


def collect(
    entries: Sequence[Entry], pipelines: Sequence[Pipeline], *, kept: Path | None, workers: int = 1,
    timeout_s: float = 3600.0, progress: Progress | None = None, work: Callable[[Job], Row] = score_film,
) -> list[Scored]:  # fmt: skip
    """Score every film by every pipeline.

    Parameters: kept: a file that rows are added to as they are made; those in it already are not made again, unless
        the film crashed or was stopped. work: what makes a row, a function at the top of a module.
    Raises: SpecError where one film is listed twice with one claim, before any is scored.
    """
    digests = _digests(entries)
    jobs = [Job(entry, pipeline) for entry in entries for pipeline in pipelines]
    keys = [row_key(job, digests[job.entry.line]) for job in jobs]
    rows = {key: row for key, row in kept_rows(kept).items() if key in set(keys) and not row.get("again")}
    todo = [(key, job) for key, job in zip(keys, jobs, strict=True) if key not in rows]
    with closing(run_jobs(work, [job for _, job in todo], workers=workers, timeout_s=timeout_s)) as outcomes:
        for place, outcome in outcomes:
            key = todo[place][0]
            row = failed_row(outcome.why, outcome.seconds, again=True) if isinstance(outcome, Lost) else outcome
            rows[key] = row
            keep_row(kept, key, row)
            if progress:
                progress(len(rows), len(jobs))
    return [
        Scored(job.entry, job.pipeline, digests[job.entry.line], rows[key])
        for key, job in zip(keys, jobs, strict=True)
    ]  # fmt: skip


def _digests(entries: Sequence[Entry]) -> dict[int, str]:
    """SHA-256 of each film by the line it is listed in.  Raises: SpecError where a film is listed twice."""
    digests: dict[int, str] = {}
    listed: dict[tuple[str, str], Entry] = {}
    for entry in entries:
        digests[entry.line] = file_sha256(entry.video)
        same = listed.setdefault((digests[entry.line], claim_text(entry)), entry)
        if same is not entry:
            raise SpecError(
                f"lines {same.line} and {entry.line} list one film with one claim ({same.name[:60]!r} and "
                f"{entry.name[:60]!r}), which would count twice; leave one of them out"
            )
    return digests
