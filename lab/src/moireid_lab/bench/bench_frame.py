"""The frame of every bench: what is asked, which cases, rows that come one by one, a table, JSON and CSV.

A bench is a function that yields rows, and the format of each column by its name.  The suites of `moireid bench` and
the scripts of `benchmarks/` are benches; a script ends with `run_script(__file__)`.
"""

from __future__ import annotations

import argparse
import csv
import importlib
import json
import os
import platform
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import reduce
from pathlib import Path
from typing import Any

import click

from moireid.errors import MoireIdError
from moireid.simulate.filming import film
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Scene
from moireid_lab.bench.bench_rows import Row, Where, chosen_names, made_rows

#: Format of each column by its heading: `<` or `>`, the width, and Python's format of its values; before it, where the
#: rows have it under another key than the heading, that key and a space (`fine.image >8.2%`: of an object in the row).
Columns = Mapping[str, str]


def _quiet(done: int, total: int | None) -> None:
    """Report no progress."""


@dataclass(frozen=True)
class Wish:
    """What is asked of a bench.

    clips: films of each case, None for the bench's own number; only: a regular expression in the names of the cases
    wanted; kept: a file in which rows are kept between runs; folder: where films may be kept; own: a script's options.
    """

    quick: bool = False
    seed: int = 0
    clips: int | None = None
    only: str | None = None
    kept: Path | None = None
    folder: Path | None = None
    overwrite: bool = False
    where: Where = field(default_factory=Where)
    progress: Callable[[int, int | None], None] = _quiet
    own: argparse.Namespace = field(default_factory=argparse.Namespace)

    def seeds(self, usual: int, quick: int = 1) -> range:
        """A seed for each film of a case; usual, quick: how many where the number is not asked for."""
        return range(self.seed, self.seed + (self.clips or (quick if self.quick else usual)))

    def chosen(self, names: Iterable[str]) -> list[str]:
        """The names that are wanted.  Raises: SpecError where none is."""
        return chosen_names(list(names), self.only)

    def each(self, work: Callable[[Any], Row], jobs: Mapping[str, Any]) -> Iterator[Row]:
        """A row of each job, by name, in their order, made by the engine of collections; kept ones are not made again.

        work: a function at the top of a module.  Raises: SpecError where no name is wanted.
        """
        wanted = [(name, jobs[name]) for name in self.chosen(jobs)]
        for count, row in enumerate(made_rows(work, wanted, kept=self.kept, where=self.where), start=1):
            self.progress(count, len(wanted))
            yield row

    @contextmanager
    def kept_folder(self) -> Iterator[Path]:
        """The folder in which films are kept, or a temporary one."""
        if self.folder is None:
            with tempfile.TemporaryDirectory() as name:
                yield Path(name)
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        yield self.folder


def film_cases(work: Callable[[Any], Row], names: Sequence[str], frames: int, seeds: range, wish: Wish) -> list[Row]:
    """One row for each case that is wanted and each seed; work: of a case's name, a seed, and the frames of its film.

    Convention: film after film of all cases, so that an interrupted run has some of each.
    """
    jobs = [(f"{name}|{seed}", (name, seed, frames)) for seed in seeds for name in wish.chosen(names)]
    rows = []
    for row in made_rows(work, jobs, kept=wish.kept, where=wish.where):
        rows.append(row)
        wish.progress(len(rows), len(jobs))
    return rows


@contextmanager
def temporary_film(scene: Scene, motion: Motion, **how: Any) -> Iterator[Path]:
    """A film that is gone afterwards; how: as `simulate.filming.film`."""
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        film(scene, motion, video, **how)
        yield video


def counted_verdicts(rows: Sequence[Row], reasons: int = 3) -> Row:
    """How many rows have each verdict, and the most frequent reasons of those that were not accepted."""
    counts = Counter(row["verdict"] for row in rows)
    why = Counter(code for row in rows for code in row["why"]).most_common(reasons)
    verdicts = {name: counts[name] for name in ("accept", "inconclusive", "reject")}
    return verdicts | {"reasons": ", ".join(code for code, _ in why)}


def grouped(rows: Iterable[Row], *keys: str) -> dict[Any, list[Row]]:
    """Rows by what they have under these keys: the value of one key, a tuple of several."""
    found: dict[Any, list[Row]] = {}
    for row in rows:
        found.setdefault(row[keys[0]] if len(keys) == 1 else tuple(row[key] for key in keys), []).append(row)
    return found


def table_lines(rows: Iterable[Row], columns: Columns) -> Iterator[str]:
    """Rows as text, each as it comes.

    Convention: a row shows what it has of the columns, in their order; where that differs from the row before, a new
    table begins.  None is a dash.
    """
    shown: list[str] | None = None
    for row in rows:
        names = [name for name, spec in columns.items() if _key(name, spec)[0] in row]
        if names != shown:
            yield from ([] if shown is None else [""])
            yield _line((name, columns[name]) for name in names)
            shown = names
        yield _line((_text(_value(row, _key(name, columns[name])), columns[name]), columns[name]) for name in names)


def text_table(rows: Iterable[Row], columns: Columns) -> str:
    """All rows as text."""
    return "\n".join(table_lines(rows, columns))


def _key(name: str, spec: str) -> list[str]:
    """Where a row has the value of a column."""
    return spec.rpartition(" ")[0].split(".") if " " in spec else [name]


def _value(row: Row, key: list[str]) -> Any:
    return reduce(lambda part, name: part[name], key, row)


def _line(cells: Iterable[tuple[str, str]]) -> str:
    """Texts with the formats of their columns, each as wide as its column, a space apart."""
    sides = [(text, *re.split(r"(?<=[<>])(\d+)", spec.rpartition(" ")[2])[:2]) for text, spec in cells]
    return " ".join(f"{text:{side}{width}}" for text, side, width in sides).rstrip()


def _text(value: Any, spec: str) -> str:
    if value is None:
        return "-"
    if isinstance(value, (list, tuple)):
        return " ".join(map(str, value))
    return format(value, "" if isinstance(value, str) else re.sub(r".*[<>]\d+", "", spec))


@dataclass(frozen=True)
class Bench:
    """rows: of a wish; notes: lines below the table; options: of a script, beyond those that all have, by flag."""

    rows: Callable[[Wish], Iterable[Row]]
    columns: Columns
    notes: Callable[[list[Row]], Iterable[str]] = lambda rows: ()
    options: Mapping[str, dict[str, Any]] = field(default_factory=dict)


def run_script(file: str) -> None:
    """Run the bench of a script.  It is imported by its name, as other processes know it."""
    folder = Path(file).parent
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    module = importlib.import_module(Path(file).stem)
    try:
        run_bench(module.BENCH, module.__doc__ or "", sys.argv[1:])
    except MoireIdError as error:
        raise SystemExit(str(error)) from error


def run_bench(bench: Bench, words: str, arguments: list[str]) -> list[Row]:
    """Read the options, and print each row as it comes, the notes, and with `--json` the rows alone."""
    given = _parser(bench, words).parse_args(arguments)
    click.echo(
        f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, Python "
        f"{platform.python_version()}",
        err=True,
    )
    wish = Wish(
        quick=given.quick,
        seed=given.seed,
        clips=given.clips,
        only=given.only,
        kept=given.kept,
        folder=given.keep,
        where=Where(given.scheduler, given.workers),
        progress=lambda done, total: click.echo(f"{done} of {total}", err=True),
        own=given,
    )
    rows: list[Row] = []

    def passing() -> Iterator[Row]:
        for row in bench.rows(wish):
            rows.append(row)
            yield row

    for line in table_lines(passing(), bench.columns):
        click.echo(line, err=given.json)
    if given.csv:
        write_csv(rows, given.csv)
    if given.json:
        click.echo(json.dumps(rows, indent=1))
    for line in bench.notes(rows):
        click.echo(line, err=given.json)
    return rows


def _parser(bench: Bench, words: str) -> argparse.ArgumentParser:
    """The options of every bench, and its own."""
    parser = argparse.ArgumentParser(description=words, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="REGEX", help="only the cases whose name holds this")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--quick", action="store_true", help="fewer or smaller cases")
    parser.add_argument("--clips", "--films", type=int, metavar="N", help="films, or repetitions, of each case")
    parser.add_argument("--workers", type=int, metavar="N", help="films at a time; default: one for each processor")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of Dask, in place of this machine's processors")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep films there, and use those that are there")
    parser.add_argument("--kept", type=Path, metavar="FILE", help="add rows to this file, and make none of them again")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON, and the table to stderr")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the rows")
    for flag, how in bench.options.items():
        parser.add_argument(flag, **how)
    return parser


def write_csv(rows: list[Row], path: Path) -> None:
    """Rows as CSV, with a column for each key."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(dict.fromkeys(name for row in rows for name in row)))
        writer.writeheader()
        writer.writerows(rows)
