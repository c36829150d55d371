"""Rows of a suite, one for each film that it makes and reads; made by the engine of collections, kept between runs."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from moireid.errors import MoireIdError, SpecError
from moireid.result_cache import keep_row, kept_rows
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import Limits, LostJob

Row = dict[str, Any]
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


def rows_of_cases(
    work: Callable[[Any], Row],
    names: Sequence[str],
    numbers: range,
    frames: int,
    *,
    kept: Path | None,
    where: Where,
    progress: Callable[[int, int | None], None],
) -> list[Row]:
    """One row for each case and seed; work: of a case's name, a seed, and the frames of its film.

    Convention: film after film of all cases, so that an interrupted run has some of each.  Otherwise as `made_rows`.
    """
    jobs = [(f"{name}|{number}", (name, number, frames)) for number in numbers for name in names]
    done = itertools.count(1)
    return made_rows(work, jobs, kept=kept, where=where, step=lambda: progress(next(done), len(jobs)))


def made_rows(
    work: Callable[[Any], Row],
    jobs: Sequence[tuple[str, Any]],
    *,
    kept: Path | None,
    where: Where,
    step: Callable[[], None],
) -> list[Row]:
    """One row a job, in their order.

    Parameters: work: a function at the top of a module; jobs: (key, what the work is done with), where the key names
        all that the row depends on; kept: a file that rows are added to, those in it are not made again; step: called
        as each row is there.
    Raises: MoireIdError where a job gave no row; the others of the run so far are kept.
    """
    rows = kept_rows(kept)
    todo = [(key, job) for key, job in jobs if key not in rows]
    for _ in range(len(jobs) - len(todo)):
        step()
    running = run_tasks(
        work, [Task((job,)) for _, job in todo], scheduler=where.scheduler, workers=where.workers, limits=LIMITS
    )
    with closing(running) as ended:
        for place, done in ended:
            key, (row,) = todo[place][0], done.outcomes
            if isinstance(row, LostJob):
                raise MoireIdError(f"a film of the suite gave no figures: {row.why}; run again, the others are kept")
            rows[key] = row
            keep_row(kept, key, row)
            step()
    return [rows[key] for key, _ in jobs]
