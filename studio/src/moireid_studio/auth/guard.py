"""The guard before every route: it sets headers of each answer, and refuses requests that other sites cause.

A browser states which site caused a request (Sec-Fetch-Site, and Origin for all that changes things), and no page can
forge these headers.  So forms need no secret of their own: a request that changes things, or opens a WebSocket, passes
only if it comes from this same origin, or not from a browser.
Source: "Cross-Site Request Forgery Prevention" of the OWASP cheat sheets, on Fetch Metadata; RFC 6455, section 10.2.

Without tokens, the Host must also be loopback.  Otherwise another site could let its own name lead to this server
(DNS rebinding), and its pages would then count as the same origin.
"""

from __future__ import annotations

from urllib.parse import SplitResult, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from moireid_studio.settings import is_loopback

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; media-src 'self' blob:; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(self), display-capture=(self), microphone=(), geolocation=(), payment=()",
    "Cache-Control": "no-store",
}
SAFE = frozenset({"GET", "HEAD", "OPTIONS"})


def _parts(address: str) -> SplitResult:
    """The parts of an address; a broken one, such as "//[", has no parts and so matches nothing."""
    try:
        return urlsplit(address)
    except ValueError:
        return SplitResult("", "", "", "", "")


class Guard:
    """ASGI middleware; a header that a route has set already stays as it is."""

    def __init__(self, app: ASGIApp, *, loopback_only: bool) -> None:
        self.app, self.loopback_only = app, loopback_only

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        headers = Headers(scope=scope)
        if why := self._refused(scope, headers):
            if scope["type"] == "websocket":
                await receive()
                await send({"type": "websocket.close", "code": 1008})
                return
            await JSONResponse({"code": "other_site", "text": why}, 403)(scope, receive, with_headers)
            return
        await self.app(scope, receive, with_headers)

    def _refused(self, scope: Scope, headers: Headers) -> str | None:
        """Why a request does not pass, or None."""
        host = headers.get("host", "")
        if self.loopback_only and not is_loopback(_parts(f"//{host}").hostname or ""):
            return "This studio runs without tokens, so it is reached as localhost or 127.0.0.1 alone."
        if scope["type"] == "http" and scope["method"] in SAFE:
            return None
        site, origin = headers.get("sec-fetch-site"), headers.get("origin")
        if origin is not None and _parts(origin).netloc.lower() != host.lower():
            return "This request was sent by another site; open the studio's own page."
        if site is not None and site not in ("same-origin", "none"):
            return "This request was sent by another site; open the studio's own page."
        return None
