"""A server that takes one WebRTC sender: OBS, a browser, GStreamer (WHIP, RFC 9725).

It runs in our process and knows the token; it hands descriptions on to the judge, which receives the pictures.
"""

from __future__ import annotations

import asyncio
import hmac
import queue
import secrets
import socket
import threading
import time
from types import TracebackType
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from moireid.errors import MediaError
from moireid.extras import missing_extra
from moireid_studio.settings import is_loopback, listening
from moireid_studio.watch.feeding import MOST_SDP_BYTES, SDP, Feeder
from moireid_studio.watch.order import Signal, StreamEnd
from moireid_studio.watch.source import Source

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response

PORT, RESOURCE = 8080, "session"
#: Connections at a time; seconds for a request's content, for the judge's answer, and for the server to start.
MOST_CONNECTIONS, BODY_S, ANSWER_S, START_S = 16, 10.0, 20.0, 10.0
#: A page of any origin may send: it needs the token, which no browser adds of itself.
CORS = {
    "Access-Control-Allow-Origin": "*",
    "Access-Control-Allow-Methods": "POST, DELETE, OPTIONS",
    "Access-Control-Allow-Headers": "Authorization, Content-Type",
    "Access-Control-Expose-Headers": "Location",
}


class WhipServer:
    """The server, from `with` to its end.

    Parameters
    ----------
    token
        That a sender must show; None: one is drawn.

    Raises
    ------
    MediaError
        Where its address cannot be used.
    MissingExtraError
        Without aiortc or the server's packages.
    """

    def __init__(self, source: Source, token: str | None, feeder: Feeder) -> None:
        parts = urlsplit(source.text)
        self._host, self._path = parts.hostname or "", parts.path or "/"
        port = PORT if parts.port is None else parts.port
        self._secret, self._feeder = token or secrets.token_urlsafe(16), feeder
        #: The token that was drawn; None where it was given.
        self.token = None if token else self._secret
        #: Whether this machine alone can reach it.
        self.here = is_loopback(self._host)
        self._taken = False
        try:
            import aiortc  # noqa: F401
            import starlette  # noqa: F401
            import uvicorn
        except ImportError as missing:
            raise missing_extra("receiving WebRTC", missing.name or "aiortc", "webrtc", "moireid-studio") from missing
        self._socket = _bound(self._host, port)
        shown = f"[{self._host}]" if ":" in self._host else self._host
        self.address = f"http://{shown}:{self._socket.getsockname()[1]}{self._path}"
        config = uvicorn.Config(
            self._app(), log_level="critical", access_log=False, lifespan="off", limit_concurrency=MOST_CONNECTIONS
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._server.run, args=([self._socket],), daemon=True)

    def __enter__(self) -> WhipServer:
        self._thread.start()
        last = time.monotonic() + START_S
        while not self._server.started and self._thread.is_alive() and time.monotonic() < last:
            time.sleep(0.01)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._server.should_exit = self._server.force_exit = True
        self._thread.join(5)
        self._socket.close()

    def _app(self) -> Any:
        from starlette.applications import Starlette
        from starlette.routing import Route

        session = f"{self._path.rstrip('/')}/{RESOURCE}"
        return Starlette(
            routes=[
                Route(self._path, self._post, methods=["POST"]),
                Route(session, self._delete, methods=["DELETE"]),
                Route("/{any:path}", _options, methods=["OPTIONS"]),
            ]
        )

    async def _post(self, request: Request) -> Response:
        """Take a sender's offer, and give the judge's answer."""
        if (refusal := self._refused(request)) is not None:
            return refusal
        if request.headers.get("content-type", "").partition(";")[0].strip().lower() != SDP:
            return _said(415, f"The content must be {SDP}.")
        try:
            async with asyncio.timeout(BODY_S):
                sdp = await _content(request)
        except TimeoutError:
            return _said(408, "The description came too slowly.")
        if sdp is None:
            return _said(413, f"A description has at most {MOST_SDP_BYTES} bytes.")
        if not sdp.startswith("v=0") or "\nm=video" not in sdp:
            return _said(400, "This is no description of a session with video.")
        if self._taken:
            return _said(409, "Another sender is being judged; one at a time is.")
        self._taken = True
        self._feeder.send(Signal(sdp))
        try:
            answer = await asyncio.to_thread(self._feeder.described.get, timeout=ANSWER_S)
        except queue.Empty:
            return _said(500, "This description cannot be answered.")
        place = f"{self._path.rstrip('/')}/{RESOURCE}"
        return _said(201, answer, {"Content-Type": SDP, "Location": place})

    async def _delete(self, request: Request) -> Response:
        """The sender has ended."""
        if (refusal := self._refused(request)) is not None:
            return refusal
        if not self._taken:
            return _said(404, "No sender is being judged.")
        self._feeder.send(StreamEnd("source"))
        return _said(200, "")

    def _refused(self, request: Request) -> Response | None:
        kind, _, token = request.headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer" and hmac.compare_digest(token.strip().encode(), self._secret.encode()):
            return None
        return _said(401, "A sender must show the token.", {"WWW-Authenticate": "Bearer"})


async def _content(request: Request) -> str | None:
    """A request's content; None where it is too long."""
    content = bytearray()
    async for piece in request.stream():
        content += piece
        if len(content) > MOST_SDP_BYTES:
            return None
    return content.decode("utf-8", "replace")


async def _options(request: Request) -> Response:
    return _said(204, "", {"Accept-Post": SDP})


def _said(status: int, text: str, headers: dict[str, str] | None = None) -> Response:
    from starlette.responses import Response

    return Response(text, status, CORS | {"Content-Type": "text/plain; charset=utf-8"} | (headers or {}))


def _bound(host: str, port: int) -> socket.socket:
    try:
        return listening(host, port)
    except (OSError, OverflowError) as error:
        words = getattr(error, "strerror", None) or str(error)
        raise MediaError(f"{host}:{port} cannot be listened at ({words}); give another port or address") from error
