"""Our side of a watch: start the judge, feed it, take its events, and end it."""

from __future__ import annotations

import hashlib
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from moireid.errors import MediaError, MoireIdError, SpecError
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ProcessEnd, start
from moireid.sandbox.seal import ProcessLimits
from moireid.verifier.video import decoder_version
from moireid_studio.watch.feeding import Feeder
from moireid_studio.watch.order import Event, StreamEnd, WatchOrder
from moireid_studio.watch.source import Source

#: Of the judge: of 4K pictures some wait, and some are in the decoder.
LIMITS = ProcessLimits(memory_bytes=2 << 30, file_bytes=0)
#: Time between two looks at whether the verdict is wanted, and for the verdict once it is wanted, s.
LOOK_S, VERDICT_S = 0.1, 120.0


def watch(order: WatchOrder, seconds: float, stop: threading.Event, notify: Callable[[Event], None]) -> Event:
    """Judge a source until it ends, its time is over, or `stop` is set.

    Parameters
    ----------
    seconds
        Of pictures, at most.
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
    feeder = Feeder(source, child)
    try:
        feeder.begin()
        found = _listen(child, feeder, seconds, stop, notify)
    except ProcessEnd as ended:
        raise _broken(ended, order) from ended
    finally:
        feeder.end()
        child.kill()
    digest = feeder.sha256 if source.kind == "pipe" else _digest(order, found)
    found["input"] |= {"sha256": digest, "decoder": _decoder(source)}
    return found | {"sealed": list(child.sealed or ())}


def _started(order: WatchOrder) -> Child:
    films = [Path(order.source.text)] if order.source.kind == "file" else []
    child = start("moireid_studio.watch.judge:serve", LIMITS, within=reach(read=films))
    child.send(order)
    return child


def _listen(
    child: Child, feeder: Feeder, seconds: float, stop: threading.Event, notify: Callable[[Event], None]
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
        if message.get("event") == "verdict":
            return _checked(message)
        if message.get("event") == "error":
            raise MediaError(str(message.get("text", ""))[:1000])
        if message.get("event") == "begun" and last is None:
            last = now + seconds
        if "event" in message:
            notify(message)
        else:
            feeder.answer(message)


def _checked(verdict: dict[str, Any]) -> dict[str, Any]:
    """A verdict of the right shape: its sender has read what a stranger made.  Raises: ProcessEnd where it is not."""
    from moireid.json_schema import report_schema, schema_fault

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
