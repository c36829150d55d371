"""The pages of the live check, of *Check a call* and of the enrolment by a live check, and the WebSockets that their
pictures come through.

No picture is kept: a session ends with its connection (`sockets.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from fastapi import APIRouter, Request, Response, WebSocket

from moireid.errors import RegistryError
from moireid.names import NAME_LIMIT
from moireid.question import Question
from moireid_studio.auth.guard import LOOPBACK, require, visitor_of
from moireid_studio.challenge.challenge import FACE, HOLD_S
from moireid_studio.challenge.chance import LEAST_WIDTH_PX
from moireid_studio.challenge.clock import CALL, MOVES
from moireid_studio.jobs.claims import find_claimed, sealed
from moireid_studio.live.sockets import SessionRequest, serve
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.studio import Studio, studio_of

router = APIRouter(dependencies=[require("verifier")], include_in_schema=False)
enroll_router = APIRouter(dependencies=[require("issuer")], include_in_schema=False)


@router.get("/live")
def live_page(request: Request, claim: str = "") -> Response:
    """The camera, the running verdict, and the challenge."""
    return _live_page(request, claim, enrolling=False)


@router.get("/call")
def call_page(request: Request, claim: str = "") -> Response:
    """The call's window, the tile in it, the running verdict, and prompts to read aloud."""
    return render(request, "call.html.j2", claim=claim[:NAME_LIMIT], moves=CALL.moves, least_px=LEAST_WIDTH_PX)


@enroll_router.get("/live/enroll")
def enroll_page(request: Request, claim: str = "") -> Response:
    """The same, to measure a finished badge while its holder follows prompts."""
    return _live_page(request, claim, enrolling=True)


def _live_page(request: Request, claim: str, *, enrolling: bool) -> Response:
    claim = claim[:NAME_LIMIT]
    return render(request, "live.html.j2", claim=claim, enrolling=enrolling, moves=MOVES, hold_s=HOLD_S, face=FACE)


@enroll_router.websocket("/live/enroll/socket")
async def enroll_socket(connection: WebSocket) -> None:
    """A session of the holder of a finished badge, at this camera."""
    await _serve(connection, "enroll")


@router.websocket("/live/socket")
async def live_socket(connection: WebSocket) -> None:
    """A session of the person at this camera."""
    await _serve(connection, "live")


@router.websocket("/call/socket")
async def call_socket(connection: WebSocket) -> None:
    """A session of the person who is seen in a call."""
    await _serve(connection, "call")


async def _serve(connection: WebSocket, kind: str) -> None:
    await serve(connection, lambda hello: _asked(connection, hello, kind))


def _asked(connection: WebSocket, hello: Mapping[str, Any], kind: str) -> SessionRequest:
    claim = hello.get("claim")
    if not isinstance(claim, str) or not claim.strip():
        raise Refusal(422, "fields", "Name the person whose badge is to be seen.")
    visitor = visitor_of(connection)
    ids = visitor is not None and visitor.may("issuer")
    found = claimed_now(studio_of(connection), claim.strip(), ids=ids)
    given = found if ids else sealed(found)
    asked_by = visitor.id if visitor else LOOPBACK
    return SessionRequest(found, given, asked_by, kind, allowed=lambda: visitor_of(connection) is not None)


def claimed_now(studio: Studio, claim: str, *, ids: bool) -> Question:
    """The claimed badge with the registry's standing.

    Raises: Refusal where the claim means no one, or several people; RegistryError where the badge does not count.
    """
    standing = studio.standing()
    found = find_claimed(studio.registry, claim, ids=ids)
    found = replace(found, provenance=replace(found.provenance, standing=standing))
    if (barred := found.barred) is not None:
        raise RegistryError(f"the badge of {found.badge.name} was revoked ({barred.reason}); issue another")
    return found
