"""One session over a WebSocket: pictures in, events out.

Pictures go to the session's own process (`worker.py`), and events come back.  A session ends with its connection.
The browser may have a few pictures on the way, and drops those that it cannot send.  Pictures that come too fast wait
in the network, not here.

Messages of the browser: first JSON that says what is asked; then pictures (eight bytes of its clock in ms as a
big-endian float, then a JPEG), and JSON {"do": "challenge"}, {"do": "end"} or {"do": "moved"}.  All answers are the
events of `moireid_studio.challenge`, and: ready, taken, error.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import struct
import time
from collections import Counter
from collections.abc import Callable, Mapping, MutableMapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, get_args

import anyio
from fastapi import WebSocket, WebSocketDisconnect
from starlette.concurrency import run_in_threadpool

from moireid.errors import MoireIdError
from moireid.question import CheckLevel, Question
from moireid.registry import holder_of
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ProcessEnd, start
from moireid.verifier.reasons import Verdict
from moireid.verifier.report.circumstances import Circumstances, read_id
from moireid.verifier.session.known_figures import checked_figures
from moireid_studio.challenge.challenge import Prompt, draw_prompts
from moireid_studio.challenge.clock import CALL, HERE
from moireid_studio.challenge.live_headline import live_headline_of, shown
from moireid_studio.live.worker import LIMITS, Ask, LivePicture, PictureEnd, Start
from moireid_studio.problems import Refusal
from moireid_studio.studio import Studio, studio_of

#: Sessions at a time of those who have a token, and of those who have a link; sessions by one token, and by its links.
MOST_SESSIONS, MOST_BY_LINK, MOST_OF_ONE = 4, 2, 3
#: How long a session may last, and send no message; and how long a socket may say nothing at all, as a browser asks as
#: soon as it is open, s.
SESSION_S, IDLE_S, ASK_S = 300.0, 30.0, 5.0
#: Bytes of a picture at most, letters of a message, and pictures a second.
MOST_BYTES, MOST_LETTERS, MOST_RATE = 1 << 20, 1000, 60.0
#: Time between two checks that a session is still allowed, s.
LOOK_S = 5.0
CLOCK = struct.Struct(">d")
BUSY = "Other live checks are running, as many as this machine can do; try again in a minute."


@dataclass(frozen=True)
class SessionRequest:
    """What a session is about.

    found: the claimed badge, of which the session's process learns what `given` says alone; asked_by: the token of
    the asker; kind: "live", "call", "link" or "enroll"; allowed: whether the session may go on; begun: called once
    there is room, just before it begins, and raises Refusal where it must not; picture: gets each picture; on_event:
    gets the answers to prompts, and the verdict; ended: called when the session is over, however that came.
    """

    found: Question
    given: Question
    asked_by: str
    kind: str
    allowed: Callable[[], bool]
    begun: Callable[[], None] = lambda: None
    picture: Callable[[bytes], None] | None = None
    on_event: Callable[[dict[str, Any]], None] = lambda _: None
    ended: Callable[[], None] = lambda: None

    @property
    def in_call(self) -> bool:
        """Whether the pictures are of a call's tile."""
        return self.kind == "call"

    @property
    def by_link(self) -> bool:
        """Whether a stranger sends the pictures, and who asks is not there: that one must not leave the prompts out."""
        return self.kind == "link"

    @property
    def enrolling(self) -> bool:
        """Whether the badge is measured for its enrolment."""
        return self.kind == "enroll"

    def question(self, level: CheckLevel | None) -> Question:
        """What the session's process is asked; level: the least that must be reached here."""
        return self.given.without_figures() if self.enrolling else replace(self.given, level=level)


async def serve(connection: WebSocket, ask: Callable[[Mapping[str, Any]], SessionRequest]) -> None:
    """One session; ask: makes of the browser's first message what is asked, or raises Refusal or MoireIdError."""
    await connection.accept()
    studio = studio_of(connection)
    try:
        async with asyncio.timeout(SESSION_S):
            message = _message(await asyncio.wait_for(connection.receive(), ASK_S))
            await _in_its_place(connection, await run_in_threadpool(ask, message))
    except MoireIdError as error:
        await _refuse(connection, studio.sentence(error))
    except Refusal as refusal:
        await _refuse(connection, refusal.text)
    except TimeoutError:
        await _refuse(connection, "This session has come to its end; begin another.")
    except WebSocketDisconnect:
        pass
    finally:
        # A visitor who has left, or already got a refusal, needs no closing.
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            await connection.close()


async def _in_its_place(connection: WebSocket, asked: SessionRequest) -> None:
    """Run the session if there is a place for it, and give the place back."""
    sessions, one = studio_of(connection).live_sessions, (asked.by_link, asked.asked_by)
    # Two budgets: neither links, which strangers use, nor tokens can take all places.
    such = sum(count for (by_link, _), count in sessions.items() if by_link is asked.by_link)
    if such >= (MOST_BY_LINK if asked.by_link else MOST_SESSIONS) or sessions[one] >= MOST_OF_ONE:
        raise Refusal(503, "busy", BUSY)
    sessions[one] += 1
    try:
        await run_in_threadpool(asked.begun)
        try:
            await _session(connection, asked)
        finally:
            with anyio.CancelScope(shield=True):
                await run_in_threadpool(asked.ended)
    finally:
        sessions -= Counter((one,))


async def _session(connection: WebSocket, asked: SessionRequest) -> None:
    # It needs no file at all: the pictures come with the messages.
    child = await run_in_threadpool(start, "moireid_studio.live.worker:serve", LIMITS, within=reach())
    tasks: list[asyncio.Task[None]] = []
    try:
        question = asked.question(studio_of(connection).settings.level)
        begin = Start(question, asked.in_call, required=asked.by_link or asked.enrolling)
        await run_in_threadpool(child.send, begin)
        prompted = asyncio.Event()
        coming = asyncio.create_task(_pictures(connection, child, asked, prompted))
        going = asyncio.create_task(_events(connection, child, asked, prompted))
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


async def _pictures(connection: WebSocket, child: Child, asked: SessionRequest, prompted: asyncio.Event) -> None:
    """Pass the browser's pictures to the process, with their time of arrival, until the browser asks for the end.

    Parameters: prompted: is set once the process has prompts.
    """
    room, last_s = MOST_RATE, time.monotonic()
    looked_s = last_s
    while True:
        message: MutableMapping[str, Any] = await asyncio.wait_for(connection.receive(), IDLE_S)
        now_s = time.monotonic()
        if now_s - looked_s > LOOK_S:
            # A token that was revoked meanwhile ends the session.
            looked_s = now_s
            if not await run_in_threadpool(asked.allowed):
                raise WebSocketDisconnect(1008)
        data = message.get("bytes")
        room = min(room + (now_s - last_s) * MOST_RATE, MOST_RATE) - 1
        last_s = now_s
        if room < 0:
            # Faster than any camera's page sends.
            raise WebSocketDisconnect(1009)
        if data is None:
            wish = _message(message).get("do")
            if wish in ("end", "moved"):
                await _send(child, PictureEnd(moved=wish == "moved"))
                return
            if wish == "challenge" and not prompted.is_set():
                prompted.set()
                await _send(child, Ask(now_s, _prompts(connection, asked)))
            continue
        if len(data) > MOST_BYTES or len(data) <= CLOCK.size:
            raise WebSocketDisconnect(1009)
        claimed_ms = CLOCK.unpack_from(data)[0]
        claimed_s = claimed_ms / 1000 if math.isfinite(claimed_ms) else math.nan
        if asked.picture is not None:
            await run_in_threadpool(asked.picture, data[CLOCK.size :])
        await _send(child, LivePicture(data[CLOCK.size :], now_s, claimed_s))


def _prompts(connection: WebSocket, asked: SessionRequest) -> list[Prompt]:
    """Prompts are drawn at random; a test puts its own in their place."""
    drawn: list[Prompt] | None = getattr(connection.app.state, "live_prompts", lambda _: None)(0.0)
    return drawn or draw_prompts(0.0, pace=CALL if asked.in_call else HERE)


async def _events(connection: WebSocket, child: Child, asked: SessionRequest, prompted: asyncio.Event) -> None:
    """Pass the process's events to the browser until its verdict, which is written down, with a headline.

    The process that reads pictures never learns whose badge it has read.
    """
    finished = False
    with contextlib.suppress(ProcessEnd):
        while not finished and (event := await run_in_threadpool(child.hear)):
            finished = event.get("event") in ("verdict", "error")
            if event.get("event") == "verdict":
                event = own_words(event, asked, prompted=prompted.is_set(), sealed=child.sealed or ())
                figures = event.pop("as_built", None)
                if figures is not None:
                    event["review"] = await run_in_threadpool(_review, studio_of(connection), asked, figures)
                event["headline"] = await run_in_threadpool(_headline, studio_of(connection), event, asked)
            if event.get("event") in ("prompted", "verdict"):
                await run_in_threadpool(asked.on_event, event)
            await connection.send_json(event)
    if not finished:
        await connection.send_json({"event": "error", "text": "The check broke off; begin again."})
    await connection.close()


def own_words(
    event: Mapping[str, Any], asked: SessionRequest, *, prompted: bool, sealed: tuple[str, ...]
) -> dict[str, Any]:
    """A verdict with the server's own word on what its process, which may be in a stranger's hands, need not say.

    Parameters: prompted: whether there were prompts; without, and in a check that was not passed, nothing is measured;
        sealed: the parts of the process's seal that hold.
    Raises: ProcessEnd where it is no verdict.
    """
    import cv2

    if event.get("verdict") not in get_args(Verdict):
        raise ProcessEnd("crash", "gave a verdict that is none")
    challenged, stated = prompted and event.get("challenged") is True, asked.found.stated()
    own: dict[str, Any] = {name: stated[name] for name in ("claim_source", "registry")} | {"challenged": challenged}
    own |= {"sealed": list(sealed), "input": {"decoder": f"OpenCV {cv2.__version__}"}}
    measured = asked.enrolling and challenged and event["verdict"] == "accept"
    return {name: value for name, value in event.items() if measured or name != "as_built"} | own


def _headline(studio: Studio, event: dict[str, Any], asked: SessionRequest) -> dict[str, str]:
    """The verdict in a line, by the names that the registry knows.  Raises: RegistryError as `holder_of`."""
    known = Circumstances(datetime.now(UTC))
    # The person with the link learns nothing of other people's badges: the asker's own page says whose was shown.
    if not asked.by_link:
        read = holder_of(studio.registry, read_id(event))
        known = replace(known, read=read, standing=asked.found.provenance.standing)
    return shown(live_headline_of(event, asked.found.badge.name, known))


def _review(studio: Studio, asked: SessionRequest, figures: object) -> str:
    """The page on which what a live check measured is kept, as of a capture.  Raises: SpecError, Refusal."""
    found = checked_figures(figures, asked.found.badge)
    with studio.jobs.receiving("capture", asked.asked_by, "issuer") as job:
        job.label = asked.found.badge.name
        job.result = {"kind": "capture", "id": found.badge_id, "as_built": json.loads(found.to_json())}
        studio.jobs.keep(job)
    return f"/enroll/{job.id}"


async def _send(child: Child, message: Any) -> None:
    # A process that has ended reads no more; its last messages are on their way.
    with contextlib.suppress(ProcessEnd):
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
