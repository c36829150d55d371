"""The process that judges: pictures in, events out.

It is sealed before it reads anything of a stranger's.  Three threads: one listens to the process that started us, one
decodes the source, and this one judges.  Running verdicts have one more.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from moireid.errors import MoireIdError
from moireid.sandbox.child import Talk
from moireid.verifier.limits import MIN_COVER_SHARE
from moireid.verifier.picture import Picture
from moireid.verifier.reasons import Reason
from moireid.verifier.session.threads import live_executor
from moireid_studio.challenge.challenge import from_start
from moireid_studio.challenge.stream import StreamCheck
from moireid_studio.watch.order import Data, Event, Shot, StreamEnd, WatchOrder
from moireid_studio.watch.readers import Inbox, PipeBytes, TimedPicture, pictures

if TYPE_CHECKING:
    from concurrent.futures import Executor

#: Steps between pictures from which the rate is estimated.
RATE_STEPS = 240
#: A source whose pictures change their size more often is given up.
MOST_SIZES = 20


class Voice:
    """Sends events to the process that started us; for any thread."""

    def __init__(self, talk: Talk) -> None:
        self._talk, self._lock = talk, threading.Lock()

    def send(self, answer: dict[str, Any]) -> None:
        """Send one event or wish."""
        with self._lock:
            self._talk.send(answer)


def serve(talk: Talk) -> None:
    """Judge one source."""
    order = talk.next()
    if not isinstance(order, WatchOrder):
        return
    voice = Voice(talk)
    inbox = Inbox(waits=not order.source.live(challenged=order.prompts is not None))
    piped = PipeBytes(voice.send)
    ears = threading.Thread(target=_listen, args=(talk, inbox, piped), daemon=True)
    with live_executor() as aside:
        try:
            watching = Watching(order, voice, inbox, aside)
            _begin_source(order, inbox, piped)
            ears.start()
            watching.run()
        except MoireIdError as error:
            voice.send({"event": "error", "text": " ".join(str(error).split())})


def _listen(talk: Talk, inbox: Inbox, piped: PipeBytes) -> None:
    """Hand on what comes: bytes to the decoder, all else to the judge."""
    while (message := talk.next()) is not None:
        if isinstance(message, Data):
            piped.give(message)
        elif isinstance(message, Shot):
            luma = np.frombuffer(message.luma, np.uint8).reshape(message.size)
            inbox.put_picture(TimedPicture(Picture(luma), message.claimed_s, message.arrival_s))
        else:
            inbox.put(message)
    inbox.put(StreamEnd())


def _begin_source(order: WatchOrder, inbox: Inbox, piped: PipeBytes) -> None:
    """Begin to decode, for a source whose pictures are made here."""
    if order.source.kind == "camera":
        return

    def decode() -> None:
        try:
            pictures(order.source, piped, inbox, order.patience)
            inbox.put_last(StreamEnd("source"))
        except MoireIdError as error:
            inbox.put_last(StreamEnd("failed", " ".join(str(error).split())))
        # A thread that dies would leave the judge to wait; whatever a stranger's stream breaks ends the stream alone.
        except Exception as error:  # noqa: BLE001
            words = f"{type(error).__name__}: {' '.join(str(error).split())[:160]}"
            inbox.put_last(StreamEnd("failed", f"{order.source.shown} broke its decoder ({words})"))

    threading.Thread(target=decode, daemon=True).start()


class Watching:
    """One source from its first picture to the verdict."""

    def __init__(self, order: WatchOrder, voice: Voice, inbox: Inbox, aside: Executor) -> None:
        self._order, self._voice, self._inbox, self._aside = order, voice, inbox, aside
        self._check = self._anew()
        self._size: tuple[int, int] | None = None
        self._sizes, self._taken, self._before, self._covered = 0, 0, 0, 0.0
        self._last_s, self._steps_s = math.nan, deque[float](maxlen=RATE_STEPS)
        self._verdict: Event = {}

    def run(self) -> None:
        """Judge until the source ends, gives nothing more, or the verdict is asked for."""
        end = StreamEnd()
        while not self._check.ended:
            item = self._inbox.get(self._patience_s)
            if isinstance(item, TimedPicture):
                self._take(item)
            elif isinstance(item, StreamEnd):
                end = item
                break
            else:
                end = StreamEnd("silent", f"{self._order.source.shown} gave no picture for {self._patience_s:.0f} s")
                break
        self._send_end(end)

    @property
    def _patience_s(self) -> float:
        """How long the next picture may take, s."""
        return self._order.patience.stall_s if self._taken else self._order.patience.open_s

    def _anew(self) -> StreamCheck:
        order = self._order
        challenged = order.prompts is not None
        live = order.source.live(challenged=challenged)
        check = StreamCheck(
            order.question,
            live=live,
            challenged=challenged,
            draw=from_start(order.prompts or ()),
            aside=self._aside,
        )
        if challenged:
            check.ask(0.0)
        return check

    def _take(self, taken: TimedPicture) -> None:
        """Judge a picture; one of another size begins a new check, unless what came before is a lie."""
        size = taken.picture.shape
        if self._size is None:
            self._voice.send({"event": "begun", "width": size[1], "height": size[0]})
        elif size != self._size and not self._changed(size):
            return
        self._size, self._taken = size, self._taken + 1
        if (step_s := taken.claimed_s - self._last_s) > 0:
            self._steps_s.append(step_s)
        self._last_s = taken.claimed_s
        for event in self._check.push(taken.picture, taken.claimed_s, taken.arrival_s):
            if event["event"] != "verdict":
                self._voice.send(event)
            else:
                self._verdict = event

    def _changed(self, size: tuple[int, int]) -> bool:
        """Begin anew with pictures of another size; False where the check has ended by it."""
        self._sizes += 1
        before = self._check.finish()
        if before["verdict"] == "reject" or before["challenged"] or self._sizes > MOST_SIZES:
            self._verdict = before
            return False
        self._voice.send(
            {"event": "anew", "text": f"The pictures are now {size[1]} x {size[0]}; the check begins anew."}
        )
        if before["verdict"] == "accept":
            self._covered += before["cover"]["share"] * self._taken
        self._check, self._taken, self._before = self._anew(), 0, self._before + self._taken
        return True

    def _of_all(self, event: Event) -> Event:
        """The verdict held against all that came: pictures of another size that were not accepted are not covered."""
        if event["verdict"] != "accept" or event["challenged"]:
            return event
        asked, total = self._order.question.cover_share, self._taken + self._before
        least = MIN_COVER_SHARE if asked is None else asked
        share = (self._covered + event["cover"]["share"] * self._taken) / total
        if share >= least:
            return event
        text = f"The verdict covers {100 * share:.0f} % of the pictures, as they changed their size"
        cover = Reason("cover", "undecided", share, least, "share", f"{text}; at least {100 * least:.0f} % are needed.")
        others = [one for one in event["reasons"] if one["code"] != "cover"]
        return event | {"verdict": "inconclusive", "reasons": [*others, cover.to_json()]}

    def _send_end(self, end: StreamEnd) -> None:
        """Send the verdict on what came; without any picture, why there is none."""
        if self._size is None:
            self._voice.send({"event": "error", "text": end.words or f"{self._order.source.shown} gave no picture"})
            return
        event = self._verdict if self._check.ended else self._check.finish()
        if not event["frames"]["read"]:
            words = end.words or "send them for some seconds, and in time"
            self._voice.send(
                {"event": "error", "text": f"{self._taken} pictures came, and none could be used; {words}"}
            )
            return
        height, width = self._size
        fps = 1 / float(np.median(self._steps_s)) if self._steps_s else 1.0
        film = {"path": self._order.source.shown, "sha256": None, "width": width, "height": height, "fps": fps}
        left_out = list(event["left_out"])
        if self._inbox.lost:
            left_out.append(f"{self._inbox.lost} pictures that came faster than this machine could judge them")
        if self._before:
            left_out.append(f"{self._before} pictures of another size, which came before")
        ended = {"why": end.why, "text": end.words}
        self._voice.send(self._of_all(event) | {"input": film, "left_out": left_out, "end": ended})
