"""paper: the experiments of the published paper, and its tables next to ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from moireid.cli.common import echo_lines, friendly, say
from moireid_lab.commands.scoreboard_cmd import scoreboard_command

#: Options of the scoreboard that serve here too.
SHARED = ("folder", "hours", "only", "workers", "scheduler")


@friendly
def reproduce(context: click.Context, *, folder: Path, only: str | None, **how: Any) -> None:
    """Reproduce the published paper, next to ours.

    It films the paper's experiments (Qing et al. 2026) and stand-ins for its recordings and generated films, and scores
    them by its method and by ours. Rows are kept in DIR/rows.jsonl, as `moireid lab scoreboard` keeps them, so a run
    goes on where the last one stopped; DIR/paper.md has the tables of all rows that are there.
    """
    from moireid.files import write_text
    from moireid_lab.bench.scoreboard import ROWS
    from moireid_lab.bench.scoreboard_tables import paper_text

    context.invoke(scoreboard_command, folder=folder, only=f"^paper .*(?:{only or ''})", **how)
    text = paper_text(folder / ROWS)
    write_text(folder / "paper.md", text)
    echo_lines(text)
    say(f"written: {folder / 'paper.md'}")


paper_command = click.command("paper", params=[one for one in scoreboard_command.params if one.name in SHARED])(
    click.pass_context(reproduce)
)
