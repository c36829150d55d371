"""The process of one live session: pictures in, events out.

Each session has its own process, so that a stranger's pictures that break the decoder break only this process.
It receives `Start`, `Ask`, `LivePicture` and `PictureEnd`; it sends the events of a live check, and ready, taken,
error.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from moireid.errors import MoireIdError
from moireid.question import Question
from moireid.sandbox.child import Talk
from moireid.sandbox.seal import ProcessLimits

if TYPE_CHECKING:
    from moireid_studio.challenge.challenge import Prompt

#: Pictures of more than this many pixels are not decoded: a camera's page asks for 720p.
MOST_PIXELS = 1920 * 1088
LEAST_SIDE = 120
#: Of a session, which writes no file.
LIMITS = ProcessLimits(memory_bytes=1 << 30, cpu_s=600, file_bytes=0)


@dataclass(frozen=True)
class Start:
    """What a session is asked.

    in_call: in a tile of a call; required: without a challenge it is inconclusive.
    """

    question: Question
    in_call: bool = False
    required: bool = False


@dataclass(frozen=True)
class Ask:
    """The wish for a challenge, with our clock's time (s); the prompts' times count from the challenge's beginning."""

    arrival_s: float
    prompts: Sequence[Prompt]


@dataclass(frozen=True)
class LivePicture:
    """A JPEG, with its time of arrival by our clock and the time that the sender claims (s)."""

    jpeg: bytes
    arrival_s: float
    claimed_s: float


@dataclass(frozen=True)
class PictureEnd:
    """The end of the pictures, and the wish for the verdict; moved: because a call's tile is not where it was."""

    moved: bool = False


def serve(talk: Talk) -> None:
    """Serve one session."""
    # OpenCV reads this limit when it is loaded, and checks a picture's size before it allocates memory.
    os.environ["OPENCV_IO_MAX_IMAGE_PIXELS"] = str(MOST_PIXELS)
    if isinstance(start := talk.next(), Start):
        try:
            _session(talk, start)
        except MoireIdError as error:
            talk.send({"event": "error", "text": " ".join(str(error).split())})


def _session(talk: Talk, start: Start) -> None:
    from moireid.verifier.session.threads import live_executor
    from moireid_studio.challenge.challenge import Prompt
    from moireid_studio.challenge.clock import CALL, HERE
    from moireid_studio.challenge.session import LiveCheck

    prompts: Sequence[Prompt] = []

    def draw(start_s: float) -> list[Prompt]:
        return [Prompt(prompt.move, start_s + prompt.at_s) for prompt in prompts]

    with live_executor() as aside:
        pace = CALL if start.in_call else HERE
        check = LiveCheck(start.question, draw=draw, pace=pace, aside=aside, required=start.required)
        talk.send({"event": "ready"})
        size, taken = None, 0
        while not check.ended and (message := talk.next()) is not None:
            if isinstance(message, LivePicture):
                begun_s = time.perf_counter()
                luma = picture(message.jpeg)
                if start.in_call and size is not None and luma is not None and luma.shape != size:
                    talk.send(check.moved())
                    return
                if luma is None or (size is not None and luma.shape != size):
                    text = "A picture could not be read; it must be a JPEG of an even size."
                    talk.send({"event": "error", "text": text})
                    return
                size, taken = luma.shape, taken + 1
                for event in check.push(luma, message.claimed_s, message.arrival_s):
                    talk.send(event)
                judging_ms = round(1000 * (time.perf_counter() - begun_s), 1)
                talk.send({"event": "taken", "frames": taken, "judging_ms": judging_ms})
            elif isinstance(message, Ask):
                prompts = message.prompts
                check.ask(message.arrival_s)
            else:
                talk.send(check.moved() if message.moved else check.finish())


def picture(body: bytes) -> Any:
    """A JPEG's brightness, (height, width) uint8; None where it is not a JPEG, too large or too small."""
    import cv2
    import numpy as np

    if body[:2] != b"\xff\xd8":
        return None
    try:
        luma = cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_GRAYSCALE)
    except cv2.error:
        return None
    return luma if luma is not None and min(luma.shape) >= LEAST_SIDE else None
