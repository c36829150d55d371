"""The person's side of a one-time link: a page that anyone may open, and a session for the one who has the secret.

The secret is after the # of the address, which browsers send to no server.  So a program that only fetches the page, to
make a preview of the link, learns nothing and uses nothing up.  The page's script shows the secret: to look at what is
asked (`look`), and, once the camera runs, to begin (the socket), which uses the link up.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Annotated, Any

from fastapi import APIRouter, Form, Request, Response, WebSocket
from fastapi.responses import JSONResponse

from moireid_studio.auth.guard import anyone
from moireid_studio.challenge.challenge import FACE
from moireid_studio.challenge.clock import MOVES
from moireid_studio.forms import ShortRoute
from moireid_studio.jobs.claims import sealed
from moireid_studio.links import MOST_PICTURES, Links, OneTimeLink
from moireid_studio.live.routes import claimed_now
from moireid_studio.live.sockets import SessionRequest, serve
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.studio import Studio, studio_of

router = APIRouter(prefix="/check", dependencies=[anyone], include_in_schema=False, route_class=ShortRoute)
#: A secret has 43 letters.
LONGEST_SECRET = 100
NO_LINK = "This link is none of this studio's; ask for another."


@router.get("")
def page(request: Request) -> Response:
    """The same page for every link."""
    return render(request, "check.html.j2", moves=MOVES, face=FACE)


@router.post("/look")
def look(request: Request, token: Annotated[str, Form(max_length=LONGEST_SECRET)] = "") -> Response:
    """What a link asks; it is not used up."""
    studio = studio_of(request)
    try:
        link = usable(studio, token)
    except Refusal as refusal:
        return JSONResponse({"text": refusal.text}, refusal.status)
    studio.links.note_opened(link)
    return JSONResponse({"asks": link.asks, "name": name_of(studio, link), "pictures": link.wants_pictures})


@router.websocket("/socket")
async def socket(connection: WebSocket) -> None:
    """The check."""
    await serve(connection, lambda hello: _asked(studio_of(connection), hello))


def usable(studio: Studio, token: str) -> OneTimeLink:
    """The link of a secret.  Raises: Refusal 404 or 410 where there is none, or it can be used no more."""
    link = studio.links.by_secret(token)
    if link is None:
        raise Refusal(404, "no_link", NO_LINK)
    if link.used_at is not None:
        text = f"This link was used on {moment(link.used_at)}; it works once, so ask for another."
        raise Refusal(410, "used", text)
    if link.state == "late":
        raise Refusal(410, "late", f"This link could be used until {moment(link.expires_at)}; ask for another.")
    if not _may_still_ask(studio, link.asked_by):
        raise Refusal(410, "asker", "The person who made this link may ask no more; ask for another.")
    return link


def moment(text: str) -> str:
    """A time as people read it."""
    return f"{text[:10]} at {text[11:16]} UTC"


def name_of(studio: Studio, link: OneTimeLink) -> str:
    """Whose badge a link claims, as the registry knows now."""
    record = studio.registry.by_id(link.claim)
    return record.name if record is not None else "a person who is in the registry no longer"


def _asked(studio: Studio, hello: Mapping[str, Any]) -> SessionRequest:
    token = hello.get("token")
    link = usable(studio, token if isinstance(token, str) else "")
    found = claimed_now(studio, link.claim, ids=link.ids)
    kept = _CheckRecord(studio.links, link, agreed=link.wants_pictures and hello.get("pictures") is True)
    return SessionRequest(
        found,
        found if link.ids else sealed(found),
        link.asked_by,
        "link",
        allowed=lambda: _may_still_ask(studio, link.asked_by),
        begun=kept.begin,
        picture=kept.see if kept.agreed else None,
        on_event=kept.record,
        ended=kept.end,
    )


def _may_still_ask(studio: Studio, asked_by: str) -> bool:
    """Whether the token that made a link is still valid."""
    if not studio.settings.auth:
        return True
    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return any(
        token.id == asked_by and token.revoked_at is None and token.expires_at > now for token in studio.tokens.all()
    )


class _CheckRecord:
    """What is kept of a check: its verdict, and one picture of each answer if both agree."""

    def __init__(self, links: Links, link: OneTimeLink, *, agreed: bool) -> None:
        self._links, self._link, self.agreed = links, link, agreed
        self._last, self._pictures = b"", list[bytes]()

    def begin(self) -> None:
        """Use the link up.  Raises: Refusal where another session was quicker."""
        if not self._links.use(self._link, agreed=self.agreed):
            raise Refusal(410, "used", "This link was used a moment ago; it works once, so ask for another.")

    def see(self, jpeg: bytes) -> None:
        """A picture; only the last one is remembered."""
        self._last = jpeg

    def record(self, event: dict[str, Any]) -> None:
        """Keep what an event of the session brings: a picture of each answer, or the verdict."""
        if event.get("event") == "prompted" and self._last and len(self._pictures) < MOST_PICTURES:
            self._pictures.append(self._last)
        if event.get("event") == "verdict":
            report = {name: value for name, value in event.items() if name != "headline"}
            self._links.note_end(self._link, report, self._pictures)

    def end(self) -> None:
        """The session is over; where it gave no verdict, that is noted."""
        self._links.note_end(self._link, None, [])
