"""The frame of every bench: what is asked, which cases, a row for each, a table, a plot, JSON.

A bench is a function that yields rows, one for each film or case, and the format of each column by its name.  The
benches of `moireid lab bench` are listed in `suites`.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn

from moireid import __version__
from moireid.errors import SpecError
from moireid.files import planned, whole_file, write_text
from moireid.simulate.filming import film
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Scene
from moireid_lab.bench.bench_plots import plot_of
from moireid_lab.bench.bench_rows import Row as Row
from moireid_lab.bench.bench_rows import Where, chosen_names, made_rows
from moireid_lab.evaluation.text_table import Columns, table_lines


def _quiet(done: int, total: int | None) -> None:
    """Report no progress."""


@dataclass(frozen=True)
class Wish:
    """What is asked of a bench.

    clips: films of each case, None for the bench's own number; only: a regular expression in the names of the cases
    wanted; kept: a file in which rows are kept between runs; folder: where films are kept, None: nowhere; own: the
    bench's own options.
    """

    quick: bool = False
    seed: int = 0
    clips: int | None = None
    only: str | None = None
    kept: Path | None = None
    folder: Path | None = None
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
        how = "quick" if self.quick else "usual"
        named = [(f"{how} {self.seed} {name}", job) for name, job in wanted]
        for count, row in enumerate(made_rows(work, named, kept=self.kept, where=self.where), start=1):
            self.progress(count, len(wanted))
            yield row

    def films(self, work: Callable[[Any], Row], names: Iterable[str], frames: int, seeds: range) -> Iterator[Row]:
        """A row for each case that is wanted and each seed; work: of a case's name, a seed, and the frames of its film.

        Convention: film after film of all cases, so that an interrupted run has some of each.
        """
        chosen = self.chosen(names)
        jobs = {f"{name}|{seed}": (name, seed, frames) for seed in seeds for name in chosen}
        return replace(self, only=None).each(work, jobs)

    @contextmanager
    def kept_folder(self) -> Iterator[Path]:
        """The folder in which films are kept, or a temporary one."""
        if self.folder is None:
            with tempfile.TemporaryDirectory() as name:
                yield Path(name)
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        yield self.folder


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


def table_text(bench: Bench, rows: list[Row]) -> str:
    """The table of a bench's rows, and its notes."""
    notes = list(bench.notes(rows))
    return "\n".join([*table_lines(bench.table(rows), bench.columns), *([""] if notes else []), *notes])


class _Options(argparse.ArgumentParser):
    """The parser of a bench's own options."""

    def error(self, message: str) -> NoReturn:
        """Raises: SpecError."""
        own = ", ".join(flag for action in self._actions for flag in action.option_strings) or "none"
        raise SpecError(f"{self.prog}: {message}; options of its own: {own}")


@dataclass(frozen=True)
class Bench:
    """What prints one table.

    rows: of a wish, one for each film or case; columns: of the table; notes: lines below it; options: of this bench
    alone, by flag; table: the table's rows, made of those; plot: keys of the table's rows, as `bench_plots.plot_of`
    takes them; without any, verdicts are drawn where the table counts them.
    """

    rows: Callable[[Wish], Iterable[Row]]
    columns: Columns
    notes: Callable[[list[Row]], Iterable[str]] = lambda rows: ()
    options: Mapping[str, dict[str, Any]] = field(default_factory=dict)
    table: Callable[[list[Row]], Iterable[Row]] = lambda rows: rows
    plot: Sequence[str] = ()

    def parsed(self, name: str, words: Sequence[str]) -> argparse.Namespace:
        """The bench's own options.  Raises: SpecError where it has no such option."""
        parser = _Options(prog=name, allow_abbrev=False, add_help=False)
        for flag, how in self.options.items():
            parser.add_argument(flag, **how)
        return parser.parse_args(list(words))


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
        with whole_file(path) as temporary:
            figure = plot_of(list(bench.table(document["rows"])), list(bench.columns), bench.plot)
            figure.savefig(temporary, format="svg", metadata={"Date": None})
    return paths
