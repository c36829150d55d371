"""The parent's end of the connection to a process that an attacker may control.

The process may announce a long message and never send it, or never read what it is sent.  So no call here waits longer
than its caller allows; a message that came in part is kept for the next call.
Convention: a message is its length in bytes (four, big endian, signed) and its content, as `multiprocessing` writes it.
"""

from __future__ import annotations

import socket
import struct
import time

LENGTH = struct.Struct("!i")
#: Bytes that are read at a time.
PIECE = 1 << 20
#: Time that is no limit, s: without a limit one end would block, and with it the other, as both are one connection.
NO_LIMIT_S = 1e6
#: A wait of 0 s would be none for what is there already, s.
LEAST_S = 1e-4


class MessageChannel:
    """One end; one thread may send while another receives."""

    def __init__(self, end: socket.socket) -> None:
        # Each way has a time limit of its own.
        self._end, self._way_out, self._come = end, end.dup(), bytearray()

    def __del__(self) -> None:
        self._end.close()
        self._way_out.close()

    def send(self, content: bytes, seconds: float | None) -> bool:
        """Send a message; False where the other end did not take it within `seconds` (None: no limit).

        Convention: after False the connection is of no more use, as a part may have been sent.
        Raises: OSError where the other end is closed.
        """
        self._way_out.settimeout(NO_LIMIT_S if seconds is None else max(seconds, LEAST_S))
        try:
            self._way_out.sendall(LENGTH.pack(len(content)) + content)
        except TimeoutError:
            return False
        return True

    def receive(self, most: int, seconds: float | None) -> bytes | None:
        """The next message; None where it is not whole within `seconds` (None: no limit).

        Raises: ValueError where it is longer than `most` bytes; EOFError, OSError where the other end is closed.
        """
        last = time.monotonic() + (NO_LIMIT_S if seconds is None else seconds)
        while (whole := self._whole(most)) is None:
            self._end.settimeout(max(last - time.monotonic(), LEAST_S))
            try:
                piece = self._end.recv(PIECE)
            except TimeoutError:
                return None
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
