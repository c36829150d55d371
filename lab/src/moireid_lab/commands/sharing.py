"""Options that say where films are made and scored, and of what."""

from __future__ import annotations

from pathlib import Path

import click

workers_option = click.option(
    "--workers",
    type=click.IntRange(1, 256),
    metavar="NUMBER",
    help="How many films at a time on this machine, one per processor; default: all processors.",
)
scheduler_option = click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Dask scheduler to send the work to, tcp://HOST:PORT; default: local, on this machine.",
)
data_option = click.option(
    "--data",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder of webcam clips of a board, and of their cameras, for half-real films.",
)
