"""What the judge is fed: bytes of a pipe as it asks for them, and pictures of a camera.

The judge is in a stranger's hands once it has read the source, so it gets bytes of this pipe alone, so many at a time.
"""

from __future__ import annotations

import hashlib
import os
import select
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, BinaryIO

from moireid.errors import MediaError, MoireIdError
from moireid.sandbox.process import Child, ProcessEnd
from moireid_studio.watch.cameras import shots_of
from moireid_studio.watch.order import PIECE, Data, StreamEnd
from moireid_studio.watch.source import Source

#: Time between two looks whether a pipe is still waited for, s.
LOOK_S = 0.25


class Feeder:
    """Answers the judge; each answer that may take long is given by a thread, which ends with this process."""

    def __init__(self, source: Source, child: Child) -> None:
        self._source, self._child = source, child
        self._lock, self._over = threading.Lock(), threading.Event()
        self._digest = hashlib.sha256()
        self._pipe: BinaryIO | None = None

    @property
    def sha256(self) -> str:
        """Of the pipe's bytes that were read."""
        return self._digest.hexdigest()

    def begin(self) -> None:
        """Begin with a pipe or a camera.  Raises: MediaError where a pipe cannot be read."""
        if self._source.kind == "pipe":
            self._pipe = _pipe(self._source)
        elif self._source.kind == "camera":
            self._aside(self._shoot)

    def send(self, message: object) -> None:
        """Send the judge a message; where it has gone, the thread that listens to it finds out why."""
        with self._lock, suppress(ProcessEnd):
            self._child.send(message)

    def answer(self, message: dict[str, Any]) -> None:
        """Answer a wish."""
        if self._pipe is not None and "want" in message:
            self._aside(lambda: self._read(min(int(message["want"]), PIECE)))

    def end(self) -> None:
        """Wait for no more bytes, and take no more pictures."""
        self._over.set()

    def _aside(self, work: Callable[[], None]) -> None:
        def safely() -> None:
            try:
                work()
            except MoireIdError as error:
                self.send(StreamEnd("failed", " ".join(str(error).split())))

        threading.Thread(target=safely, daemon=True).start()

    def _read(self, most: int) -> None:
        try:
            content, error = self._some(most), None
        except OSError as broken:
            content, error = b"", broken.strerror or str(broken)
        self.send(Data(content, time.monotonic(), error))

    def _some(self, most: int) -> bytes:
        assert self._pipe is not None
        # A pipe into which no one has written yet would seem to be at its end; and a read that waits would take what is
        # written for the next reader.
        while not select.select([self._pipe], [], [], LOOK_S)[0]:
            if self._over.is_set():
                return b""
        content = os.read(self._pipe.fileno(), most)
        self._digest.update(content)
        return content

    def _shoot(self) -> None:
        for shot in shots_of(int(self._source.text)):
            if self._over.is_set():
                return
            self.send(shot)
        self.send(StreamEnd("source"))


def _pipe(source: Source) -> BinaryIO:
    """The pipe, opened for its bytes."""
    if source.text != "-":
        try:
            # Without waiting: the writer may not be there yet, and the judge decides how long that may take.
            opened = os.open(source.text, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
            os.set_blocking(opened, True)
            return open(opened, "rb", buffering=0)
        except OSError as error:
            raise MediaError(f"pipe {source.shown} cannot be read ({error.strerror}); check its rights") from error
    if sys.stdin is None or sys.stdin.buffer.isatty():
        raise MediaError("nothing is piped into this program; give it a stream, such as: cat film.ts | moireid watch -")
    return sys.stdin.buffer
