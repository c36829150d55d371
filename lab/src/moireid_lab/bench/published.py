"""The paper's tables next to ours: films made and scored by both pipelines, the figures of each row, text and plot.

What each row of the paper's tables films, and which of the paper's own figures this project has on record:
the published renderings (Qing et al. 2026) move a camera half a metre along a straight line in two seconds, before two
line layers 1 mm apart in air, at seven distances, on ten courses that differ in small random turns: each is a single
sweep, one way, at constant speed, without noise.  A drift of the fringes, or a delay, is a mere constant on such a
course, so these films show correlation and little more.

What is not on record here, and our reading: rendering 2 films the lens sheet of the prototype where rendering 1 films
the two layers; A to D film the prototype on a measured hand-held run, turned in the picture, from 45 degrees aside and
turning about all axes at once, each for 6 s from 1.2 m.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from moireid.badge import Badge, Cell, Grating, Lens, Markers
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.film_set import PlannedFilm, make_film_set
from moireid_lab.evaluation.collect import ScoredFilm, collect
from moireid_lab.evaluation.film_rows import PIPELINES
from moireid_lab.evaluation.manifest import read_manifest
from moireid_lab.evaluation.summary import PAPER

DISTANCES_M = (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
COURSES = 10
#: One way along the path; `motion.linear` turns back then.
SWEEP: dict[str, Any] = {"motion": "linear", "frames": 120, "fps": 60.0, "camera": "ideal"}
#: The prototype: sheet of 50 lines an inch over lines 0.52 mm apart, and a field of 80 mm.
LENS_PITCH_MM, LINE_PITCH_MM, GAP_MM, FIELD_MM = 0.508, 0.52, 1.0, 80.0


@dataclass(frozen=True)
class Condition:
    """A row of a table: courses before one board from one distance; paper: |rho| as published
    of a condition of that description, where it is on record.

    wish: parameters of `simulate`; the film of a course has the course's number as seed.
    """

    table: str
    what: str
    badge: Badge
    wish: dict[str, Any]
    paper: str = ""

    @property
    def group(self) -> str:
        """Names the row in the list of films."""
        return f"{self.table}, {self.wish['distance_m']:g} m"


def conditions(*, quick: bool) -> Iterator[Condition]:
    """All rows; quick: two distances of each rendering."""
    mask = board(Lens("mask", LENS_PITCH_MM, GAP_MM, 1.0), page_mm=140.0, marker_mm=24.0, corner_mm=14.0)
    prototype = board(Lens("lenticular", LENS_PITCH_MM, GAP_MM, 1.56), page_mm=146.0, marker_mm=26.0, corner_mm=18.0)
    for table, what, badge in (("rendering 1", "two layers", mask), ("rendering 2", "lens sheet", prototype)):
        for distance in DISTANCES_M[::6] if quick else DISTANCES_M:
            wish = SWEEP | {"distance_m": distance}
            yield Condition(table, f"{what}, one sweep", badge, wish)
    for table, what, motion, paper in (
        ("A", "hand-held", "handheld", ""),
        ("B", "turned in the picture", "roll", "0.76 to 0.81"),
        ("C", "from 45 degrees", "oblique", "0.72"),
        ("D", "all turns at once", "tumble", "0.57 to 0.67"),
    ):
        wish = {"motion": motion, "distance_m": 1.2, "frames": 180, "fps": 30.0}
        yield Condition(table, what, prototype, wish, paper)


def board(lens: Lens, *, page_mm: float, marker_mm: float, corner_mm: float) -> Badge:
    """A square board of one uniform field as the published ones are; corner_mm: from an edge to a marker's centre."""
    low = (page_mm - FIELD_MM) / 2
    rect = (low, low, low + FIELD_MM, low + FIELD_MM)
    field = Grating(rect, "x", LINE_PITCH_MM, "uniform", (Cell(rect, LINE_PITCH_MM, low, 0.5),))
    a, b = corner_mm, page_mm - corner_mm
    markers = Markers("DICT_4X4_50", marker_mm, (0, 1, 2, 3), ((a, a), (b, a), (b, b), (a, b)))
    return Badge(None, "Published board", (page_mm, page_mm), lens, (field,), markers)


#: Figures of a film whose mean and deviation over courses are in a row; null ones are left out.
FIGURES = (
    "score",
    "correlation",
    "window_correlation_mean",
    "window_correlation_max",
    "window_correlation_min",
    "window_correlation_sd",
)


def rows(wish: Wish) -> Iterator[Row]:
    """Film, score and sum up; the wish's clips are courses of each condition.

    Films and scores of an earlier run in the folder are kept.  Raises: as `make_film_set` and `collect`.
    """
    courses, progress, where = len(wish.seeds(COURSES, quick=2)), wish.progress, wish.where
    asked = list(conditions(quick=wish.quick))
    films = [one for row in asked for one in _planned(row, courses, wish.seed)]
    with wish.kept_folder() as folder:
        manifest = make_film_set(films, folder / "films", where=where, progress=lambda done, of: progress(done, 2 * of))
        scored = collect(
            read_manifest(manifest).entries,
            PIPELINES,
            kept=folder / "results.jsonl",
            scheduler=where.scheduler,
            workers=where.workers,
            progress=lambda done, of, *_: progress(of + done, 2 * of),
        )
    for row in asked:
        yield _row(row, [one for one in scored if one.entry.group == row.group])


def _planned(row: Condition, courses: int, seed: int) -> list[PlannedFilm]:
    """The films of a row, one a course."""
    name = row.group.replace(", ", "-").replace(" ", "")
    return [
        PlannedFilm(f"{name}-{course}", row.badge, row.wish | {"seed": seed + course}, row.group)
        for course in range(1, courses + 1)
    ]


def _row(row: Condition, scored: Sequence[ScoredFilm]) -> dict[str, Any]:
    """The figures of a row, of each pipeline."""
    about = {"table": row.table, "what": row.what, "distance_m": row.wish["distance_m"], "paper": row.paper}
    return about | {name: _figures([one for one in scored if one.pipeline == name]) for name in PIPELINES}


def _figures(scored: Sequence[ScoredFilm]) -> dict[str, Any]:
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


COLUMNS = {"film": "<24", "greatest": ">15", "mean": ">15", "sd": ">6", "range": ">14", "acc.": ">5"}
COLUMNS |= {"ours: mean": ">15", "acc./inc./rej.": ">14", "paper": "<1"}


def table(rows: list[Row]) -> Iterator[Row]:
    """A line for each condition and distance, both pipelines side by side: |rho| over windows of 30 frames."""
    for row in rows:
        theirs, ours = row["published"], row["moireid"]
        least, most = theirs["window_correlation_min"]["values"], theirs["window_correlation_max"]["values"]
        yield {
            "film": f"{row['table']}, {row['distance_m']:g} m",
            "greatest": _spread(theirs["score"]),
            "mean": _spread(theirs["window_correlation_mean"]),
            "sd": _mean(theirs["window_correlation_sd"]),
            "range": f"{min(least):.2f} to {max(most):.2f}" if least else "-",
            "acc.": _count(theirs, "accept"),
            "ours: mean": _spread(ours["window_correlation_mean"]),
            "acc./inc./rej.": "/".join(str(_count(ours, word)) for word in ("accept", "inconclusive", "reject")),
            "paper": row["paper"],
        }


def notes(rows: list[Row]) -> Iterator[str]:
    """What the conditions are, and the paper's own figures."""
    yield "; ".join(dict.fromkeys(f"{row['table']}: {row['what']}" for row in rows)) + "."
    yield "Renderings are single sweeps at constant speed, on which a drift or a delay is a mere constant."
    left_out = sum(row["published"]["without_score"] for row in rows)
    yield f"Films without a published score (0 in the paper): {left_out}; they are in no mean."
    yield (
        f"The paper: renderings {PAPER['renderings']['mean']:.2f}; real recordings {PAPER['genuine']['mean']:.2f} ± "
        f"{PAPER['genuine']['sd']:.2f}; generated {PAPER['forged']['mean']:.2f} ± {PAPER['forged']['sd']:.2f}; AUC "
        f"{PAPER['auc']}; accepted from {PAPER['threshold']}."
    )


def _spread(cell: Row) -> str:
    return _mean(cell) if cell["sd"] is None else f"{cell['mean']:.3f} ± {cell['sd']:.3f}"


def _mean(cell: Row) -> str:
    return "-" if cell["mean"] is None else f"{cell['mean']:.3f}"


def _count(figures: Row, verdict: str) -> int:
    return int(figures["verdicts"].get(verdict, 0))


BENCH = Bench(rows, COLUMNS, notes, table=table)
