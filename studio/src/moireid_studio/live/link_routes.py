"""One-time links: the asker's pages, where a link is made and read, and the page and session of the one who is asked.

The secret is after the # of the address, which browsers send to no server.  So a program that only fetches the page, to
make a preview of the link, learns nothing and uses nothing up.  The page's script shows the secret: to look at what is
asked (`look`), and, once the camera runs, to begin (the socket), which uses the link up.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Form, Request, WebSocket
from fastapi import Path as InPath
from fastapi.responses import JSONResponse, RedirectResponse, Response

from moireid.names import NAME_LIMIT
from moireid.verifier.report.live_receipt import FilmAsked
from moireid_studio.auth.guard import Visitor, anyone, require
from moireid_studio.challenge.challenge import FACE
from moireid_studio.challenge.clock import MOVES
from moireid_studio.forms import ShortRoute
from moireid_studio.http.addresses import address_for
from moireid_studio.jobs.claims import sealed
from moireid_studio.links import KEEP_DAYS, LASTS_MIN, MOST_PICTURES, MOST_WAITING, Links, OneTimeLink
from moireid_studio.live.routes import claimed_now
from moireid_studio.live.sockets import SessionRequest, serve
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.receipts import headline_for, name_of, receipt_for
from moireid_studio.store.database import utc_text
from moireid_studio.store.job import Job
from moireid_studio.studio import Studio, studio_of

router = APIRouter(prefix="/links", include_in_schema=False, route_class=ShortRoute)
Verifier = Annotated[Visitor, require("verifier")]
LinkId = Annotated[str, InPath(pattern="^[0-9a-f]{16}$")]
#: Links that the page lists, the newest; letters of how the asker calls themselves.
SHOWN, LONGEST_ASKS = 50, 80
WORDS = {
    "waiting": "not opened yet",
    "opened": "opened, not begun",
    "running": "the check runs",
    "late": "not used in time",
    "broken": "broken off, no verdict",
    "done": "done",
}


@router.get("")
def listed(request: Request, visitor: Verifier, claim: str = "", about: str = "") -> Response:
    """Make a link, and see what became of others; about: the job of the film that it is about."""
    studio = studio_of(request)
    film = _film_of(studio, about, visitor)
    rows = [_shown(studio, link) for link in studio.links.of_asker(visitor.id, SHOWN)]
    claim = claim[:NAME_LIMIT] or (film.claim if film else "")
    more = {"asks": visitor.note[:LONGEST_ASKS], "about": film, "count": studio.registry.count()}
    return _page(request, "links.html.j2", rows=rows, claim=claim, **more)


@router.post("")
def make(
    request: Request,
    visitor: Verifier,
    claim: Annotated[str, Form(max_length=NAME_LIMIT)],
    asks: Annotated[str, Form(max_length=LONGEST_ASKS)],
    pictures: Annotated[bool, Form()] = False,
    about: Annotated[str, Form(max_length=32)] = "",
) -> Response:
    """Make a link, and show it, this once."""
    if not asks.strip() or not asks.strip().isprintable():
        raise Refusal(422, "fields", "Say in one line who asks; the other person reads it.")
    studio, ids, address = studio_of(request), visitor.may("issuer"), address_for(request)
    found = claimed_now(studio, claim.strip(), ids=ids)
    if found.badge.id is None:
        raise Refusal(422, "no_id", "This badge has no identity, so no one can be asked for it.")
    film = _film_of(studio, about, visitor)
    if film is not None and film.claimed_id != found.badge.id:
        raise Refusal(422, "claim", "The film is said to show someone else; ask that person about it.")
    shown = None if film is None else FilmAsked.of(film.film_name, film.film_sha256 or "")
    made = studio.links.make(visitor.id, asks.strip(), found.badge.id, ids=ids, wants_pictures=pictures, film=shown)
    if made is None:
        raise Refusal(503, "busy", f"{MOST_WAITING} of your links wait to be used; remove some, or wait for them.")
    secret, link = made
    return _page(request, "link_made.html.j2", shown=_shown(studio, link), address=address, secret=secret)


@router.get("/{link_id}")
def outcome(request: Request, link_id: LinkId, visitor: Verifier) -> Response:
    """What became of a link."""
    studio = studio_of(request)
    link = _mine(studio, link_id, visitor)
    event = json.loads(link.report) if link.report else None
    count = len(studio.links.pictures(link))
    return _page(request, "link.html.j2", shown=_shown(studio, link), event=event, pictures=count)


@router.get("/{link_id}/report")
def report(request: Request, link_id: LinkId, visitor: Verifier) -> Response:
    """The verdict with all its findings and figures, as JSON, to keep."""
    link = _done(studio_of(request), link_id, visitor)
    return _file(link.report or "", f"moireid-{link.id}-report.json")


@router.get("/{link_id}/receipt")
def receipt(request: Request, link_id: LinkId, visitor: Verifier) -> Response:
    """Who was checked when, with what outcome, and the digest of the report, as JSON, to keep."""
    studio = studio_of(request)
    link = _done(studio, link_id, visitor)
    content = receipt_for(studio, link).to_json()
    return _file(json.dumps(content, ensure_ascii=False, indent=1) + "\n", f"moireid-{link.id}-receipt.json")


@router.get("/{link_id}/picture/{number}")
def picture(request: Request, link_id: LinkId, number: int, visitor: Verifier) -> Response:
    """A picture that both agreed to keep.  It is a stranger's: it may run and load nothing."""
    studio = studio_of(request)
    kept = studio.links.pictures(_mine(studio, link_id, visitor))
    if not 0 <= number < len(kept):
        raise Refusal(404, "no_picture", "There is no such picture.")
    return Response(kept[number], media_type="image/jpeg", headers={"Content-Security-Policy": "sandbox"})


@router.post("/{link_id}/remove")
def remove(request: Request, link_id: LinkId, visitor: Verifier) -> Response:
    """Remove a link, with its result and pictures."""
    studio = studio_of(request)
    studio.links.remove(_mine(studio, link_id, visitor))
    return RedirectResponse("/links", 303)


def _film_of(studio: Studio, job_id: str, visitor: Visitor) -> Job | None:
    """The visitor's own judged film; None where none is named.  Raises: Refusal 404, 409."""
    if not job_id:
        return None
    job = studio.jobs.find(job_id, visitor.id, "verify")
    if job.film_sha256 is None:
        raise Refusal(409, "not_ready", "This film is not judged yet.")
    return job


def _mine(studio: Studio, link_id: str, visitor: Visitor) -> OneTimeLink:
    """A link of this asker.  Raises: Refusal 404 where it is another's, or none."""
    link = studio.links.find(link_id, visitor.id)
    if link is None:
        raise Refusal(404, "no_link", "You made no such link, or it was removed.")
    return link


def _done(studio: Studio, link_id: str, visitor: Visitor) -> OneTimeLink:
    link = _mine(studio, link_id, visitor)
    if link.report is None:
        raise Refusal(409, "not_ready", "This link has no verdict.")
    return link


def _shown(studio: Studio, link: OneTimeLink) -> dict[str, Any]:
    """A link as its page shows it, by the name known now.  Raises: RegistryError as `headline_for`."""
    name, headline = name_of(studio, link), headline_for(studio, link)
    return {"link": link, "name": name, "headline": headline, "words": WORDS[link.state]}


def _page(request: Request, template: str, **context: Any) -> Response:
    return render(request, template, keep_days=KEEP_DAYS, minutes=LASTS_MIN, moment=moment, **context)


def _file(text: str, name: str) -> Response:
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(text.encode(), media_type="application/json", headers=headers)


#: The other side, which has the secret and no token.
check_router = APIRouter(prefix="/check", dependencies=[anyone], include_in_schema=False, route_class=ShortRoute)
#: A secret has 43 letters.
LONGEST_SECRET = 100
NO_LINK = "This link is none of this studio's; ask for another."


@check_router.get("")
def check_page(request: Request) -> Response:
    """The same page for every link."""
    return render(request, "check.html.j2", moves=MOVES, face=FACE)


@check_router.post("/look")
def look(request: Request, token: Annotated[str, Form(max_length=LONGEST_SECRET)] = "") -> Response:
    """What a link asks; it is not used up."""
    studio = studio_of(request)
    try:
        link = usable(studio, token)
    except Refusal as refusal:
        return JSONResponse({"text": refusal.text}, refusal.status)
    studio.links.note_opened(link)
    film = None if link.film is None else {"name": link.film.name, "sha256": link.film.sha256}
    said = {"asks": link.asks, "name": name_of(studio, link), "pictures": link.wants_pictures, "film": film}
    return JSONResponse(said)


@check_router.websocket("/socket")
async def socket(connection: WebSocket) -> None:
    """The check."""
    studio = studio_of(connection)
    await serve(connection, lambda hello: _asked(studio, hello))


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
    now = utc_text()
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
