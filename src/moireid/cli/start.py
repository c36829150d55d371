"""Where `moireid` starts.  A command that reads films starts twice, so that the process that reads them is made first
(`sandbox/early_copy.py`).

The first start loads nothing else.
"""

from __future__ import annotations

import contextlib
import sys
from typing import TYPE_CHECKING

from moireid.cli.streams import open_closed_streams
from moireid.sandbox.early_copy import EarlyCopy, restart, resume

if TYPE_CHECKING:
    from collections.abc import Iterator

#: Commands that read films, and the option without which they read none.
READS_FILMS = {"verify": "", "identify": "", "enroll": "--capture", "calibrate": ""}


def main() -> None:
    """Run `moireid`."""
    open_closed_streams()
    with _without_traceback():
        if _reads_films(sys.argv[1:]):
            restart("moireid.cli.start")
        run()


@contextlib.contextmanager
def _without_traceback() -> Iterator[None]:
    """End quietly where an interrupt comes before the program can say so: nothing is begun yet."""
    try:
        yield
    except KeyboardInterrupt:
        sys.exit(130)


def _reads_films(words: list[str]) -> bool:
    option = READS_FILMS.get(words[0]) if words else None
    if option is None or {"-h", "--help", "--unsealed"} & {*words}:
        return False
    return any(word.startswith(option) for word in words)


def run() -> None:
    """Run the command that the arguments name."""
    from moireid.cli.main import main

    main()


def _run_again(handle: int) -> None:
    """The second start; handle: of what the first one wrote."""
    import signal

    # Nothing is done yet that would be tidied up, and no line of Python is to be shown.
    quiet = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if quiet:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    from moireid.reading.film_work import read

    # Without a copy, films are read by a process that is made later.
    with contextlib.suppress(OSError):
        EarlyCopy.waiting = EarlyCopy(read)
    resume(handle)
    with _without_traceback():
        if quiet:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        run()


if __name__ == "__main__":
    # Started by a person, it starts as `moireid` does.
    if len(sys.argv) == 2 and sys.argv[1].isdecimal():
        _run_again(int(sys.argv[1]))
    else:
        main()
