"""The parent's end of the connection to a process that an attacker may control.

The process may announce a long message and never send it, or never read what it is sent.  So no call here waits longer
than its caller allows; a message that came in part is kept for the next call.
Convention: a message is its length in bytes (four, big endian, signed) and its content, as `multiprocessing` writes it.
"""

from __future__ import annotations

import select
import socket
import struct
import time

LENGTH = struct.Struct("!i")
#: Bytes that are read at a time.
PIECE = 1 << 20


class MessageChannel:
    """One end; one thread may send while another receives."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end, self._come = end, bytearray()

    def __del__(self) -> None:
        self._end.close()

    def send(self, content: bytes, seconds: float | None) -> bool:
        """Send a message; False where the other end did not take it within `seconds` (None: no limit).

        Convention: after False the connection is of no more use, as a part may have been sent.
        Raises: OSError where the other end is closed.
        """
        last, rest = _end_of(seconds), memoryview(LENGTH.pack(len(content)) + content)
        while rest:
            if not self._ready(select.POLLOUT, last):
                return False
            try:
                rest = rest[self._end.send(rest[:PIECE]) :]
            except BlockingIOError:
                continue
        return True

    def receive(self, most: int, seconds: float | None) -> bytes | None:
        """The next message; None where it is not whole within `seconds` (None: no limit).

        Raises: ValueError where it is longer than `most` bytes; EOFError, OSError where the other end is closed.
        """
        last = _end_of(seconds)
        while (whole := self._whole(most)) is None:
            if not self._ready(select.POLLIN, last):
                return None
            try:
                piece = self._end.recv(PIECE)
            except BlockingIOError:
                continue
            if not piece:
                raise EOFError
            self._come += piece
        return whole

    def _whole(self, most: int) -> bytes | None:
        """The first message of what has come, if all of it has."""
        if len(self._come) < LENGTH.size:
            return None
        length = LENGTH.unpack_from(self._come)[0]
        if not 0 <= length <= most:
            raise ValueError(f"a message of {length} bytes, and {most} are allowed")
        if len(self._come) < LENGTH.size + length:
            return None
        content = bytes(self._come[LENGTH.size : LENGTH.size + length])
        del self._come[: LENGTH.size + length]
        return content

    def _ready(self, what: int, last: float | None) -> bool:
        """Whether the connection can be used, or is closed, before that time."""
        waiting = select.poll()
        waiting.register(self._end, what)
        return bool(waiting.poll(None if last is None else max(last - time.monotonic(), 0.0) * 1000))


def _end_of(seconds: float | None) -> float | None:
    return None if seconds is None else time.monotonic() + seconds
