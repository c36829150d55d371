"""lab: the commands for researchers, as one group."""

from __future__ import annotations

import click

from moireid_lab.commands.bench_cmd import bench_command
from moireid_lab.commands.cost_cmd import cost_command
from moireid_lab.commands.evaluate_cmd import evaluate_command
from moireid_lab.commands.film_set_cmd import film_set_command
from moireid_lab.commands.generator_cmd import generator_group
from moireid_lab.commands.paper_cmd import paper_command
from moireid_lab.commands.scoreboard_cmd import scoreboard_command


@click.group("lab")
def lab_group() -> None:
    """Print this project's figures, and score many films."""


for _command in (
    bench_command,
    cost_command,
    evaluate_command,
    film_set_command,
    generator_group,
    paper_command,
    scoreboard_command,
):
    lab_group.add_command(_command)
