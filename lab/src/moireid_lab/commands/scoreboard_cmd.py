"""scoreboard: every question that the project's figures answer, on this version of the sources."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import FiniteRange, FolderPath, echo_lines, friendly, json_option, progress_bar, say, show_json
from moireid_lab.commands.sharing import data_option, scheduler_option, workers_option


@click.command("scoreboard")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder of the rows and the scoreboard.")
@click.option("--hours", type=FiniteRange(0, 1e4), metavar="H", help="Begin no case after so many hours.")
@click.option("--short", is_flag=True, help="A few cases of some parts: minutes instead of hours.")
@click.option("--only", metavar="REGEX", help="Only the cases whose part and name hold this regular expression.")
@data_option
@workers_option
@scheduler_option
@json_option
@friendly
def scoreboard_command(
    folder: Path,
    hours: float | None,
    short: bool,
    only: str | None,
    data: Path | None,
    workers: int | None,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """Answer every question of the scoreboard on this version.

    Each film or case is a row of DIR/rows.jsonl. Rows whose sources have not changed are kept, so a run goes on where
    the last one stopped. Parts take turns of some cases, so with --hours each has its share of the time. A case that
    fails is named, and the others go on. DIR/scoreboard.json has an answer to each question; one of older sources has
    its date. `make docs` writes the tables of README and docs/accuracy.md from the rows in benchmarks/scoreboard.
    """
    import json
    import tempfile

    from moireid.errors import MoireIdError
    from moireid.files import write_text
    from moireid_lab.bench.bench_rows import Where, chosen_names
    from moireid_lab.bench.part import Asked
    from moireid_lab.bench.scoreboard import DOCUMENT, ROWS, document_of, newest_rows, plan, run, tidy
    from moireid_lab.evaluation.text_table import table_lines

    folder.mkdir(parents=True, exist_ok=True)
    asked, where = Asked(data=data), Where(scheduler, workers)
    every = plan(asked)
    wanted = plan(asked, short=True) if short else every
    cases = {key: wanted[key] for key in chosen_names(list(wanted), only)}
    with progress_bar("cases") as progress, tempfile.TemporaryDirectory() as films:
        lost = run(cases, asked, folder / ROWS, Path(films), where=where, hours=hours, progress=progress)
    tidy(every, folder / ROWS)
    document = document_of(every, newest_rows(every, folder / ROWS)) | {"failed": lost}
    write_text(folder / DOCUMENT, json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    say(f"written: {folder / DOCUMENT}")
    if as_json:
        show_json(document)
    else:
        echo_lines("\n".join(table_lines(document["questions"], COLUMNS)))
    for case in lost:
        say(f"failed: {case}")
    if lost:
        raise MoireIdError(f"{len(lost)} cases gave no row; run again, the others are kept")


COLUMNS = {"part": "<14", "question": "<10", "films": ">6", "right": ">6", "inconclusive": ">13", "wrong": ">6"}
COLUMNS |= {"version": "<12", "date": "<10"}
