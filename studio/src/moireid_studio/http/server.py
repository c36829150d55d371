"""The studio's server on a socket that listens, and the limits on what a token may ask of it.

`Rates`: how often a token may ask, by its role.  The counts are those of this process; each studio has its own.
`fits`: who may take how many of the places for films.  A token leaves some to others, and verifiers leave some to
issuers.
"""

from __future__ import annotations

import contextlib
import math
import signal
import socket
import time
from collections.abc import Iterable

import uvicorn
from fastapi import FastAPI
from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from moireid_studio.auth.tokens import Role
from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits
from moireid_studio.store.job import JobCounts

#: How long answers that are on their way may take once the server is to stop.
STOP_S = 5
#: Connections at most; a proxy ends those that say nothing (`deploy/Caddyfile`).
MOST_CONNECTIONS = 512
#: Bytes of a WebSocket's message: a picture has a megabyte, and anyone with a one-time link may open its socket.
MESSAGE_BYTES = 2 << 20


def serve(app: FastAPI, bound: socket.socket) -> None:
    """Serve an application on a socket that listens, until this process is interrupted or terminated."""
    # The server stops by itself on SIGTERM, and then sends it again: that is no reason to end without tidying up.
    signal.signal(signal.SIGTERM, lambda *_: None)
    # The user stops the server by an interrupt, so this is not an error.
    with contextlib.suppress(KeyboardInterrupt):
        _server_of(app).run(sockets=[bound])


def _server_of(app: FastAPI) -> uvicorn.Server:
    config = uvicorn.Config(
        app,
        http="h11",
        limit_concurrency=MOST_CONNECTIONS,
        # Logging is set up already, for all that this process writes.
        log_config=None,
        access_log=False,
        server_header=False,
        ws_max_size=MESSAGE_BYTES,
        timeout_graceful_shutdown=STOP_S,
    )
    return uvicorn.Server(config)


class Rates:
    """Counts of requests and uploads by token, within a minute that ends now."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._window = MovingWindowRateLimiter(MemoryStorage())

    def request(self, owner: str) -> None:
        """Count a request.  Raises: Refusal 429 where the token has sent too many."""
        self._count("requests", owner, self._limits.requests_a_minute)

    def upload(self, owner: str, role: Role) -> None:
        """Count an upload, or an order.  Raises: Refusal 429 where the token has sent too many."""
        most = self._limits.uploads_a_minute
        self._count("uploads", owner, most if role == "verifier" else 2 * most)

    def _count(self, what: str, owner: str, most: int) -> None:
        item = RateLimitItemPerMinute(most)
        if self._window.hit(item, what, owner):
            return
        wait_s = max(math.ceil(self._window.get_window_stats(item, what, owner).reset_time - time.time()), 1)
        raise Refusal(
            429,
            "rate",
            f"This token has sent {most} {what} within a minute, which is as many as it may; go on in {wait_s} s.",
            headers={"Retry-After": str(wait_s)},
        )


#: Of all places: what one token may take, and what all verifiers together may.
OF_ONE, OF_VERIFIERS = 0.5, 0.75
#: An upload on its way takes no work yet, so a token may have fewer of them.
RECEIVED_OF_ONE = 0.25


def fits(held: Iterable[JobCounts], owner: str, role: str, limits: Limits) -> bool:
    """Whether one more film of this token may come.

    A film on its way counts among `limits.uploads`, so a slow one takes no place in the queue from a film that is
    there.
    """
    every = list(held)
    queued = [one for one in every if not one.receiving]
    coming = [one for one in every if one.receiving]
    places = limits.workers + limits.waiting
    return _room(queued, owner, role, places, OF_ONE) and _room(coming, owner, role, limits.uploads, RECEIVED_OF_ONE)


def _room(held: list[JobCounts], owner: str, role: str, places: int, of_one: float) -> bool:
    """Whether a place is left, of all, of the token's share, and of the verifiers' share."""
    all_of = sum(one.count for one in held)
    own = sum(one.count for one in held if one.owner == owner)
    verifiers = sum(one.count for one in held if one.role == "verifier")
    if all_of >= places or own >= max(int(places * of_one), 1):
        return False
    return role != "verifier" or verifiers < max(int(places * OF_VERIFIERS), 1)
