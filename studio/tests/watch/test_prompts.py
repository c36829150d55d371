"""Prompts by `watch`: a person who follows them, and a film that does not.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import json
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from moireid.badge import Badge
from moireid.json_schema import report_schema
from moireid.verifier import Question
from moireid.verifier.picture import Picture
from moireid_lab.bench.live import FACE_MM, answer, frames, portrait
from moireid_studio.challenge.challenge import Prompt
from moireid_studio.challenge.session import READY_S
from moireid_studio.watch.judge import Voice, Watching
from moireid_studio.watch.order import StreamEnd, WatchOrder
from moireid_studio.watch.readers import Inbox, TimedPicture
from moireid_studio.watch.source import source_of

FPS = 24.0
#: A short challenge, its times from its beginning.
SHORT = (Prompt("left", 0.2), Prompt("face", 3.6), Prompt("right", 8.0))
OTHER = (Prompt("right", 0.2), Prompt("face", 3.6), Prompt("left", 8.0))


@pytest.fixture(scope="module")
def pictures(ada: Badge) -> list[np.ndarray]:
    """A person who follows `SHORT` where it is drawn once the clock is settled."""
    begins = [Prompt(one.move, 1.0 + READY_S + one.at_s) for one in SHORT]
    course = answer(begins, FACE_MM, reaction_s=0.7)
    return list(frames(ada, portrait(), course, length_s=14.5, fps=FPS))


class RecordedVoice(Voice):
    """Keeps what the judge sends."""

    def __init__(self) -> None:
        self.sent: list[dict[str, Any]] = []

    def send(self, answer: dict[str, Any]) -> None:
        self.sent.append(json.loads(json.dumps(answer, allow_nan=False)))


def watched(ada: Badge, pictures: list[np.ndarray], prompts: tuple[Prompt, ...]) -> list[dict[str, Any]]:
    """What the judge of a camera sends.

    All comes two minutes from now, so that a slow machine shows each prompt when its picture comes, and not later.
    """
    voice, inbox, begun_s = RecordedVoice(), Inbox(waits=True), time.monotonic() + 120.0

    def shoot() -> None:
        for k, one in enumerate(pictures):
            inbox.put_picture(TimedPicture(Picture(one), 1000.0 + k / FPS, begun_s + k / FPS))
        inbox.put_last(StreamEnd("source"))

    with ThreadPoolExecutor(1) as aside:
        watching = Watching(
            WatchOrder(source_of("0"), Question(ada, ada.id, enrolling=True), prompts=prompts), voice, inbox, aside
        )
        threading.Thread(target=shoot, daemon=True).start()
        watching.run()
    return voice.sent


@pytest.mark.slow
def test_who_follows_the_prompts_is_accepted(ada: Badge, pictures: list[np.ndarray]) -> None:
    """Catches: a challenge that never begins, or whose verdict is lost when the check ends by itself; a demand that
    the badge moves for half of the time, though it must rest between the moves.
    """
    events = watched(ada, pictures, SHORT)
    kinds = [one["event"] for one in events if one["event"] != "status"]
    assert kinds == ["begun", "challenge", *["prompt", "prompted"] * 3, "verdict"]
    last = events[-1]
    assert last["verdict"] == "accept" and last["challenged"] and last["input"]["path"] == "camera 0"
    assert "cover" not in {one["code"] for one in last["reasons"]} and last["as_built"]["witnessed"]
    Draft202012Validator(json.loads(report_schema())).validate(last)


@pytest.mark.slow
def test_a_film_of_another_challenge_is_rejected(ada: Badge, pictures: list[np.ndarray]) -> None:
    """Catches: a virtual camera that plays an older answer, accepted, or enrolled as a live check's figures."""
    last = watched(ada, pictures, OTHER)[-1]
    assert last["event"] == "verdict" and last["verdict"] == "reject" and "as_built" not in last
    assert "prompt" in {one["code"] for one in last["reasons"] if one["level"] == "fail"}
