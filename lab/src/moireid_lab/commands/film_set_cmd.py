"""film-set: many films at once from a plan, as a collection with labels that `evaluate` reads."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import FolderPath, echo, friendly, json_option, overwrite_option, progress_bar, show_json
from moireid.cli.simulate_cmd import simulate_command
from moireid.files import MOST_TABLE_BYTES, read_regular
from moireid_lab.commands.sharing import scheduler_option, workers_option

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid_lab.bench.film_set import PlannedFilm

#: Columns that are no option of `simulate`; every long option of it but these is a column too.
OWN, NOT_COLUMNS = ("badge", "name", "group"), ("out", "overwrite", "json", "explain", "help")
#: Bytes; files are named by it with some letters more, and mostly 255 are allowed.
LONGEST_NAME = 200
EXAMPLE = "begin the plan with a line such as badge,motion,distance,forge"


@click.command("film-set")
@click.argument("plan_csv", metavar="PLAN", type=click.Path(path_type=Path))
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the films.")
@workers_option
@scheduler_option
@overwrite_option
@json_option
@friendly
def film_set_command(
    plan_csv: Path, folder: Path, workers: int | None, scheduler: str | None, overwrite: bool, as_json: bool
) -> None:
    """Simulate many films, real and forged, from a plan.

    PLAN is a CSV file with a line for each film. The column badge is needed: the path of a badge.json, relative to the
    plan. Every other column is an option of `moireid simulate`, such as motion, distance, forge or seed. An empty cell
    takes the option's default. The column name is the film's file name without .mp4 (default:
    its number), and the column group is copied into films.csv.

    `moireid lab evaluate DIR/films.csv` then scores the films. A run that was interrupted goes on where it stopped, and
    does not make films again that are already there.
    """
    from moireid_lab.bench.bench_rows import Where
    from moireid_lab.bench.film_set import make_film_set

    films = read_plan(plan_csv)
    with progress_bar("films") as progress:
        manifest = make_film_set(films, folder, where=Where(scheduler, workers), overwrite=overwrite, progress=progress)
    if as_json:
        show_json({"films": len(films), "manifest": str(manifest)})
    else:
        echo(f"{len(films)} films in {folder}; score them with: moireid lab evaluate {manifest} --out scored")


def read_plan(plan_csv: Path) -> list[PlannedFilm]:
    """The films of a plan, each checked before any is made.

    Raises: SpecError, with the line of what cannot be used.
    """
    from moireid.errors import MoireIdError, SpecError
    from moireid_lab.evaluation.csv_lists import read_list

    header, rows = read_list(plan_csv, "plan", ("badge",), EXAMPLE)
    allowed = (*OWN, *_options())
    if unknown := [name for name in header if name not in allowed]:
        raise SpecError(f"plan {plan_csv} has a column {unknown[0][:40]!r}; its columns are {', '.join(allowed)}")
    badges: dict[Path, Badge] = {}
    films: list[PlannedFilm] = []
    for line, cells in rows:
        row = {name: cell for name, cell in cells.items() if cell}
        try:
            films.append(_film(row, len(films) + 1, plan_csv.parent, badges))
        except MoireIdError as error:
            raise SpecError(f"line {line} of {plan_csv}: {error}") from error
        except click.UsageError as error:
            raise SpecError(f"line {line} of {plan_csv}: {error.format_message()}") from error
    if not films:
        raise SpecError(f"plan {plan_csv} names no film; {EXAMPLE}, and a line for each film")
    (name, count), *_ = Counter(film.name.casefold() for film in films).most_common(1)
    if count > 1:
        raise SpecError(f"{plan_csv} names {count} films {name!r}; give each its own name, or none")
    return films


def _options() -> dict[str, click.Option]:
    """The options of `simulate` that are columns."""
    found = {
        name.lstrip("-"): one
        for one in simulate_command.params
        if isinstance(one, click.Option)
        for name in one.opts
        if name.startswith("--")
    }
    return {name: one for name, one in found.items() if name not in NOT_COLUMNS}


def _film(row: dict[str, str], number: int, base: Path, badges: dict[Path, Badge]) -> PlannedFilm:
    """One line.  Raises: SpecError, click.UsageError."""
    from moireid.badge import load_badge
    from moireid.errors import SpecError
    from moireid_lab.bench.film_set import PlannedFilm

    if "badge" not in row:
        raise SpecError("it names no badge; give the path of a badge.json, relative to the plan")
    path = base / row["badge"]
    badges[path] = badges.get(path) or load_badge(path)
    name = row.get("name", f"{number:04d}")
    if (
        Path(name).name != name
        or name.startswith(".")
        or "::" in name
        or not name.isprintable()
        or len(name.encode()) > LONGEST_NAME
    ):
        raise SpecError(f"{name[:40]!r} is no name for a file; use a few letters, figures, - and _")
    # The command's own parser reads the cells, so that a column has the same values and errors as its option.
    context = simulate_command.make_context("simulate", [str(path), "--out", "film.mp4", *_words(row)])
    wish = {key: value for key, value in context.params.items() if key not in TAKEN}
    course = None
    motion = wish["motion"]
    if motion.lower().endswith(".csv"):
        try:
            course = read_regular(base / motion, MOST_TABLE_BYTES)
        except OSError as error:
            raise SpecError(
                f"motion {motion} cannot be read ({error.strerror}); give its path from the plan"
            ) from error
    return PlannedFilm(name, badges[path], wish, row.get("group", ""), course)


#: Parameters of the command that do not describe the film.
TAKEN = ("badge_json", "video", "overwrite", "as_json", "explain")


def _words(row: dict[str, str]) -> list[str]:
    """A line as the words of a command."""
    words: list[str] = []
    for name, option in _options().items():
        # A cell may begin with a dash without being an option.
        if name in row:
            words += [f"--{name}={cell}" for cell in (row[name].split() if option.multiple else [row[name]])]
    return words
