"""All rows of a collection, each saved when it is made, so that an interrupted run can be continued."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import msgspec

from moireid.errors import MediaError, SpecError
from moireid.reading.answers import checked
from moireid.result_cache import keep_row, kept_rows
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import Limits, LostJob
from moireid_lab.evaluation.film_rows import (
    Job,
    Pipeline,
    Row,
    ScoredRow,
    claim_digest,
    failed_row,
    row_key,
    score_film,
    scorer,
)
from moireid_lab.evaluation.manifest import Entry

#: Called with the number of films done, in all, failed, and reused from an earlier run.
Progress = Callable[[int, int, int, int], None]


@dataclass(frozen=True)
class ScoredFilm:
    """A film of the collection, with its row from one pipeline."""

    entry: Entry
    pipeline: Pipeline
    row: Row


def collect(
    entries: Sequence[Entry],
    pipelines: Sequence[Pipeline],
    *,
    kept: Path,
    scheduler: str | None = None,
    workers: int | None = None,
    limits: Limits | None = None,
    retry: bool = False,
    progress: Progress | None = None,
    work: Callable[[Job, str], Row] = score_film,
) -> list[ScoredFilm]:
    """Score every film by every pipeline.

    Parameters: kept: a file of JSON lines to which rows are added as they are made.  Its rows are reused, except those
        with a temporary fault; with `retry`, except those with any fault other than an unreadable film. scheduler,
        workers, limits: as in `archive.engine.run_tasks`; limits hold for one film with one pipeline. work: a function
        at the top of a module that makes a row from a job and the film's path.
        Raises: SpecError if one film is listed twice with one claim: for one address before any film is scored, for one
            content at two addresses after all are scored; the rows are kept.
    """
    _refuse_pairs((entry, entry.video) for entry in entries)
    jobs = {row_key(Job(entry, name)): Job(entry, name) for entry in entries for name in pipelines}
    rows = {key: row for key, row in kept_rows(kept).items() if key in jobs and not _lost(row, retry=retry)}
    todo: dict[int, list[str]] = {}
    for key, job in jobs.items():
        if key not in rows:
            todo.setdefault(job.entry.line, []).append(key)
    tasks = [Task(tuple(jobs[key] for key in keys), jobs[keys[0]].entry.video) for keys in todo.values()]
    keys_of, before, failed = list(todo.values()), len(entries) - len(todo), 0
    running = run_tasks(work, tasks, scheduler=scheduler, workers=workers, limits=limits)
    with closing(running) as outcomes:
        for count, (place, done) in enumerate(outcomes, start=1):
            made = [
                _row(key, jobs[key], outcome, done.worker)
                for key, outcome in zip(keys_of[place], done.outcomes, strict=True)
            ]
            for row in made:
                keep_row(kept, row["key"], row)
            rows |= {row["key"]: row for row in made}
            failed += any(row["verdict"] == "failed" for row in made)
            if progress:
                progress(before + count, len(entries), failed, before)
    _refuse_pairs((one.entry, rows[key]["sha256"]) for key, one in jobs.items() if one.pipeline == pipelines[0])
    return [ScoredFilm(job.entry, job.pipeline, rows[key]) for key, job in jobs.items()]


def _row(key: str, job: Job, outcome: Row | LostJob, worker: str) -> Row:
    """The outcome of a job as a row of the results.

    The process that scored is in the hands of its film: what is no row counts as a film that ended it.
    """
    try:
        row = failed_row(outcome) if isinstance(outcome, LostJob) else checked(outcome, ScoredRow, job.entry.video)
        row = row if isinstance(row, dict) else msgspec.structs.asdict(row)
    except MediaError as error:
        row = failed_row(LostJob(str(error), 0.0, "crash"))
    named = {"key": key, "film": job.entry.video, "claim": claim_digest(job.entry), "pipeline": job.pipeline}
    return named | {"program": scorer()} | row | {"worker": worker}


def _lost(row: Row, *, retry: bool) -> bool:
    """Whether this run makes a row again."""
    return bool(row["again"] or (retry and row["fault"] not in (None, "film")))


def _refuse_pairs(films: Iterable[tuple[Entry, str | None]]) -> None:
    """Raise if two lines list one film with one claim; films: pairs of line and what identifies the film."""
    listed: dict[tuple[str, str], Entry] = {}
    for entry, film in films:
        same = listed.setdefault((film, claim_digest(entry)), entry) if film else entry
        if same is not entry:
            raise SpecError(
                f"lines {same.line} and {entry.line} list one film with one claim ({same.name[:60]!r} and "
                f"{entry.name[:60]!r}), which would count twice; leave one of them out, and what is scored is kept"
            )
