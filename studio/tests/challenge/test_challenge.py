"""Prompts, and whether a badge followed them.  Each test names what it would catch."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import cv2
import numpy as np
import pytest

from moireid_lab.bench.live import FACE_MM, WEBCAM, answer, course_of, replays_passed
from moireid_studio.challenge import challenge, clock
from moireid_studio.challenge.challenge import (
    FACE,
    WAYS,
    Prompt,
    PromptPath,
    draw_prompts,
    judge_prompt,
    judge_unbroken,
    moved,
    place_of,
)
from moireid_studio.challenge.chance import likeliest_chance
from moireid_studio.challenge.clock import SLACK_S, BoundedClock

EACH = ["left", "right", "down", "up", "nearer", "farther", FACE]


def follow(
    moves: list[str], *, reaction_s: float = 0.6, said: list[str] | None = None
) -> tuple[PromptPath, list[Prompt]]:
    """A course that makes some moves, and prompts for them, or for those that were `said`."""
    asked = [Prompt(move, 3.0 + 5.0 * k) for k, move in enumerate(said or moves)]
    made = [replace(prompt, move=move) for prompt, move in zip(asked, moves, strict=True)]
    course = course_of(answer(made, FACE_MM, reaction_s=reaction_s), made, length_s=asked[-1].at_s + 6.0)
    return course, asked


def test_each_move_is_told_from_every_other() -> None:
    """Catches: left taken for right, up for down, nearer for farther; a mirrored axis; a move taken for another."""
    for move in EACH:
        for asked in EACH:
            # From the place to which "down" leads, every move can be made.
            course, prompts = follow(["down", move], said=["down", asked])
            verdict = judge_prompt(course, prompts[1])
            # To the face is up as well, and far up from there is before the face.
            if {move, asked} != {"up", FACE}:
                assert (verdict.level == "pass") == (move == asked), (move, asked, verdict.text)


@pytest.mark.parametrize(
    ("reaction_s", "level", "words"),
    [
        (0.3, "pass", "followed"),
        (1.3, "pass", "followed"),
        (2.2, "fail", "after it"),
        (-0.7, "fail", "before it was"),
        (4.0, "fail", "did not move"),
    ],
)
def test_a_move_must_begin_soon_after_its_prompt_and_not_before(reaction_s: float, level: str, words: str) -> None:
    """Catches: a check of the way without the time, which any film of the moves would pass."""
    course, prompts = follow(["left"], reaction_s=reaction_s)
    reason = judge_prompt(course, prompts[0])
    assert reason.level == level and words in reason.text


def test_a_badge_that_is_not_seen_or_never_rests_does_not_pass() -> None:
    """Catches: no frames taken for a rest; a badge that swings all the time, and so is right at some time."""
    course, prompts = follow(["left"])
    gone = (course.times_s > 2.4) & (course.times_s < 3.2)
    unseen = PromptPath(course.times_s[~gone], course.place[~gone], course.before_face[~gone])
    assert judge_prompt(unseen, prompts[0]).level == "undecided"
    swing = course.place + np.column_stack([np.sin(6 * course.times_s), *np.zeros((2, len(course.times_s)))])
    assert judge_prompt(replace(course, place=swing), prompts[0]).level == "fail"


def test_pieces_of_an_older_clip_are_told_by_their_seams() -> None:
    """Catches: cuts between prompts, with a pause or without, so that recorded answers are played as they are asked; a
    slow connection that is blamed on the badge.
    """
    course, prompts = follow(["left", "right"])
    frames_s = course.times_s
    assert judge_unbroken(course, prompts, frames_s).level == "pass"
    pause = (frames_s > 6.3) & (frames_s < 7.0)
    paused = PromptPath(frames_s[~pause], course.place[~pause], course.before_face[~pause])
    assert all(judge_prompt(paused, prompt).level == "pass" for prompt in prompts)
    for seen_s, words in ((frames_s, "out of sight for 0.7 s"), (paused.times_s, "No picture came for 0.7 s")):
        reason = judge_unbroken(paused, prompts, seen_s)
        assert reason.level == "undecided" and words in reason.text
    jumped = replace(course, place=course.place + np.where(frames_s > 6.5, 1.5, 0.0)[:, None])
    assert all(judge_prompt(jumped, prompt).level == "pass" for prompt in prompts)
    assert judge_unbroken(jumped, prompts, frames_s).level == "fail"


def test_the_face_must_be_covered_for_the_stated_time() -> None:
    """Catches: a badge that only flits across the face; one that comes there when it is nearly over."""
    course, prompts = follow([FACE])
    assert judge_prompt(course, prompts[0]).level == "pass"
    at_s = prompts[0].at_s
    brief = course.before_face & (course.times_s < at_s + 2.0)
    reason = judge_prompt(replace(course, before_face=brief), prompts[0])
    assert reason.level == "fail" and "before the face for 0." in reason.text
    late = course.before_face & (course.times_s > at_s + clock.DONE_S + 0.1)
    assert judge_prompt(replace(course, before_face=late), prompts[0]).level == "fail"


def test_places_are_those_of_the_person_in_amounts() -> None:
    """Catches: the picture's left for the person's; a tilt taken for a change of distance; a missing perspective."""
    focal, middle, size = WEBCAM.focal_px, np.array([105.0, 148.5]), (WEBCAM.width, WEBCAM.height)
    camera = np.array([[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1.0]])

    def at(x: float, y: float, z: float, yaw: float = 0.0) -> np.ndarray:
        turn = cv2.Rodrigues(np.array([0.0, yaw, 0.0]))[0]
        shift = np.array([x, y, z]) - turn @ np.array([*middle, 0.0])
        return place_of(camera @ np.column_stack([turn[:, 0], turn[:, 1], shift]), middle, size)

    rest = at(0, 50, 640)
    assert at(100, 50, 640) - rest == pytest.approx([1.0, 0, 0], abs=1e-6)
    assert at(0, 0, 640) - rest == pytest.approx([0, 1.0, 0], abs=1e-6)
    assert at(0, 50, 640 / challenge.AMOUNT_RATIO) - rest == pytest.approx([0, 0, 1.0], abs=1e-6)
    # A badge that is turned by 30 degrees looks narrower, and is no farther.
    assert at(0, 50, 640, yaw=0.5) - rest == pytest.approx([0, 0, 0], abs=0.05)


def test_challenges_stay_in_reach_and_differ() -> None:
    """Catches: prompts out of the picture; a face prompt where the badge is there already; draws that repeat."""
    chance = random.Random(1)
    seen = Counter()
    for _ in range(2000):
        prompts = draw_prompts(10.0, chance)
        place = (0, 0, 0)
        for prompt in prompts:
            assert prompt.move != FACE or place[1] <= 0
            place = moved(place, prompt.move)
            assert max(map(abs, place)) <= 1 and not (place[2] > 0 and place[1] < 0)
        moves = [prompt.move for prompt in prompts]
        assert moves.count(FACE) == 1 and moves[0] != FACE and len(moves) == clock.MOVES
        assert sum(move in ("left", "right") for move in moves) >= clock.SIDEWAYS
        gaps = np.diff([prompt.at_s for prompt in prompts])
        assert gaps.min() >= clock.LEAST_GAP_S and prompts[0].at_s >= 10.0
        seen[tuple(moves)] += 1
    assert set(WAYS) <= {move for moves in seen for move in moves} and max(seen.values()) < 20


@pytest.mark.claim("The stated chance of a replay is that of the draws")
def test_the_stated_chance_is_that_of_the_draws() -> None:
    """Catches: draws that repeat moves, or the times between them, more often than THREATS.md says."""
    chance = random.Random(2)
    seen = Counter(tuple(prompt.move for prompt in draw_prompts(0.0, chance)) for _ in range(20_000))
    same = sum(count * (count - 1) for count in seen.values()) / (20_000 * 19_999)
    # The times may differ by one shift, up to the limits and as far as a sender may lie about them.
    gaps = np.random.default_rng(1).uniform(clock.LEAST_GAP_S, clock.MOST_GAP_S, (2, 200_000, clock.MOVES - 1))
    apart = np.pad(np.cumsum(np.diff(gaps, axis=0)[0], axis=1), ((0, 0), (1, 0)))
    in_time = np.mean(np.ptp(apart, axis=1) <= clock.LATEST_S - clock.SOONEST_S + SLACK_S)
    assert 1.3e-4 < same * in_time < 1.4e-4
    # An answer that was made for the likeliest moves, at even times.
    even = np.pad(np.cumsum(gaps[0] - gaps[0].mean(), axis=1), ((0, 0), (1, 0)))
    in_time = np.mean(np.ptp(even, axis=1) <= clock.LATEST_S - clock.SOONEST_S + SLACK_S)
    assert likeliest_chance() * in_time == pytest.approx(1e-3, rel=0.05)


@pytest.mark.claim("None of fifty earlier answers passes a live check")
@pytest.mark.slow
def test_none_of_fifty_replays_passes() -> None:
    """Catches: a challenge that an earlier answer to another one meets; one that its own answer does not meet."""
    own, other = replays_passed(50, seed=7, face_mm=FACE_MM)
    assert own == 50 and other == 0


def clocked(claims: list[tuple[float, float]]) -> tuple[BoundedClock, list[float | None]]:
    clock = BoundedClock()
    return clock, [clock.place(claimed_s, arrival_s) for claimed_s, arrival_s in claims]


def test_times_are_the_senders_where_ours_bears_them_out(rng: np.random.Generator) -> None:
    """Catches: times of arrival, with a network's jitter, taken for those of the pictures."""
    taken = 5000.0 + np.arange(200) / 24
    arrival = np.maximum.accumulate(taken - 4900.0 + rng.uniform(0.03, 0.2, 200))
    clock, times = clocked(list(zip(taken, arrival, strict=True)))
    kept = [(one, two) for one, two in zip(taken, times, strict=True) if two is not None]
    assert len(kept) > 170 and clock.late == 0
    offsets = np.array([two - one for one, two in kept])
    # One offset for nearly all; a picture that was quicker than those of the first second is taken back to its arrival.
    assert np.ptp(offsets) < 0.03 and np.mean(offsets > offsets.max() - 1e-6) > 0.9


@pytest.mark.parametrize("rate", [0.5, 0.9, 1.0, 1.1, 2.0])
def test_a_sender_that_lies_about_time_gains_no_more_than_the_slack(rate: float) -> None:
    """Catches: a slowed clip that claims its own times; claims from the future; a lie that grows by the frame."""
    arrival = np.arange(1000) / 24
    _, times = clocked([(rate * a, a) for a in arrival])
    for time_s, a in zip(times, arrival, strict=True):
        assert time_s is None or a - SLACK_S <= time_s <= a
    if rate <= 0.9:
        assert all(time_s is None for time_s in times[-200:])
