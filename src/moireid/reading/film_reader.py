"""The process that reads films for a command, from the command's side.

It is forked from a program that has loaded the work, and nothing of the command's.  It seals itself before it is sent
its order.  It must answer within `SILENCE_S`, and be done within a time that grows with the film.

Without a seal (`--unsealed`, and on Windows) films are read in the command's own process, without limits.
"""

from __future__ import annotations

import atexit
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from moireid import errors
from moireid.errors import MediaError, MoireIdError
from moireid.reading.answers import Count, FilmAnswer, checked, malformed
from moireid.reading.film_orders import Order, Progress
from moireid.sandbox.file_access import Reach, reach
from moireid.sandbox.process import Child, ForkServer, ProcessEnd, start
from moireid.sandbox.seal import ProcessLimits

#: The work, after what it loads of packages only when it needs it: a sealed process cannot keep what Python compiles.
WORK = "av,numpy.fft,numpy.ma,numpy.random,moireid.reading.film_work:read"
#: Memory that a film may take, and four times the film's size; with 900 MiB a short one of 4K passes.  Large
#: pictures come in large files, so a small file cannot ask for much.
MEMORY_BYTES, MEMORY_TIMES, MOST_MEMORY_BYTES = 900 << 20, 4, 4 << 30
#: Memory that libraries reserve for each processor, as stacks of threads; little of it is used.
PROCESSOR_BYTES = 16 << 20
#: Greatest size of one answer.  A page's pictures are the largest: 0.73 MB for a board of two axes and 1860 frames, and
#: no more frames are drawn, as chapters are not longer.  A report has 0.15 kB for each 4 s of film, 3.3 MB for a day.
#: As Python objects an answer takes up to thirty times as much.
ANSWER_BYTES = 8 << 20
#: What a process may answer, each a JSON object: other values would take up to thirty times their size in memory.
ANSWERS = {"result", "pictures"}
#: Time for a film of no size, and for each megabyte of it, s; a film of 100 kbit/s takes 10 s a megabyte.
LEAST_S, MEGABYTE_S = 60.0, 60.0
#: Longest time without a message, s; reading a chapter's end takes seconds.
SILENCE_S = 60.0
#: Open files of the process: libraries, the film, and what a decoder opens of its own.
OPEN_FILES = 256
Answer = Callable[[dict[str, Any]], Any]
#: Gives what reads films, as `film_reader` does.
Readers = Callable[[Sequence[Path]], AbstractContextManager["Reader"]]


def limits_of(films: Sequence[Path], *, written_bytes: int = 0) -> tuple[ProcessLimits, float]:
    """The limits of a process that reads these films, and its time in s; written_bytes: of a file that it may write."""
    size = sum(film.stat().st_size for film in films if film.is_file())
    memory = min(MEMORY_BYTES + MEMORY_TIMES * size, MOST_MEMORY_BYTES) + PROCESSOR_BYTES * (os.cpu_count() or 1)
    seconds = LEAST_S + MEGABYTE_S * size / 1e6
    limits = ProcessLimits(
        memory,
        cpu_s=int(2 * seconds),
        file_bytes=written_bytes,
        answer_bytes=ANSWER_BYTES,
        open_files=OPEN_FILES,
    )
    return limits, seconds


class Reader:
    """Reads the films of one order: by a process; without one in this process, without a seal or limits."""

    def __init__(self, child: Child | None = None, films: Sequence[Path] = (), seconds: float = 0.0) -> None:
        self._child, self._films, self._seconds = child, films, seconds

    @property
    def sealed(self) -> tuple[str, ...]:
        """The parts of the seal that hold, as in `sandbox.seal.MEANS`; reported before the process had its order."""
        return (self._child.sealed or ()) if self._child is not None else ()

    def read(self, order: Order, progress: Progress) -> FilmAnswer:
        """What an order finds.  Raises: MoireIdError as it does; MediaError where the process fails or lies."""
        found: dict[str, Any] = {}
        film = named(self._films)

        def handle(message: dict[str, Any]) -> None:
            if "progress" in message:
                progress(*checked(message["progress"], tuple[Count, Count | None], film))
            for key in message.keys() & ANSWERS:
                if not isinstance(message[key], dict):
                    raise malformed(film, f"no {key}")
                # What was answered counts once, so that no process fills this one's memory.
                found.setdefault(key, message[key])

        if self._child is None:
            for part in order(progress):
                handle(part)
        else:
            converse(self._child, order, handle, self._films, self._seconds)
        return checked(found, FilmAnswer, film)


def converse(child: Child, order: object, handle: Answer, films: Sequence[Path], seconds: float) -> None:
    """Send an order, and handle the messages of the process until it has ended; what `handle` returns is sent back.

    Raises: MoireIdError that the work raised; MediaError where the process fails, is silent, or takes too long.
    """
    film, last = named(films), time.monotonic() + seconds
    try:
        child.send(order, SILENCE_S)
        while (message := child.hear(min(SILENCE_S, max(last - time.monotonic(), 0.0)))) is not None:
            if (back := handle(message)) is not None:
                child.send(back, SILENCE_S)
    except ProcessEnd as ended:
        if ended.kind != "done":
            raise fault_of(ended, film) from ended
        return
    over = time.monotonic() >= last
    how = f"took longer than the {seconds:.0f} s that a film of its size may take" if over else "does not answer"
    raise MediaError(f"the process that read {film} {how}, and was ended; the film may be damaged")


def named(films: Sequence[Path]) -> str:
    """Films in a sentence."""
    return ", ".join(map(str, films))


def fault_of(ended: ProcessEnd, film: str) -> MoireIdError:
    """The error of a process that did not do its work."""
    if ended.kind == "memory":
        return MediaError(f"{film} asks for more memory than a film of its size may have; export it at 4K or less")
    if ended.ours:
        kind: type[MoireIdError] = getattr(errors, ended.kind) if ended.kind in errors.__all__ else MediaError
        return kind(ended.words)
    how = ended.words if ended.kind == "crash" else f"failed ({ended.kind}: {ended.words[:300]})"
    return MediaError(f"the process that read {film} {how}; the film may be damaged")


@contextmanager
def film_reader(films: Sequence[Path], *, unsealed: bool = False) -> Iterator[Reader]:
    """What reads these films, until the block ends; unsealed: in this process."""
    if unsealed or os.name == "nt":
        yield Reader()
        return
    limits, seconds = limits_of(films)
    child = _process(limits, reach(read=films))
    try:
        yield Reader(child, films, seconds)
    finally:
        child.kill()


def _process(limits: ProcessLimits, within: Reach) -> Child:
    """A process within its limits that waits for an order."""
    if sys.platform != "linux":
        return start(WORK, limits, within=within)
    return _fork_server().fork(limits, within=within)


def warm_up() -> None:
    """Begin to load what films are read with, meanwhile the caller goes on."""
    if sys.platform == "linux":
        _fork_server().warm_up()


@cache
def _fork_server() -> ForkServer:
    """One for this program, with which it ends; it loads the work when it is first asked for a process."""
    made = ForkServer(WORK, sealed=True)
    atexit.register(made.close)
    return made
