"""Progress and speed of a run over many films, on stderr; and where its films are scored."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from moireid.cli.common import interrupts, say

#: Time between two lines where stderr is not a terminal.
LINE_S = 30.0

workers_option = click.option(
    "--workers",
    type=click.IntRange(1, 256),
    metavar="NUMBER",
    help="How many films at a time on this machine, one per processor; default: all processors.",
)
scheduler_option = click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Dask scheduler to send the work to: tls://HOST:PORT, with certificates in Dask's settings, or a loopback "
    "address; default: local, a cluster on this machine.",
)


@contextmanager
def film_rate(unit: str = "films") -> Iterator[Callable[[int, int, int, int], None]]:
    """A bar on stderr, called with (done, of, failed, done by earlier runs); without a terminal, a line now and then.

    At the end one line says what this run did.
    """
    begun, printed_s = time.monotonic(), 0.0
    last: tuple[int, int, int, int] | None = None

    def words(done: int, total: int, failed: int, before: int) -> str:
        rate = (done - before) / max(time.monotonic() - begun, 1e-9)
        return f"{rate:.2f} {unit}/s, {total - done} left, {failed} failed"

    with interrupts() as check, _shown(unit) as update:

        def step(done: int, total: int, failed: int = 0, before: int = 0) -> None:
            nonlocal printed_s, last
            check()
            last = (done, total, failed, before)
            if update is not None:
                update(done, total, words(*last))
            elif time.monotonic() - max(printed_s, begun) > LINE_S:
                printed_s = time.monotonic()
                say(f"{done} of {total} {unit}: {words(*last)}")

        try:
            yield step
        finally:
            if last is not None:
                seconds = time.monotonic() - begun
                say(f"{last[0] - last[3]} {unit} in {seconds:.0f} s: {words(*last)}")


@contextmanager
def _shown(unit: str) -> Iterator[Callable[[int, int, str], None] | None]:
    """The bar, None where stderr is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[words]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(unit, total=None, words="")
        yield lambda done, total, words: bar.update(task, completed=done, total=total, words=words)
