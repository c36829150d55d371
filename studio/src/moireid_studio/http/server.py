"""The studio's server on a socket that listens."""

from __future__ import annotations

import contextlib
import signal
import socket

import uvicorn
from fastapi import FastAPI

from moireid_studio.http.connections import Door, behind

#: How long answers that are on their way may take once the server is to stop.
STOP_S = 5
#: Connections that wait to be taken.  As many are taken at once, before the first of them can be ended: with those that
#: the door lets stay they must be fewer than the files that a process may open, or each costs a page of log.
BACKLOG = 128
#: Bytes of a WebSocket's message: a picture has a megabyte, and anybody may open the socket behind a one-time link.
MESSAGE_BYTES = 2 << 20


def serve(app: FastAPI, bound: socket.socket) -> None:
    """Serve an application on a socket that listens, until this process is interrupted or terminated."""
    # The server stops by itself on SIGTERM, and then sends it again: that is no reason to end without tidying up.
    signal.signal(signal.SIGTERM, lambda *_: None)
    # The user stops the server by an interrupt, so this is not an error.
    with contextlib.suppress(KeyboardInterrupt):
        _server_of(app).run(sockets=[bound])


def _server_of(app: FastAPI) -> uvicorn.Server:
    door: Door = app.state.door
    config = uvicorn.Config(
        app,
        http=behind(door),
        # Logging is set up already, for all that this process writes.
        log_config=None,
        access_log=False,
        server_header=False,
        backlog=BACKLOG,
        ws_max_size=MESSAGE_BYTES,
        timeout_graceful_shutdown=STOP_S,
    )
    return uvicorn.Server(config)
