"""cost: the processor time of what people wait for, over that of bare packages on the same machine."""

from __future__ import annotations

import tempfile
from pathlib import Path

import click

from moireid.cli.common import echo, friendly, json_option, show_json, status_line

COLUMNS = {"work": "<32", "s": ">7.3f", "limit": "<26", "limit s": "limit_s >7.3f", "ratio": ">6.2f", "asked": ">6.2f"}


@click.command("cost")
@click.option("--runs", type=click.IntRange(1), default=3, show_default=True, help="Runs of each; the least counts.")
@json_option
@friendly
def cost_command(runs: int, as_json: bool) -> None:
    """Compare what commands cost with the least that they could.

    Each row is the processor time of a command with all its processes, the least of some runs, over that of its limit
    on this machine: bare packages imported, or a film decoded or encoded and nothing else. The film is simulated: 4 s
    at 1080p and 60 frames a second.
    """
    from moireid_lab.bench.cost import cost_rows
    from moireid_lab.evaluation.text_table import table_lines

    with status_line() as say, tempfile.TemporaryDirectory() as folder:
        rows = []
        for row in cost_rows(Path(folder), runs):
            say(row["work"])
            rows.append(row)
    if as_json:
        show_json({"rows": rows})
        return
    for line in table_lines(rows, COLUMNS):
        echo(line)
