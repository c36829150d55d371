"""Our side of a watch: start the judge, feed it, take its events, and end it."""

from __future__ import annotations

import hashlib
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit, urlunsplit

from moireid.errors import MediaError, MoireIdError, SpecError
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ProcessEnd, start
from moireid.sandbox.seal import ProcessLimits
from moireid.verifier.video import decoder_version
from moireid_studio.watch.feeding import Feeder
from moireid_studio.watch.order import HARMLESS, Event, Signal, StreamEnd, WatchOrder
from moireid_studio.watch.source import Source
from moireid_studio.watch.whip import WhipServer

#: Of the judge: of 4K pictures some wait, and some are in the decoder.
LIMITS = ProcessLimits(memory_bytes=2 << 30, file_bytes=0)
#: Time between two looks at whether the verdict is wanted, and for the verdict once it is wanted, s.
LOOK_S, VERDICT_S = 0.1, 120.0


@dataclass(frozen=True)
class Terms:
    """How a watch is held: seconds of pictures at most; token: for WHIP and WHEP.

    offer, answered: of a participant whom a program of its own connects: the sender's description, and what takes ours.
    """

    seconds: float
    token: str | None = None
    offer: str | None = None
    answered: Callable[[str], None] | None = None


def watch(order: WatchOrder, terms: Terms, stop: threading.Event, notify: Callable[[Event], None]) -> Event:
    """Judge a source until it ends, its time is over, or `stop` is set.

    Parameters
    ----------
    notify
        Called with each event as it comes, but the last.

    Returns
    -------
    Event
        The event of the verdict, with all keys of `verify --json`; "end": why it ended, in words too where it should
        not have; "sealed": what held of the judge's seal, as in `sandbox.seal.MEANS`.  This process states the seal,
        and under "input" the decoder and a digest, as the judge may be in a stranger's hands.

    Raises
    ------
    MediaError
        Where the source cannot be opened, or gives no picture.
    SpecError
        Where a claim or an option cannot be used.
    MissingExtraError
    """
    if os.name == "nt":
        raise SpecError("streams are not judged on Windows, as nothing there seals their decoder; use Linux or macOS")
    source = order.source
    child = _started(order)
    try:
        with _fed(order, terms, child, notify) as feeder:
            found = _listen(child, feeder, terms, stop, notify)
    except ProcessEnd as ended:
        raise _broken(ended, order) from ended
    finally:
        child.kill()
    digest = feeder.sha256 if source.kind == "pipe" else _digest(order, found)
    found["input"] |= {"sha256": digest, "decoder": _decoder(source)}
    return found | {"sealed": list(child.sealed or ())}


def _started(order: WatchOrder) -> Child:
    films = [Path(order.source.text)] if order.source.kind == "file" else []
    child = start("moireid_studio.watch.judge:serve", LIMITS, within=reach(read=films, network=order.source.ports))
    child.send(replace(order, source=_without_password(order.source)))
    return child


def _without_password(source: Source) -> Source:
    """What the judge learns of a source: where we ask the address ourselves, its password is not for the judge."""
    if source.kind not in ("http", "whep"):
        return source
    parts = urlsplit(source.text)
    return replace(source, text=urlunsplit(parts._replace(netloc=parts.netloc.rpartition("@")[2])))


@contextmanager
def _fed(order: WatchOrder, terms: Terms, child: Child, notify: Callable[[Event], None]) -> Iterator[Feeder]:
    """What the judge needs of us: its bytes, its pictures, its sender."""
    feeder = Feeder(order.source, child, terms.token)
    try:
        if terms.offer is not None:
            feeder.send(Signal(terms.offer))
            yield feeder
        elif order.source.kind == "whip":
            with WhipServer(order.source, terms.token, feeder) as door:
                notify({"event": "waiting", "address": door.address, "token": door.token, "here": door.here})
                yield feeder
        else:
            feeder.begin()
            yield feeder
    finally:
        feeder.end()


def _listen(
    child: Child, feeder: Feeder, terms: Terms, stop: threading.Event, notify: Callable[[Event], None]
) -> dict[str, Any]:
    """Take what the judge sends, until its verdict."""
    last: float | None = None
    asked = False
    while True:
        message = child.hear(LOOK_S)
        now = time.monotonic()
        if not asked and (stop.is_set() or (last is not None and now > last)):
            asked, last = True, now + VERDICT_S
            feeder.send(StreamEnd())
        elif asked and last is not None and now > last:
            raise ProcessEnd("crash", f"gave no verdict within {VERDICT_S:.0f} s")
        if message is None:
            continue
        if "event" in message:
            message = harmless(message)
        if message.get("event") == "verdict":
            return _checked(message)
        if message.get("event") == "error":
            raise MediaError(str(message.get("text", ""))[:1000])
        if message.get("event") == "begun" and last is None:
            last = now + terms.seconds
        if "event" in message:
            notify(message)
        elif terms.answered is not None and isinstance(message.get("answer"), str):
            terms.answered(message["answer"])
        else:
            feeder.answer(message)


def harmless(event: Any) -> Any:
    """An event without signs that steer a terminal: its words may be a server's, or a decoder's that was taken over."""
    if isinstance(event, dict):
        return {name: harmless(value) for name, value in event.items()}
    if isinstance(event, list):
        return [harmless(value) for value in event]
    return event.translate(HARMLESS) if isinstance(event, str) else event


def _checked(verdict: dict[str, Any]) -> dict[str, Any]:
    """A verdict of the right shape: its sender has read what a stranger made.  Raises: ProcessEnd where it is not."""
    from moireid.json_schema import schema_fault
    from moireid.verifier.session.result import report_schema

    if schema_fault(verdict, report_schema()) is not None or not isinstance(verdict.get("end"), dict):
        raise ProcessEnd("crash", "gave a verdict that is none")
    return verdict


def _decoder(source: Source) -> str:
    """The program that decodes a source, with its version."""
    if source.kind != "camera":
        return decoder_version()
    import cv2

    return f"OpenCV {cv2.__version__}"


def _digest(order: WatchOrder, found: dict[str, Any]) -> str | None:
    """SHA-256 of a file that was read to its end."""
    if order.source.kind != "file" or found["end"]["why"] != "source":
        return None
    with open(order.source.text, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _broken(ended: ProcessEnd, order: WatchOrder) -> MoireIdError:
    """The process that judged has gone, in words."""
    if ended.kind == "memory":
        return MediaError(f"{order.source.shown} asks for more memory than a stream may have; send smaller pictures")
    how = ended.words if ended.kind == "crash" else f"failed ({ended.kind}: {ended.words[:300]})"
    return MediaError(f"the process that read {order.source.shown} {how}; try again, or give another source")
