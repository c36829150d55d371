"""The guard before every route, and the rules of who may use it.

The guard sets headers of each answer, and refuses requests that other sites cause.  A browser states which site caused
a request (Sec-Fetch-Site, and Origin for all that changes things), and no page can forge these headers.  So forms need
no secret of their own: a request that changes things, or opens a WebSocket, passes only if it comes from this same
origin, or not from a browser.
Source: "Cross-Site Request Forgery Prevention" of the OWASP cheat sheets, on Fetch Metadata; RFC 6455, section 10.2.

Without tokens, the Host must also be loopback.  Otherwise another site could let its own name lead to this server
(DNS rebinding), and its pages would then count as the same origin.

Every route names its rule; a test walks over all routes and fails where one has none.

    router = APIRouter(dependencies=[require("issuer")])        a whole file of routes
    @router.get("/x", dependencies=[require("verifier")])       or one
    def x(visitor: Annotated[Visitor, require("issuer", "verifier")])   where the route asks who it is

`issuer` issues, enrolls, revokes and audits; `verifier` verifies, identifies and checks live; `monitor`
reads figures of the studio and nothing else; `admin` may do all.
Pages without personal data are for `anyone`.  WebSocket routes take the same rules.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from urllib.parse import SplitResult, urlsplit

from fastapi import Depends, WebSocketException
from fastapi.routing import APIRoute, APIWebSocketRoute
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from moireid.registry.keys import account
from moireid.scheduler import is_loopback
from moireid_studio.auth.tokens import Role
from moireid_studio.problems import Refusal
from moireid_studio.studio import studio_of

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


def address_parts(address: str) -> SplitResult:
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
        if self.loopback_only and not is_loopback(address_parts(f"//{host}").hostname or ""):
            return "This studio runs without tokens, so it is reached as localhost or 127.0.0.1 alone."
        if scope["type"] == "http" and scope["method"] in SAFE:
            return None
        site, origin = headers.get("sec-fetch-site"), headers.get("origin")
        if origin is not None and address_parts(origin).netloc.lower() != host.lower():
            return "This request was sent by another site; open the studio's own page."
        if site is not None and site not in ("same-origin", "none"):
            return "This request was sent by another site; open the studio's own page."
        return None


COOKIE = "moireid_session"
#: Who asks where the studio needs no tokens.
LOOPBACK = "loopback"


@dataclass(frozen=True)
class Visitor:
    """The person who asks: the id of their token ("loopback" where the studio needs no tokens), role, and its note."""

    id: str
    role: Role
    note: str = ""

    @property
    def actor(self) -> str:
        """Who this is, as the registry's log names them: the token by its id and note, which are no secret."""
        if self.id == LOOPBACK:
            return f"studio without tokens, {account()}"
        return f"token {self.id}" + (f" ({self.note})" if self.note else "")

    def may(self, *roles: Role) -> bool:
        """Whether one of these roles is theirs; an admin has all."""
        return self.role == "admin" or self.role in roles


@dataclass(frozen=True)
class Rule:
    """The rule of a route: the roles that may use it; without roles, anyone may."""

    roles: tuple[Role, ...]

    def __call__(self, connection: HTTPConnection) -> Visitor | None:
        if not self.roles:
            # Without a look-up: what is open to all must answer while the database is away.
            return None
        visitor = visitor_of(connection)
        if visitor is not None and visitor.may(*self.roles):
            return _counted(connection, visitor)
        if visitor is None:
            refusal = Refusal(
                401,
                "token",
                "Sign in with a token to use this; the operator of this studio gives you one.",
                headers={"WWW-Authenticate": "Bearer"},
            )
        else:
            needed = " or ".join(self.roles)
            refusal = Refusal(403, "role", f"Your token is of the role {visitor.role}; this asks for {needed}.")
        if connection.scope["type"] == "websocket":
            raise WebSocketException(1008, refusal.text)
        raise refusal


def _counted(connection: HTTPConnection, visitor: Visitor) -> Visitor:
    """The visitor, whose request is counted.  Raises: Refusal 429 where their token sends too many."""
    try:
        studio_of(connection).jobs.rates.request(visitor.id)
    except Refusal as refusal:
        if connection.scope["type"] == "websocket":
            raise WebSocketException(1013, refusal.text) from refusal
        raise
    return visitor


def require(*roles: Role) -> Any:
    """The dependency that lets these roles pass, and admins."""
    if not roles:
        raise ValueError("name a role; what is open to all says `anyone`")
    return Depends(Rule(roles))


#: The dependency of routes that need no token; it looks up no visitor.
anyone: Any = Depends(Rule(()))


def rules_of(route: APIRoute | APIWebSocketRoute) -> list[Rule]:
    """The rules that a route names; a test fails where a route names none."""
    return [depends.call for depends in route.dependant.dependencies if isinstance(depends.call, Rule)]


def visitor_of(connection: HTTPConnection) -> Visitor | None:
    """Who asks: by the token in the header (programs), or by the session that the cookie names (browsers)."""
    studio = studio_of(connection)
    if not studio.settings.auth:
        return Visitor(LOOPBACK, "admin")
    kind, _, secret = connection.headers.get("authorization", "").partition(" ")
    if kind.lower() == "bearer":
        token = studio.tokens.find(secret.strip())
    else:
        token = studio.tokens.of_session(connection.cookies.get(COOKIE, ""))
    return Visitor(token.id, token.role, token.note) if token else None
