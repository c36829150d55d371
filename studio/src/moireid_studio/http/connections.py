"""Connections: how many there may be, and how soon each must ask for something.

A proxy in front of a studio (`deploy/Caddyfile`) takes silent and slow visitors on itself.  A studio without one keeps
what follows: a bound on all connections, a share of them for each address, and a deadline for a request's headers, and
for the rest of a request that was answered already.  Requests that are read are watched by `uploads` and `forms`.
"""

from __future__ import annotations

import asyncio
import ipaddress
import math
import os
import resource
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

import anyio
import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

#: Connections at most, and of the files that this process may open the share that they may take.
MOST_CONNECTIONS, SHARE_OF_FILES = 4096, 0.5
#: The share of the connections that one address may have.
SHARE_OF_ONE = 0.25
#: WebSockets that have not said what they ask, of each way to come; and those of them that are looked up at a time.
MOST_SILENT, LOOKED_UP = 1024, 8
#: Time for the headers of a request, from the connection or from the last answer on.
HEADERS_S = 10.0
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


def proxies() -> frozenset[str]:
    """Addresses of proxies, by the variable that the server takes them from; "*" for every address."""
    return frozenset(os.environ.get("FORWARDED_ALLOW_IPS", "127.0.0.1,::1").replace(" ", "").split(","))


def neighbourhood(host: str) -> str:
    """What counts as one address: an address of IPv4, the /64 of one of IPv6, of which anyone has as many."""
    try:
        found = ipaddress.ip_address(host)
    except ValueError:
        return host
    if found.version == 4:
        return host
    return str(found.ipv4_mapped or ipaddress.ip_network((found, 64), strict=False))


@dataclass
class ConnectionLimits:
    """The limits of one server, and which address has how many connections of HTTP; a proxy may have all of them.

    Where all places are taken, the connection that has said nothing for the longest time makes room.
    """

    most: int = field(default_factory=most_connections)
    headers_s: float = HEADERS_S
    proxies: frozenset[str] = field(default_factory=proxies)
    held: Counter[str] = field(default_factory=Counter)
    #: Connections that have yet to ask for something, the oldest first.
    waiting: dict[Connection, None] = field(default_factory=dict)
    #: How many were turned away.
    turned_away: int = 0

    def admit(self, host: str, total: int) -> bool:
        """Whether a connection of this host may stay, which counts until `left`; total: of all, WebSockets too."""
        one = neighbourhood(host)
        self.held[one] += 1
        own = math.inf if self._is_proxy(host) else max(int(self.most * SHARE_OF_ONE), 1)
        fits = self.held[one] <= own and (total <= self.most or self._make_room())
        self.turned_away += not fits
        return fits

    def _is_proxy(self, host: str) -> bool:
        if self.proxies & {"*", host}:
            return True
        networks = [one for one in self.proxies if "/" in one]
        with suppress(ValueError):
            return any(ipaddress.ip_address(host) in ipaddress.ip_network(one) for one in networks)
        return False

    def _make_room(self) -> bool:
        """End the connection that has been silent for the longest time; whether there is one."""
        silent = next(iter(self.waiting), None)
        if silent is not None:
            del self.waiting[silent]
            silent.transport.abort()
        return silent is not None

    def left(self, host: str) -> None:
        """A connection of this host has ended."""
        self.held -= Counter((neighbourhood(host),))


class SilentSockets:
    """WebSockets that have not said yet what they ask, with one budget for all who came the same way.

    Where all places are taken, the address that has most of them loses its oldest: whoever asks at once gets in, and
    one address that stays silent takes no place from another.
    """

    def __init__(self, most: int) -> None:
        self._most, self._held = most, dict[str, dict[anyio.CancelScope, None]]()
        #: How many may be looked up at a time, so that wrong secrets keep no thread from other requests.
        self.looking = anyio.CapacityLimiter(LOOKED_UP)

    def __len__(self) -> int:
        return sum(map(len, self._held.values()))

    @contextmanager
    def place(self, host: str) -> Iterator[anyio.CancelScope]:
        """A place for a socket of this host; what is done in it is cancelled where it must make room."""
        if len(self) >= self._most:
            self._make_room()
        one = neighbourhood(host)
        with anyio.CancelScope() as scope:
            self._held.setdefault(one, {})[scope] = None
            try:
                yield scope
            finally:
                self._leave(one, scope)

    def _make_room(self) -> None:
        """End the oldest socket of the address that has most; of several, of the one that came first."""
        one = max(self._held, key=lambda address: len(self._held[address]))
        oldest = next(iter(self._held[one]))
        self._leave(one, oldest)
        oldest.cancel()

    def _leave(self, one: str, scope: anyio.CancelScope) -> None:
        if scope in (held := self._held.get(one, {})):
            del held[scope]
            if not held:
                del self._held[one]


class Connection(H11Protocol):
    """One connection of the server; `limited` makes the class for its limits."""

    limits: ConnectionLimits
    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._host = self.client[0] if self.client else ""
        if not self.limits.admit(self._host, len(self.connections)):
            transport.write(FULL)
            transport.close()
            return
        self._watch()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        self._watch()

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._watch()

    def connection_lost(self, exc: Exception | None) -> None:
        self.limits.left(self._host)
        super().connection_lost(exc)
        self._watch()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        # From here on another protocol has the connection, and `live.sockets` bounds those that say nothing.
        self.limits.left(self._host)
        super().handle_websocket_upgrade(event)

    def _watch(self) -> None:
        """Set the deadline where a request is waited for, once; what comes of its headers gives no more time."""
        ours = not self.transport.is_closing() and self.transport.get_protocol() is self
        waits = self.conn.their_state is h11.IDLE or (
            # It was answered before it had said all, as an upload that is refused; what still comes is dropped.
            self.conn.our_state is h11.DONE and self.conn.their_state is h11.SEND_BODY
        )
        if ours and waits and self._deadline is None:
            self._deadline = self.loop.call_later(self.limits.headers_s, self.transport.abort)
            self.limits.waiting[self] = None
        elif not (ours and waits) and self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
            self.limits.waiting.pop(self, None)


def limited(limits: ConnectionLimits) -> type[Connection]:
    """The class of connections within these limits, as the server takes it."""
    made: dict[str, Any] = {"limits": limits}
    return type("Connection", (Connection,), made)
