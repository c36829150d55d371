"""The studio's server on a socket that listens."""

from __future__ import annotations

import uvicorn
from fastapi import FastAPI

from moireid.web.door.connections import Door, behind

#: How long answers that are on their way may take once the server is to stop.
STOP_S = 5
#: Connections that wait to be taken.  As many are taken at once, before the first of them can be ended: with those that
#: the door lets stay they must be fewer than the files that a process may open, or each costs a page of log.
BACKLOG = 128


def server_of(app: FastAPI) -> uvicorn.Server:
    """The server of an application; `run(sockets=[...])` serves until it is interrupted or terminated."""
    app.state.door = Door()
    config = uvicorn.Config(
        app,
        http=behind(app.state.door),
        log_level="warning",
        server_header=False,
        backlog=BACKLOG,
        timeout_graceful_shutdown=STOP_S,
    )
    return uvicorn.Server(config)
