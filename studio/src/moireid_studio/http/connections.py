"""Connections: a limit on how many there are, and an end to those that stay silent.

A connection costs its sender nothing.  Where all are taken, one that has not sent a whole request must go: first the
one that has been silent longest, then the one whose request comes slowest.  So a client that sends a request gets in,
however many wait in silence.
"""

from __future__ import annotations

import asyncio
import resource
import time
from dataclasses import dataclass, field
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

#: Connections at most, and of the files that this process may open the share that they may take.  A client that opens
#: a thousand connections a second must not push out, within a second, those that are about to send a request.
MOST_CONNECTIONS, SHARE_OF_FILES = 4096, 0.5
#: Time for the headers of a request, from the connection or from the last answer on.
HEADERS_S = 10.0
#: A request that has been coming for less than this is not called slow.
YOUNG_S = 2.0
FULL = (
    b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 5\r\nContent-Type: application/json\r\n"
    b"Content-Length: 74\r\n\r\n"
    b'{"code": "busy", "text": "Too many connections; try again in a moment."}\r\n'
)


def ask_for_files() -> None:
    """Let this process open as many files as its connections may take, and the rest; most systems allow for it."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = int(MOST_CONNECTIONS / SHARE_OF_FILES)
    if 0 <= soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted if hard < 0 else min(wanted, hard), hard))


def most_connections() -> int:
    """As many as are served at a time; without a free file no connection could be taken, and none be refused."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return MOST_CONNECTIONS if files < 0 else max(min(MOST_CONNECTIONS, int(files * SHARE_OF_FILES)), 1)


@dataclass
class ConnectionGuard:
    """All connections of one server: which of them are silent, and how fast the requests of others come."""

    most: int = field(default_factory=most_connections)
    headers_s: float = HEADERS_S
    #: Those that wait for headers, oldest first, each with what will end it.
    silent: dict[Connection, asyncio.TimerHandle] = field(default_factory=dict)
    #: Those in the middle of a request: since when (s), and bytes so far.
    coming: dict[Connection, tuple[float, int]] = field(default_factory=dict)
    #: How many were turned away, or had to go for others.
    turned_away: int = 0

    def counts(self) -> dict[str, float]:
        """Connections by what they do: waiting for headers, or in the middle of a request."""
        return {"silent": len(self.silent), "coming": len(self.coming)}

    def make_room(self) -> bool:
        """End one connection for a new one; False where all others are at work."""
        self.turned_away += 1
        now = time.monotonic()
        slow = {one: got / (now - since) for one, (since, got) in self.coming.items() if now - since > YOUNG_S}
        victim = next(iter(self.silent), None) or min(slow, key=slow.__getitem__, default=None)
        if victim is None:
            return False
        self.left(victim)
        victim.transport.abort()
        return True

    def waits(self, one: Connection) -> None:
        """A connection waits for headers; what comes of them meanwhile gives it no more time."""
        self.coming.pop(one, None)
        if one not in self.silent:
            self.silent[one] = one.loop.call_later(self.headers_s, one.transport.abort)

    def speaks(self, one: Connection, got: int) -> None:
        """A connection is in the middle of a request, of which so many bytes came."""
        if (timer := self.silent.pop(one, None)) is not None:
            timer.cancel()
        since, before = self.coming.get(one, (time.monotonic(), 0))
        self.coming[one] = since, before + got

    def left(self, one: Connection) -> None:
        """A connection has ended, or has a whole request at work."""
        self.coming.pop(one, None)
        if (timer := self.silent.pop(one, None)) is not None:
            timer.cancel()


class Connection(H11Protocol):
    """One connection of the server; `behind` makes the class for a door."""

    door: ConnectionGuard

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        if len(self.connections) > self.door.most and not self.door.make_room():
            transport.write(FULL)
            transport.close()
            return
        self.door.waits(self)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        self._look(len(data))

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._look(0)

    def connection_lost(self, exc: Exception | None) -> None:
        self.door.left(self)
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        # From here on another protocol has the connection.
        self.door.left(self)
        super().handle_websocket_upgrade(event)

    def _look(self, got: int) -> None:
        """Report to the door what this connection does."""
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            self.door.left(self)
        elif self.conn.their_state is h11.IDLE or (
            # It was answered before it had said all, as an upload that is refused; what still comes is dropped.
            self.conn.our_state is h11.DONE and self.conn.their_state is h11.SEND_BODY
        ):
            self.door.waits(self)
        elif self.conn.their_state is h11.SEND_BODY:
            self.door.speaks(self, got)
        else:
            self.door.left(self)


def behind(door: ConnectionGuard) -> type[Connection]:
    """The class of a door's connections, as the server takes it."""
    made: dict[str, Any] = {"door": door}
    return type("Connection", (Connection,), made)
