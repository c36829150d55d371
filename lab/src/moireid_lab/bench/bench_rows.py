"""Rows of a bench, one for each job; made by the engine of collections, kept between runs."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from moireid.errors import SpecError
from moireid.result_cache import keep_row, kept_rows
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import Limits, LostJob
from moireid_lab.bench.part import Asked, Row
from moireid_lab.bench.sources import is_older, judged

#: Of one film; the longest of any suite takes some minutes, and renderers hold more than a verifier does.
LIMITS = Limits(seconds=7200.0, memory_mb=8192)


@dataclass(frozen=True)
class Where:
    """Where films are made and read, as `archive.engine.run_tasks` takes it."""

    scheduler: str | None = None
    workers: int | None = None


def chosen_names(names: Sequence[str], only: str | None) -> list[str]:
    """The names that hold the regular expression `only`; all without one.  Raises: SpecError where none is left."""
    try:
        chosen = [name for name in names if only is None or re.search(only, name)]
    except re.error as error:
        raise SpecError(f"--only {only!r} is no regular expression ({error}); give a part of a case's name") from error
    if not chosen:
        raise SpecError(f"no case's name holds {only!r}; leave out --only to see all names in the table")
    return chosen


def make_rows(
    jobs: Mapping[str, tuple[str, str, Asked, Path]],
    *,
    kept: Path | None,
    where: Where,
    progress: Callable[[int, int], None],
    stop: Callable[[], bool] = lambda: False,
) -> tuple[dict[str, Row], list[str]]:
    """The rows that are kept and those that are made now, by key, and why other jobs gave none.

    Parameters: jobs: of `sources.judged`, by the keys of their rows; kept: a file that rows are added to, and the lists
        of files that they depend on, each once by its version; stop: whether no further job is begun.
    """
    lines, lost = kept_rows(kept), list[str]()
    found = {key: lines[key] for key in jobs if key in lines}
    rows = {key: row for key, row in found.items() if not is_older(row | lines.get(row["version"], {"files": []}))}
    todo = [key for key in jobs if key not in rows]
    # A process of its own has loaded what the part needs and nothing else.
    tasks = [Task((jobs[key],), name=jobs[key][0]) for key in todo]
    running = run_tasks(judged, tasks, scheduler=where.scheduler, workers=where.workers, limits=LIMITS, stop=stop)
    with closing(running) as ended:
        for count, (place, done) in enumerate(ended, start=len(rows) + 1):
            key, (row,) = todo[place], done.outcomes
            if isinstance(row, LostJob):
                lost.append(f"{key}: {row.why}")
            else:
                files = {"files": row.pop("files")}
                if row["version"] not in lines:
                    lines[row["version"]] = files
                    keep_row(kept, row["version"], files)
                rows[key] = row
                keep_row(kept, key, row)
            progress(count, len(jobs))
    return rows, lost
