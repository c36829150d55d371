"""A challenge in a call: answers come late, prompts wait for them, and tiles may be poor.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import random
from collections import Counter
from typing import Any

import pytest

from kit.payloads import payload_for_name
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.question import Question
from moireid_lab.bench.live import FACE_MM, Caller, PausingPlayer, answer, coded, course_of, frames, portrait
from moireid_studio.challenge.challenge import (
    FACE,
    Prompt,
    PromptPath,
    draw_prompts,
    judge_delay,
    judge_prompt,
    over_s,
    sideways,
)
from moireid_studio.challenge.chance import likeliest_chance
from moireid_studio.challenge.clock import CALL, HERE, SPREAD_S, Pace
from moireid_studio.challenge.session import LiveCheck

FPS = 24.0


def course(moves: list[tuple[str, float]]) -> PromptPath:
    """What is seen of a badge that makes these moves at these times."""
    made = [Prompt(*one) for one in moves]
    return course_of(answer(made, FACE_MM, reaction_s=0.0), made, length_s=made[-1].at_s + 6.0)


@pytest.mark.parametrize(
    ("after_s", "here", "call"), [(1.0, "pass", "pass"), (5.0, "fail", "pass"), (6.3, "fail", "fail")]
)
def test_a_call_leaves_time_for_reading_and_for_its_way(after_s: float, here: str, call: str) -> None:
    """Catches: a call in which nobody can answer in time; one that waits for ever."""
    asked = Prompt("left", 3.0)
    seen = course([("left", 3.0 + after_s)])
    assert (judge_prompt(seen, asked, HERE).level, judge_prompt(seen, asked, CALL).level) == (here, call)


def test_a_prompt_of_a_call_is_over_once_it_was_followed() -> None:
    """Catches: a call of nine prompts that takes two minutes; a wrong move that may be put right until time is over."""
    asked, right, wrong = Prompt("left", 3.0), course([("left", 4.0)]), course([("right", 4.0)])
    found = judge_prompt(right, asked, CALL)
    assert found.level == "pass" and over_s(asked, CALL, found) < asked.at_s
    found = judge_prompt(wrong, asked, CALL)
    assert found.level == "fail" and over_s(asked, CALL, found) < asked.at_s + 4.5 < over_s(asked, CALL)
    assert over_s(asked, HERE, judge_prompt(right, asked, HERE)) == over_s(asked, HERE)


def test_answers_of_one_delay_pass_and_of_a_delay_that_jumps_stay_open() -> None:
    """Catches: a delay that may be another at each answer, so that something can be made up meanwhile."""
    asked = [Prompt("left", 3.0), Prompt("right", 10.0)]

    def delays(first_s: float, second_s: float) -> str:
        seen = course([("left", 3.0 + first_s), ("right", 10.0 + second_s)])
        return judge_delay([judge_prompt(seen, one, CALL) for one in asked]).level

    assert delays(2.0, 2.4) == delays(4.5, 4.9) == delays(1.0, 0.8 + SPREAD_S) == "pass"
    assert delays(1.0, 1.3 + SPREAD_S) == "undecided"
    assert judge_delay([]).level == "undecided"


def test_the_stated_chance_is_that_of_the_draws_and_owes_nothing_to_times() -> None:
    """Catches: a chance that is smaller than that of somebody who pauses a film until each prompt."""
    chance = random.Random(3)
    short = Pace(5, 2, *[getattr(CALL, name) for name in ("latest_s", "done_s", "gap_s", "frame_s", "in_call")])
    seen = Counter(tuple(one.move for one in draw_prompts(0.0, chance, pace=short)) for _ in range(20_000))
    assert likeliest_chance(short) == pytest.approx(max(seen.values()) / 20_000, rel=0.3)
    assert likeliest_chance(CALL) == pytest.approx(8.7e-5, rel=0.01)
    drawn = [draw_prompts(0.0, chance, pace=CALL) for _ in range(200)]
    assert {len(one) for one in drawn} == {CALL.moves}
    assert min(sum(sideways(prompt.move) for prompt in one) for one in drawn) == CALL.sideways


MOVES = ("left", "right", FACE, "right", "left")


def called(
    badge: Badge, who: Any, asked: tuple[str, ...], delay_s: float, *, slow: bool = False
) -> list[dict[str, Any]]:
    """The events of a call of these prompts over a line with so much delay, there and back, and 2 % of loss.

    Parameters: slow: every second picture is sent, a tenth of these is lost, and the others are late by up to 30 ms.
    """
    now_s, chance = 0.0, random.Random(1)
    prompts = [Prompt(move, 1.7 * k) for k, move in enumerate(asked)]
    check = LiveCheck(
        Question(badge, badge.id),
        draw=lambda at_s: [Prompt(one.move, at_s + one.at_s) for one in prompts],
        pace=CALL,
        now=lambda: now_s,
    )
    check.ask(0.0)
    events: list[dict[str, Any]] = []
    filmed = frames(badge, portrait(), who, length_s=60.0, fps=FPS)
    for number, picture in enumerate(coded(filmed, 800, FPS, loss=0.02, chance=chance)):
        now_s = number / FPS + delay_s / 2
        if slow and (number % 2 or chance.random() < 0.1):
            continue
        claimed_s = now_s + (chance.uniform(0.0, 0.03) if slow else 0.0)
        output = check.push(picture, claimed_s, now_s + 0.03)
        for event in output:
            if event["event"] == "prompt":
                who.hear(event["move"], now_s)
        events += output
        if check.ended:
            return events
    return [*events, check.finish()]


@pytest.mark.slow
def test_a_call_over_a_late_and_slow_line_is_accepted(ada: Badge) -> None:
    """Catches: prompts that do not wait for their answers; lost pictures that are taken for a badge at rest; quick
    moves at twelve pictures a second that are taken for cuts."""
    events = called(ada, Caller(FACE_MM, 1.5, random.Random(2)), MOVES, 1.5, slow=True)
    kinds = [event["event"] for event in events if event["event"] != "status"]
    assert kinds == ["challenge", *["prompt", "prompted"] * len(MOVES), "verdict"]
    assert events[-1]["verdict"] == "accept" and events[-1]["in_call"], events[-1]["reasons"]
    assert all(event["aloud"].startswith("Please") for event in events if event["event"] == "prompt")


@pytest.mark.slow
def test_a_film_that_is_paused_until_each_prompt_is_rejected(ada: Badge) -> None:
    """Catches: a replay that passes because nobody counts its times."""
    before = [Prompt(move, 3.0 + 4 * k) for k, move in enumerate(MOVES)]
    other = ("left", FACE, "right", "right", "left")
    assert called(ada, PausingPlayer(before, FACE_MM, 0.5), other, 0.5)[-1]["verdict"] == "reject"


@pytest.fixture(scope="module")
def ada() -> Badge:
    return design_badge(Order("Ada Lovelace", lens="50lpi"), payload_for_name("Ada Lovelace"))
