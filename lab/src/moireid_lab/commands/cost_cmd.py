"""cost: the processor time of what people wait for, over that of bare packages on the same machine, and its memory."""

from __future__ import annotations

import tempfile
from pathlib import Path

import click

from moireid.cli.common import echo, friendly, json_option, show_json, status_line

COLUMNS = {"work": "<26", "s": ">7.2f", "limit": "<22", "limit s": "limit_s >7.2f", "ratio": ">6.2f"}
COLUMNS |= {"asked": ">6.2f", "MB": ">6.0f", "of 250 MB": "of_most >9.2f"}


@click.command("cost")
@click.option("--runs", type=click.IntRange(1), default=3, show_default=True, help="Runs of each; the least counts.")
@click.option("--only", metavar="REGEX", help="Only the rows whose work holds this.")
@json_option
@friendly
def cost_command(runs: int, only: str | None, as_json: bool) -> None:
    """Compare what commands cost with the least that they could.

    Each row is the processor time of a command with all its processes, the least of some runs, over that of its limit
    on this machine: bare packages imported, or a film decoded or encoded and nothing else. Memory is the most that
    these processes hold at one time. The films are simulated: 4 s at 1080p and 60 frames a second, shown over and over
    for a minute or ten, or with the badge out of the picture now and then.
    """
    from moireid_lab.bench.bench_rows import chosen_names
    from moireid_lab.bench.cost import CASES, cost_row
    from moireid_lab.evaluation.text_table import table_lines

    with status_line() as say, tempfile.TemporaryDirectory() as named:
        rows, folder = [], Path(named)
        for work in chosen_names(list(CASES), only):
            say(work)
            rows.append(cost_row(work, folder, runs))
    if as_json:
        show_json({"rows": rows})
        return
    for line in table_lines(rows, COLUMNS):
        echo(line)
