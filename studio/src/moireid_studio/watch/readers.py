"""Where the decoder's bytes come from: a file that may still grow, or the process that reads a pipe or an address."""

from __future__ import annotations

import os
import queue
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from moireid_studio.watch.order import PIECE, Data

#: Time between two looks at a file that has come to its end, s.
LOOK_S = 0.1
#: Boxes of an MP4 file that are looked at to see whether it can be read as it grows.
MOST_BOXES = 64


class GrowingFile:
    """A file read on, until it has not grown for some seconds.

    Convention: it has no `seek`, so that the decoder never looks for an end that is not there yet.
    """

    def __init__(self, path: Path, grown_s: float) -> None:
        self._stream, self.name = path.open("rb", buffering=0), str(path)
        self._grown_s, self._whole = grown_s, False

    def read(self, count: int) -> bytes:
        """The next bytes; b"" at the end."""
        last_s = time.monotonic() + self._grown_s
        while not self._whole:
            if piece := self._stream.read(count):
                return piece
            # Nobody has written to an older file for a while.
            age_s = time.time() - os.fstat(self._stream.fileno()).st_mtime
            self._whole = age_s > self._grown_s or time.monotonic() > last_s
            time.sleep(LOOK_S)
        return b""


def is_closed(path: Path) -> bool:
    """Whether a file can only be read once it is whole: an MP4 file whose table of frames stands behind its pictures.

    Source: ISO/IEC 14496-12, section 4.2: each box is its size (four bytes, big endian; 1: eight bytes follow its name)
        and its name.
    """
    with path.open("rb") as stream:
        for _ in range(MOST_BOXES):
            head = stream.read(8)
            if len(head) < 8 or head[4:] in (b"moov", b"moof"):
                return False
            if head[4:] == b"mdat":
                return True
            size = int.from_bytes(head[:4], "big")
            size, read = (int.from_bytes(stream.read(8), "big"), 16) if size == 1 else (size, 8)
            if size < read:
                return False
            stream.seek(size - read, os.SEEK_CUR)
    return False


class Refused(OSError):
    """Bytes that the process which started us does not give, with its reason."""


class Asked:
    """Streams of bytes that the process which started us reads for us, by number.

    The decoder's thread asks and waits; another thread hands on what comes (`give`).
    """

    def __init__(self, tell: Callable[[dict[str, Any]], None]) -> None:
        self._tell, self._answers = tell, dict[int, queue.SimpleQueue[Data]]()
        self._next = 0
        #: When the last bytes came, by our clock, s; and how many came in all.
        self.arrival_s, self.count = time.monotonic(), 0

    def open(self, address: str | None) -> AskedStream:
        """A stream: of an address, or of the pipe.  Raises: Refused where it cannot be opened."""
        number, self._next = self._next, self._next + 1
        self._answers[number] = queue.SimpleQueue()
        if address is not None:
            self.ask({"want": "open", "number": number, "address": address})
        return AskedStream(self, number, address or "-")

    def ask(self, wish: dict[str, Any]) -> bytes:
        """What is answered to a wish.  Raises: Refused where that is an error."""
        self._tell(wish)
        answer = self._answers[wish["number"]].get()
        if answer.error is not None:
            raise Refused(5, answer.error)
        self.arrival_s, self.count = answer.arrival_s, self.count + len(answer.content)
        return answer.content

    def give(self, data: Data) -> None:
        """Hand on what came."""
        if (waiting := self._answers.get(data.number)) is not None:
            waiting.put(data)

    def close(self, number: int) -> None:
        """Nothing more is asked of a stream."""
        self._tell({"want": "close", "number": number})
        self._answers.pop(number, None)


class AskedStream:
    """One of these streams with what the decoder's library expects: read, close and a name."""

    def __init__(self, asked: Asked, number: int, name: str) -> None:
        self._asked, self._number, self.name = asked, number, name

    def read(self, count: int) -> bytes:
        """The next bytes; b"" at the end."""
        return self._asked.ask({"want": "read", "number": self._number, "most": min(count, PIECE)})

    def close(self) -> None:
        """Nothing more is read."""
        self._asked.close(self._number)
