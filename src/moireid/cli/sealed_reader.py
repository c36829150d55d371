"""The process in which a command reads films, and the note where its seal is not whole."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import say

if TYPE_CHECKING:
    from moireid.reading.film_reader import Reader

unsealed_option = click.option(
    "--unsealed",
    is_flag=True,
    help="Read the film in this process. A film made to take over its decoder then has your rights: your files, the "
    "network, your keys; and nothing limits its memory and time. The report says that it was read so.",
)


def sealed_reader(films: Sequence[Path], *, unsealed: bool) -> AbstractContextManager[Reader]:
    """What reads the films of a command, which begins to load; a note says what the system does not seal, once they
    have been read.
    """
    if not unsealed:
        from moireid.reading.film_reader import warm_up

        warm_up()
    return _noted_reader(films, unsealed=unsealed)


@contextmanager
def _noted_reader(films: Sequence[Path], *, unsealed: bool) -> Iterator[Reader]:
    from moireid.reading.film_reader import film_reader
    from moireid.sandbox.seal import missing

    with film_reader(films, unsealed=unsealed) as reader:
        yield reader
        lacking = missing(reader.sealed)
    if lacking is not None:
        why = "as --unsealed asks" if unsealed else "this system has no means against that"
        say(f"note: the process that read the film {lacking}: {why}")
