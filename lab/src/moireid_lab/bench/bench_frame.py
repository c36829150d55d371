"""The frame of every bench: what is asked, which cases, a row for each, a table, a plot, JSON.

A bench is a function that yields rows, one for each film or case, and the format of each column by its name; of a part
of the scoreboard it is made here (`of_part`).  The benches of `moireid lab bench` are listed in `suites`.
"""

from __future__ import annotations

import importlib
import json
import os
import platform
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from moireid import __version__
from moireid.errors import MoireIdError, SpecError
from moireid.files import planned, write_text
from moireid_lab.bench.bench_plots import plot_of
from moireid_lab.bench.bench_rows import Where, chosen_names, make_rows
from moireid_lab.bench.part import Asked, Part
from moireid_lab.bench.part import Row as Row
from moireid_lab.bench.scoreboard import OUTCOMES, counted, described
from moireid_lab.bench.suites import module_of
from moireid_lab.evaluation.plots import write_svg
from moireid_lab.evaluation.text_table import Columns, table_lines


@dataclass(frozen=True)
class Wish:
    """What is asked of a bench.

    clips: films of each case, None for the bench's own number; only: a regular expression in the names of the cases
    wanted; kept: a file in which rows are kept between runs; folder: where films are kept, None: nowhere; data: clips
    by others, for half-real films.
    """

    quick: bool = False
    seed: int = 0
    clips: int | None = None
    only: str | None = None
    kept: Path | None = None
    folder: Path | None = None
    where: Where = field(default_factory=Where)
    progress: Callable[[int, int | None], None] = lambda done, total: None
    data: Path | None = None


def grouped(rows: Iterable[Row], *keys: str) -> dict[Any, list[Row]]:
    """Rows by what they have under these keys: the value of one key, a tuple of several."""
    found: dict[Any, list[Row]] = {}
    for row in rows:
        found.setdefault(row[keys[0]] if len(keys) == 1 else tuple(row[key] for key in keys), []).append(row)
    return found


def table_text(bench: Bench, rows: list[Row]) -> str:
    """The table of a bench's rows, and its notes."""
    notes = list(bench.notes(rows))
    return "\n".join([*table_lines(bench.table(rows), bench.columns), *([""] if notes else []), *notes])


@dataclass(frozen=True)
class Bench:
    """What prints one table.

    rows: of a wish, one for each film or case; columns: of the table; notes: lines below it; table: the table's rows,
    made of those; plot: keys of the table's rows, as `bench_plots.plot_of` takes them; without any, outcomes are drawn
    where the table counts them.
    """

    rows: Callable[[Wish], Iterable[Row]]
    columns: Columns
    notes: Callable[[list[Row]], Iterable[str]] = lambda rows: ()
    table: Callable[[list[Row]], Iterable[Row]] = lambda rows: rows
    plot: Sequence[str] = ()


def bench_of(name: str) -> Bench:
    """A bench by its name."""
    module = importlib.import_module(module_of(name))
    return module.BENCH if hasattr(module, "BENCH") else of_part(name, module.PART)


def of_part(name: str, part: Part) -> Bench:
    """The bench of a part: all its cases, or the first of them; counts by kind, then what was not right."""

    def rows(wish: Wish) -> list[Row]:
        if part.needs_data and wish.data is None:
            raise SpecError(f"{name} draws badges into clips by others; give their folder by --data DIR")
        asked = Asked(wish.clips, wish.data)
        cases = list(part.cases(asked))
        some = cases[: max(part.short, 3)] if wish.quick and wish.only is None else chosen_names(cases, wish.only)
        with tempfile.TemporaryDirectory() as temporary:
            folder = wish.folder or Path(temporary)
            jobs = {f"{name} {wish.clips} {case}": (name, case, asked, folder) for case in some}
            made, lost = make_rows(jobs, kept=wish.kept, where=wish.where, progress=wish.progress)
        if lost:
            raise MoireIdError(f"{len(lost)} cases of the bench gave no figures, first {lost[0]}; the others are kept")
        return [made[key] for key in jobs]

    def table(rows: list[Row]) -> Iterator[Row]:
        for question in part.questions:
            answering = [row for row in rows if question in row["answers"]]
            for kind, own in grouped(answering, "kind").items():
                found = described(own)
                figures = [f"{key} {low:g} to {high:g}" for key, (low, _, high) in found["figures"].items()]
                more = {"why": found["why"], "figures": "; ".join(figures)}
                yield {"question": question, "kind": kind} | counted(own, question) | more
        for row in rows:
            if any(answer[1] or answer[2] for answer in row["answers"].values()):
                yield {"case": row["case"], "verdict": row.get("verdict"), "reasons": row.get("why", [])}

    return Bench(rows, PART_COLUMNS, lambda rows: part.questions.values(), table)


PART_COLUMNS = {"question": "<14", "kind": "<40", "films": ">6"} | {name: f">{len(name) + 2}" for name in OUTCOMES}
PART_COLUMNS |= {"why": "<30", "figures": "<1", "case": "<64", "verdict": "<12", "reasons": "<1"}


def outputs(folder: Path, name: str, bench: Bench) -> list[Path]:
    """The files that a bench writes."""
    drawn = bench.plot or "inconclusive" in bench.columns
    return [folder / f"{name}.json", *([folder / f"{name}.svg"] if drawn else [])]


def document_of(name: str, wish: Wish, rows: list[Row]) -> dict[str, Any]:
    """A bench's rows, with what was asked, the machine and the version."""
    machine = {"processor": platform.machine(), "cores": os.cpu_count(), "python": platform.python_version()}
    asked = {"suite": name, "quick": wish.quick, "seed": wish.seed}
    return {"moireid": __version__, "machine": machine} | asked | {"rows": rows}


def write(folder: Path, name: str, bench: Bench, document: dict[str, Any], *, overwrite: bool) -> list[Path]:
    """Write a bench's JSON and its plot; whole or not at all."""
    paths = outputs(folder, name, bench)
    planned(paths, overwrite=overwrite)
    write_text(paths[0], json.dumps(document, indent=1) + "\n")
    for path in paths[1:]:
        write_svg(plot_of(list(bench.table(document["rows"])), bench.plot), path)
    return paths
