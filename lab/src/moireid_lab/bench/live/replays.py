"""Replays of earlier answers to new challenges: an old true clip, started at the moment that fits best."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.live.challenge import (
    AMOUNT_RATIO,
    FACE,
    SIDEWAYS_MM,
    UPRIGHT_MM,
    Course,
    Prompt,
    draw_prompts,
    judge_challenge,
)
from moireid_lab.bench.live.film import Answer, answer

Array = NDArray[np.float64]
#: Steps in which the replayer's clip is moved to suit the prompts, s.
SHIFT_S = 0.25


def course_of(
    course: Answer, prompts: Sequence[Prompt], *, length_s: float, fps: float = 24.0, seed: int = 0
) -> Course:
    """What a check sees of an answer, without the pictures: places with a tremor, and when the face is covered."""
    times = np.arange(round(length_s * fps)) / fps
    place = np.array([course.place_mm(float(time_s)) for time_s in times])
    place[:, :2] += np.random.default_rng(seed).normal(0, 1.0, (len(times), 2))
    before_face = np.zeros(len(times), bool)
    for k, prompt in enumerate(prompts):
        if prompt.move == FACE:
            left = course.set_out_s[k + 1] if k + 1 < len(prompts) else np.inf
            before_face |= (times >= course.set_out_s[k] + 0.6) & (times <= left + 0.3)
    amounts = [place[:, 0] / SIDEWAYS_MM, -place[:, 1] / UPRIGHT_MM, -np.log(place[:, 2]) / math.log(AMOUNT_RATIO)]
    return Course(times, np.column_stack(amounts), before_face)


def passes(course: Course, prompts: Sequence[Prompt]) -> bool:
    """Whether a course meets a challenge."""
    return all(reason.level == "pass" for reason in judge_challenge(course, prompts))


def passes_in_order(course: Course, prompts: Sequence[Prompt], shift_s: float) -> int:
    """How many prompts a course meets before the first that it does not, begun `shift_s` later."""
    later = Course(course.times_s + shift_s, course.place, course.before_face)
    levels = [reason.level == "pass" for reason in judge_challenge(later, prompts)]
    return (*levels, False).index(False)


def passes_at_best(course: Course, before: Sequence[Prompt], fresh: Sequence[Prompt]) -> bool:
    """Whether an earlier answer to `before` meets fresh prompts, whenever it is started."""
    apart = [new.at_s - old.at_s for new, old in zip(fresh, before, strict=True)]
    shifts = np.arange(min(apart) - 2.0, max(apart) + 2.0, SHIFT_S)
    return any(passes(Course(course.times_s + s, course.place, course.before_face), fresh) for s in shifts)


def replays_passed(count: int, seed: int, face_mm: Array) -> tuple[int, int]:
    """Of `count` true answers, how many meet their own challenge, and how many another one, replayed.

    Parameters: face_mm: as `film.answer`.
    """
    chance = random.Random(seed)
    own = other = 0
    for number in range(count):
        before, fresh = draw_prompts(3.0, chance), draw_prompts(3.0, chance)
        followed = answer(before, face_mm, reaction_s=chance.uniform(0.3, 1.2))
        course = course_of(followed, before, length_s=before[-1].at_s + 6.0, seed=number)
        own += passes(course, before)
        other += passes_at_best(course, before, fresh)
    return own, other
