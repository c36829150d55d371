"""The films of the tables made and scored by both pipelines, and the figures of each row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from moireid_lab.bench.film_set import Planned, make_film_set
from moireid_lab.bench.published.conditions import COURSES, Condition, conditions
from moireid_lab.bench.rows import Where
from moireid_lab.evaluation.collect import Scored, collect
from moireid_lab.evaluation.manifest import read_manifest
from moireid_lab.evaluation.rows import PIPELINES
from moireid_lab.evaluation.summary import PAPER

#: Figures of a film whose mean and deviation over courses a row tells; null ones are passed over.
FIGURES = (
    "score",
    "correlation",
    "window_correlation_mean",
    "window_correlation_max",
    "window_correlation_min",
    "window_correlation_sd",
)


def run(
    *,
    quick: bool,
    seed: int,
    folder: Path,
    overwrite: bool,
    where: Where,
    clips: int | None,
    progress: Callable[[int, int | None], None],
) -> dict[str, Any]:
    """Film, score and sum up; clips: courses of each condition.

    Films and scores of an earlier run in the folder are kept.  Raises: as `make_film_set` and `collect`.
    """
    courses = clips or (2 if quick else COURSES)
    rows = list(conditions(quick=quick))
    films = [one for row in rows for one in _planned(row, courses, seed)]
    manifest = make_film_set(
        films,
        folder / "films",
        where=where,
        overwrite=overwrite,
        progress=lambda done, of, *_: progress(done, 2 * of),
    )
    scored = collect(
        read_manifest(manifest).entries,
        PIPELINES,
        kept=folder / "results",
        scheduler=where.scheduler,
        workers=where.workers,
        progress=lambda done, of, *_: progress(of + done, 2 * of),
    )
    return {
        "suite": "published",
        "quick": quick,
        "seed": seed,
        "courses": courses,
        "paper": PAPER,
        "rows": [_row(row, [one for one in scored if one.entry.group == row.group]) for row in rows],
    }


def _planned(row: Condition, courses: int, seed: int) -> list[Planned]:
    """The films of a row, one a course."""
    name = row.group.replace(", ", "-").replace(" ", "")
    return [
        Planned(f"{name}-{course}", row.badge, replace(row.wish, seed=seed + course), row.group)
        for course in range(1, courses + 1)
    ]


def _row(row: Condition, scored: Sequence[Scored]) -> dict[str, Any]:
    """The figures of a row, of each pipeline."""
    told = {"table": row.table, "what": row.what, "distance_m": row.wish.distance_m, "paper": row.paper}
    return told | {name: _figures([one for one in scored if one.pipeline == name]) for name in PIPELINES}


def _figures(scored: Sequence[Scored]) -> dict[str, Any]:
    """Verdicts, and of each figure the values of all films with their mean and deviation."""
    verdicts = [one.row["verdict"] for one in scored]
    found: dict[str, Any] = {"films": len(scored), "verdicts": {name: verdicts.count(name) for name in set(verdicts)}}
    found["without_score"] = sum(one.row["score"] is None for one in scored)
    for name in FIGURES:
        values = np.array([one.row[name] for one in scored if one.row[name] is not None], float)
        found[name] = {
            "values": values.tolist(),
            "mean": float(values.mean()) if len(values) else None,
            "sd": float(values.std(ddof=1)) if len(values) > 1 else None,
        }
    return found
