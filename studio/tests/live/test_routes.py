"""A live session without a browser: the check on made-up pictures, and the WebSocket's manners.

Each test names what it would catch.
"""

from __future__ import annotations

import json
import random
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.badge import Badge
from moireid.enrolment import keep_figures
from moireid.errors import SpecError
from moireid.question import Question
from moireid.registry import open_registry
from moireid.verifier.session.known_figures import MOST_OFFSET_SD_RAD, checked_figures
from moireid_lab.bench.live import FACE_MM, answer, frames, portrait
from moireid_studio.app import create_app
from moireid_studio.auth.tokens import Tokens
from moireid_studio.challenge.challenge import Prompt, draw_prompts
from moireid_studio.challenge.session import READY_S, LiveCheck
from moireid_studio.live import sockets as live
from moireid_studio.live.sockets import CLOCK
from moireid_studio.settings import Settings

FPS = 24.0
#: A short challenge, from the time when it is drawn on, and the film of a person who follows it.
SHORT = (Prompt("left", 0.2), Prompt("face", 3.6), Prompt("right", 8.0))
ORIGIN = {"origin": "http://localhost", "host": "localhost"}


def filmed(badge: Badge) -> Iterator[np.ndarray]:
    """A person who follows `SHORT` where it is drawn once the clock is settled."""
    begins = [Prompt(one.move, 1.0 + READY_S + one.at_s) for one in SHORT]
    course = answer(begins, FACE_MM, reaction_s=0.7)
    return frames(badge, portrait(), course, length_s=14.5, fps=FPS)


@pytest.fixture(scope="module")
def pictures(ada: Badge) -> list[np.ndarray]:
    return list(filmed(ada))


def session(
    ada: Badge, pictures: list[np.ndarray], prompts: tuple[Prompt, ...] = SHORT, *, rate: float = 1.0, **asked: Any
) -> list:
    """Events of a session; rate: of the sender's clock; asked: of the claim."""
    now = 0.0
    check = LiveCheck(
        Question(ada, ada.id, **asked),
        now=lambda: now,
        draw=lambda start_s: [Prompt(one.move, start_s + one.at_s) for one in prompts],
    )
    check.ask(0.0)
    events: list[dict[str, Any]] = []
    for k, picture in enumerate(pictures):
        now = k / FPS + 0.02
        events += check.push(picture, 1000.0 + rate * k / FPS, k / FPS + 0.02)
        if check.ended:
            break
    return events if check.ended else [*events, check.finish()]


def levels(events: list[dict[str, Any]], code: str) -> list[str]:
    return [reason["level"] for reason in events[-1]["reasons"] if reason["code"] == code]


@pytest.fixture(scope="module")
def followed(ada: Badge, pictures: list[np.ndarray]) -> list[dict[str, Any]]:
    return session(ada, pictures)


@pytest.mark.claim("A prompt is shown only when it is due")
@pytest.mark.slow
def test_who_follows_the_prompts_is_accepted_and_sees_them_only_when_due(followed):
    """Catches: prompts that are known in advance; a challenge whose frames are not those that are judged."""
    events = followed
    kinds = [event["event"] for event in events if event["event"] != "status"]
    assert kinds == ["challenge", *["prompt", "prompted"] * 3, "verdict"]
    assert events[-1]["verdict"] == "accept" and levels(events, "prompt") == ["pass"] * 3
    assert events[-1]["overlap"]["verdict"] == "accept" and events[-1]["challenged"]
    json.dumps(events, allow_nan=False)


@pytest.mark.slow
def test_only_a_challenge_that_was_passed_measures_the_badge(ada, pictures, followed):
    """Catches: figures that a film enrolls as witnessed, by another answer or by none; a live check that measures what
    it was not asked for; figures that are not those of the badge."""
    found = checked_figures(session(ada, pictures, enrolling=True)[-1]["as_built"], ada)
    assert found.witnessed and abs(found.gain_ratio - 1) < 0.05 and found.offset_sd < MOST_OFFSET_SD_RAD
    other = tuple(reversed([replace(one, at_s=at.at_s) for one, at in zip(SHORT, reversed(SHORT), strict=True)]))
    refused = session(ada, pictures, other, enrolling=True)[-1]
    assert refused["verdict"] == "reject" and "as_built" not in refused and "as_built" not in followed[-1]


def test_what_a_live_check_measured_is_kept_on_the_page_of_captures(studio, ada):
    """Catches: figures of a process that says whose they are; a review that a verifier sees, or that keeps nothing; a
    live check that takes the place of surer figures of a film, or leaves no trace next to them."""
    client, tokens = studio
    held = client.app.state.studio
    figures = AsBuilt(ada.id, -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.03, witnessed=True)
    issuer = next(one.id for one in held.tokens.all() if one.role == "issuer")
    asked = live.SessionRequest(Question(ada), Question(ada), issuer, "enroll", allowed=lambda: True)
    with pytest.raises(SpecError, match="badge"):
        live._review(held, asked, json.loads(replace(figures, badge_id="0123456789abcdef").to_json()))
    filmed = replace(figures, gain_ratio=1.002, gain_sd=0.01, witnessed=False)
    keep_figures(held.registry, held.registry.find(ada.id), filmed, None)
    page = live._review(held, asked, json.loads(figures.to_json()))
    assert client.get(page, headers={"authorization": tokens["verifier"]}).status_code == 403
    as_issuer = {"authorization": tokens["issuer"]}
    assert "followed prompts" in client.get(page, headers=as_issuer).text
    kept = client.post(f"{page}/keep", headers=as_issuer)
    assert kept.status_code == 200
    assert as_built_from_json(held.registry.by_id(ada.id).as_built) == replace(filmed, witnessed=True)


@pytest.mark.slow
def test_the_running_verdict_comes_within_two_seconds_of_enough_motion(followed):
    """Catches: a verdict that waits for the end."""
    status = [event for event in followed if event["event"] == "status"]
    moved = next(event["time_s"] for event in status if event["reasons"][0]["level"] == "pass")
    accepted = next(event["time_s"] for event in status if event["verdict"] == "accept")
    assert accepted - moved <= 1.1 and np.diff([event["time_s"] for event in status]).max() < 1.2


@pytest.mark.slow
def test_a_recorded_answer_fails_fresh_prompts_and_a_slowed_clock(ada, pictures):
    """Catches: a replay that passes; a sender who stretches time to fit."""
    fresh = draw_prompts(0.0, random.Random(5))
    assert session(ada, pictures, tuple(fresh))[-1]["verdict"] == "reject"
    slowed = session(ada, pictures, rate=0.8)
    assert slowed[-1]["verdict"] != "accept" and levels(slowed, "clock") == ["fail"]


@pytest.fixture
def studio(tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[TestClient, dict[str, str]]]:
    """A studio with tokens of both roles, spoken to without a browser."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    url = f"sqlite:///{tmp_path / 'people.sqlite3'}"
    with open_registry(url, create=True) as registry:
        registry.enroll(ada)
    tokens = Tokens(tmp_path / "data")
    headers = {role: f"Bearer {tokens.create(role)[0]}" for role in ("issuer", "verifier")}
    tokens.close()
    app = create_app(Settings(url, tmp_path / "data"))
    app.state.live_prompts = lambda start_s: list(SHORT)
    with TestClient(app, base_url="http://localhost") as client:
        yield client, headers


def opened(client: TestClient, token: str | None, **headers: str) -> Any:
    sent = ORIGIN | ({"authorization": token} if token else {}) | headers
    return client.websocket_connect("/live/socket", headers=sent)


def received(connection: Any, kind: str) -> dict[str, Any]:
    """The next event of a kind."""
    while (event := connection.receive_json())["event"] != kind:
        assert event["event"] in ("ready", "taken", "status"), event
    return event


def test_only_a_verifier_from_this_site_gets_in(studio):
    """Catches: a socket without a role; a page of another site that uses the visitor's cookie."""
    client, tokens = studio
    refused = [(None, {}), (tokens["issuer"], {}), (tokens["verifier"], {"origin": "https://elsewhere.example"})]
    for token, headers in refused:
        with pytest.raises(WebSocketDisconnect), opened(client, token, **headers) as connection:
            connection.receive_json()
    assert client.get("/live", headers={"authorization": tokens["issuer"]}).status_code == 403
    page = client.get("/live", params={"claim": '"><b>'}, headers={"authorization": tokens["verifier"]})
    assert page.status_code == 200 and "<b>" not in page.text


def test_pictures_go_in_and_a_verdict_comes_out(studio, ada):
    """Catches: a worker that does not start, or dies of the first picture; pictures that are never acknowledged; a
    studio that asks films for a level, and a live check without prompts for none."""
    client, tokens = studio
    client.app.state.studio.settings = replace(client.app.state.studio.settings, level="enrolled")
    with opened(client, tokens["verifier"]) as connection:
        connection.send_json({"claim": "Ada Lovelace"})
        received(connection, "ready")
        for k, picture in enumerate(islice(filmed(ada), 30)):
            sent = CLOCK.pack(1000.0 * time.monotonic()) + cv2.imencode(".jpg", picture)[1].tobytes()
            connection.send_bytes(sent)
            time.sleep(0.045)
            assert received(connection, "taken")["frames"] == k + 1
        connection.send_json({"do": "end"})
        verdict = received(connection, "verdict")
    assert verdict["verdict"] == "inconclusive" and not verdict["challenged"] and verdict["frames"]["tracked"] > 2
    assert levels([verdict], "level") == ["undecided"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "message",
    [
        b"",
        CLOCK.pack(1.0) + b"no picture",
        CLOCK.pack(float("nan")) + b"\xff\xd8\xff",
        b"x" * (live.MOST_BYTES + 1),
        {"claim": "Ada Lovelace"},
        "not json",
    ],
)
def test_what_is_no_picture_ends_the_session_and_nothing_else(studio, message):
    """Catches: a server that falls over a stranger's bytes; a session that stays in the list of those that are open."""
    client, tokens = studio
    with opened(client, tokens["verifier"]) as connection:
        connection.send_json({"claim": "Ada Lovelace"})
        received(connection, "ready")
        if isinstance(message, dict):
            connection.send_json(message)
            connection.send_json({"do": "end"})
            assert received(connection, "verdict")["verdict"] == "inconclusive"
        else:
            (connection.send_bytes if isinstance(message, bytes) else connection.send_text)(message)
            with pytest.raises((WebSocketDisconnect, AssertionError)):
                received(connection, "verdict")
    assert not client.app.state.studio.live_sessions
    assert client.get("/help").status_code == 200


@pytest.mark.slow
def test_a_revoked_token_ends_its_session(studio, monkeypatch):
    """Catches: a session that goes on with a token that was taken back."""
    client, tokens = studio
    monkeypatch.setattr(live, "LOOK_S", 0.0)
    with opened(client, tokens["verifier"]) as connection:
        connection.send_json({"claim": "Ada Lovelace"})
        received(connection, "ready")
        held = client.app.state.studio.tokens
        held.revoke(next(one.id for one in held.all() if one.role == "verifier"))
        connection.send_json({"do": "end"})
        with pytest.raises(WebSocketDisconnect) as ended:
            received(connection, "verdict")
    assert ended.value.code == 1000 and not client.app.state.studio.live_sessions
