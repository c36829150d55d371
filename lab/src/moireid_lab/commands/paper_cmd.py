"""paper: the experiments of the published paper, and its tables next to ours."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import FiniteRange, FolderPath, echo_lines, friendly, say
from moireid_lab.commands.sharing import scheduler_option, workers_option


@click.command("paper")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder of the rows and the tables.")
@click.option("--hours", type=FiniteRange(0, 1e4), metavar="H", help="Begin no film after so many hours.")
@click.option("--only", metavar="REGEX", help="Only the films whose name holds this regular expression.")
@workers_option
@scheduler_option
@friendly
@click.pass_context
def paper_command(
    context: click.Context,
    folder: Path,
    hours: float | None,
    only: str | None,
    workers: int | None,
    scheduler: str | None,
) -> None:
    """Reproduce the published paper, and print its tables next to ours.

    It films the paper's experiments (Qing et al. 2026) and stand-ins for its recordings and generated films, and scores
    them by its method and by ours. Rows are kept in DIR/rows.jsonl, as `moireid lab scoreboard` keeps them, so a run
    goes on where the last one stopped; DIR/paper.md has the tables of all rows that are there.
    """
    from moireid.files import write_text
    from moireid.result_cache import kept_rows
    from moireid_lab.bench.scoreboard import ROWS
    from moireid_lab.bench.scoreboard_tables import paper_text
    from moireid_lab.commands.scoreboard_cmd import scoreboard_command

    cases = f"^paper .*(?:{only})" if only else "^paper "
    how = {"hours": hours, "only": cases, "workers": workers, "scheduler": scheduler}
    context.invoke(scoreboard_command, folder=folder, short=False, data=None, as_json=False, **how)
    text = paper_text(kept_rows(folder / ROWS).values())
    write_text(folder / "paper.md", text)
    echo_lines(text)
    say(f"written: {folder / 'paper.md'}")
