"""The live check: a page, and the WebSocket that its camera's pictures come through.

Pictures go to the session's own process (`worker.py`), and events come back.  Nothing is kept: a session ends with its
connection.  The browser may have a few pictures on the way, and drops those that it cannot send.  Pictures that come
too fast wait in the network, not here.

Messages of the browser: first JSON with "claim"; then pictures (eight bytes of its clock in ms as a big-endian float,
then a JPEG), and JSON {"do": "challenge"} or {"do": "end"}.  All answers are the events of `verifier.live`, and: ready,
taken, error.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import struct
import time
from collections import Counter
from collections.abc import Callable, MutableMapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import anyio
from fastapi import APIRouter, Request, Response, WebSocket, WebSocketDisconnect
from starlette.concurrency import run_in_threadpool

from moireid.errors import MoireIdError, RegistryError
from moireid.registry import holder_of
from moireid.sandbox.process import Child, Ended, start
from moireid.sandbox.reach import reach
from moireid.verifier.live.challenge import FACE, HOLD_S, Prompt, draw_prompts
from moireid.verifier.live.pace import MOVES
from moireid.verifier.report.circumstances import Circumstances, read_id
from moireid.verifier.report.live_headline import live_headline_of, shown
from moireid.web.auth.roles import require, visitor_of
from moireid.web.checks import find_claimed, sealed
from moireid.web.live.worker import LIMITS, Ask, End, Picture, Start
from moireid.web.pages.render import render
from moireid.web.problems import Refusal
from moireid.web.studio import Studio, studio_of

router = APIRouter(dependencies=[require("verifier")], include_in_schema=False)
#: Sessions at a time in all, and with one token; seconds that one may last, and that it may send no message.
MOST_SESSIONS, MOST_OF_ONE, SESSION_S, IDLE_S = 4, 3, 300.0, 30.0
#: Bytes of a picture at most, letters of a message, and pictures a second.
MOST_BYTES, MOST_LETTERS, MOST_RATE = 1 << 20, 1000, 60.0
#: Time between two checks that a session's token is still valid, s.
LOOK_S = 5.0
CLOCK = struct.Struct(">d")
BUSY = "Other live checks are running, as many as this machine can do; try again in a minute."
Prompts = Callable[[float], list[Prompt]]


@router.get("/live")
def page(request: Request, claim: str = "") -> Response:
    """The camera, the running verdict, and the challenge."""
    return render(request, "live.html.j2", claim=claim[:200], moves=MOVES, hold_s=HOLD_S, face=FACE)


@router.websocket("/live/socket")
async def socket(connection: WebSocket) -> None:
    """One session.  Prompts are drawn at random; a test puts its own in their place."""
    await connection.accept()
    sessions, visitor = _sessions(studio_of(connection)), visitor_of(connection)
    owner = visitor.id if visitor else ""
    if sessions.total() >= MOST_SESSIONS or sessions[owner] >= MOST_OF_ONE:
        await _refuse(connection, BUSY)
        return
    sessions[owner] += 1
    try:
        async with asyncio.timeout(SESSION_S):
            await _session(connection, getattr(connection.app.state, "live_prompts", draw_prompts))
    except TimeoutError:
        await _refuse(connection, "This session has come to its end; begin another.")
    except WebSocketDisconnect:
        pass
    finally:
        # In place, and without those who have none left.
        sessions -= Counter((owner,))
        # A visitor who has left, or already got a refusal, needs no closing.
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            await connection.close()


def _sessions(studio: Studio) -> Counter[str]:
    """How many sessions are open in a studio, by token."""
    found: Counter[str] = studio.__dict__.setdefault("live_sessions", Counter())
    return found


async def _session(connection: WebSocket, prompts: Prompts) -> None:
    first: MutableMapping[str, Any] = await asyncio.wait_for(connection.receive(), IDLE_S)
    claim = _message(first).get("claim")
    if not isinstance(claim, str) or not claim.strip():
        await _refuse(connection, "Name the person whose badge is to be seen.")
        return
    try:
        visitor = visitor_of(connection)
        ids = visitor is not None and visitor.may("issuer")
        begin = await run_in_threadpool(_start, studio_of(connection), claim.strip(), ids=ids)
        given = begin if ids else Start(await run_in_threadpool(sealed, begin.found))
    except MoireIdError as error:
        await _refuse(connection, studio_of(connection).sentence(error))
        return
    except Refusal as refusal:
        await _refuse(connection, refusal.text)
        return
    # It needs no file at all: the pictures come with the messages.
    child = await run_in_threadpool(start, "moireid.web.live.worker:serve", LIMITS, within=reach())
    tasks: list[asyncio.Task[None]] = []
    try:
        await run_in_threadpool(child.send, given)
        coming = asyncio.create_task(_pictures(connection, child, prompts))
        going = asyncio.create_task(_events(connection, child, begin))
        tasks = [coming, going]
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        if coming.done() and coming.exception() is None:
            # The browser has asked for the end; only the verdict is still to be sent.
            await asyncio.wait({going})
    finally:
        # However the session ends, its process ends with it.
        with anyio.CancelScope(shield=True):
            await _leave(child, tasks)
    for task in tasks:
        why = None if task.cancelled() else task.exception()
        if why is not None and not isinstance(why, WebSocketDisconnect):
            raise why


async def _leave(child: Child, tasks: list[asyncio.Task[None]]) -> None:
    """End the process of a session, so that threads waiting for it go on; then end its tasks."""
    await run_in_threadpool(child.kill)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def _start(studio: Studio, claim: str, *, ids: bool) -> Start:
    """The claim in the form that the process needs.

    Raises: Refusal where the claim means nobody, or several people; RegistryError where the badge does not count.
    """
    standing = studio.standing()
    found = find_claimed(studio.registry, claim, ids=ids)
    found = replace(found, provenance=replace(found.provenance, standing=standing))
    if (barred := found.barred) is not None:
        was = "expired" if barred.code == "expired" else f"was {barred.code}"
        advice = "have it reinstated, or issue another" if barred.code == "suspended" else "issue another"
        raise RegistryError(f"the badge of {found.badge.name} {was} ({barred.reason}); {advice}")
    return Start(found)


async def _pictures(connection: WebSocket, child: Child, prompts: Prompts) -> None:
    """Pass the browser's pictures to the process, with their time of arrival, until the browser asks for the end."""
    asked, room, last_s = False, MOST_RATE, time.monotonic()
    looked_s = last_s
    while True:
        message: MutableMapping[str, Any] = await asyncio.wait_for(connection.receive(), IDLE_S)
        now_s = time.monotonic()
        if now_s - looked_s > LOOK_S:
            # A token that was revoked meanwhile ends the session.
            looked_s = now_s
            if await run_in_threadpool(visitor_of, connection) is None:
                raise WebSocketDisconnect(1008)
        data = message.get("bytes")
        room = min(room + (now_s - last_s) * MOST_RATE, MOST_RATE) - 1
        last_s = now_s
        if room < 0:
            # Faster than any camera's page sends.
            raise WebSocketDisconnect(1009)
        if data is None:
            wish = _message(message).get("do")
            if wish == "end":
                await _send(child, End())
                return
            if wish == "challenge" and not asked:
                asked = True
                await _send(child, Ask(now_s, prompts(0.0)))
            continue
        if len(data) > MOST_BYTES or len(data) <= CLOCK.size:
            raise WebSocketDisconnect(1009)
        claimed_ms = CLOCK.unpack_from(data)[0]
        claimed_s = claimed_ms / 1000 if math.isfinite(claimed_ms) else math.nan
        await _send(child, Picture(data[CLOCK.size :], now_s, claimed_s))


async def _events(connection: WebSocket, child: Child, begun: Start) -> None:
    """Pass the process's events to the browser until the process ends; the verdict is written down, with a headline.

    The process that reads pictures never learns whose badge it has read.
    """
    told = False
    with contextlib.suppress(Ended):
        while event := await run_in_threadpool(child.hear):
            told = told or event.get("event") in ("verdict", "error")
            if event.get("event") == "verdict":
                await run_in_threadpool(_note, connection, begun, event)
                event["headline"] = await run_in_threadpool(_headline, studio_of(connection), event, begun)
            await connection.send_json(event)
    if not told:
        await connection.send_json({"event": "error", "text": "The check broke off; begin again."})
    await connection.close()


def _headline(studio: Studio, event: dict[str, Any], begun: Start) -> dict[str, str]:
    """The verdict in a line, by the names that the registry knows.  Raises: RegistryError as `holder_of`."""
    read = holder_of(studio.registry, read_id(event))
    known = Circumstances(datetime.now(UTC), read=read, standing=begun.found.provenance.standing)
    return shown(live_headline_of(event, begun.found.badge.name, known))


def _note(connection: WebSocket, begun: Start, event: dict[str, Any]) -> None:
    """Write down the verdict of a session."""
    visitor, found = visitor_of(connection), begun.found
    about = {"film_sha256": None, "claim": found.badge.id, "claim_source": found.provenance.source}
    standing = found.provenance.standing
    studio_of(connection).note_verdict(visitor.id if visitor else "", "live", event, **about, standing=standing)


async def _send(child: Child, message: Any) -> None:
    # A process that has ended reads no more; its last messages are on their way.
    with contextlib.suppress(Ended):
        await run_in_threadpool(child.send, message)


def _message(message: MutableMapping[str, Any]) -> dict[str, Any]:
    """A text message's JSON object; raises WebSocketDisconnect where it is none."""
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1000))
    text = message.get("text")
    if text is None or len(text) > MOST_LETTERS:
        raise WebSocketDisconnect(1003)
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise WebSocketDisconnect(1003) from error
    return found if isinstance(found, dict) else {}


async def _refuse(connection: WebSocket, text: str) -> None:
    # A visitor who has left needs no answer.
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await connection.send_json({"event": "error", "text": text})
        await connection.close()
