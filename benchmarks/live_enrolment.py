"""Enrolment by a live check, and live checks by its figures: run `moireid lab bench live-enrolment`.

A person before a webcam follows prompts with a true badge, as in `moireid lab bench live`: 720p, 24 pictures a
second.  The first session measures the badge (`witnessed_figures`).  Then, each with new prompts and by these figures:
the same badge answers; a copy of the same files, whose sheet was put on anew, answers; and the first session's film is
played again.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from live_replays import FPS, SEEN_S, WAY_S, badge_of

from moireid.question import Question
from moireid.simulate.scene import Build
from moireid.verifier.session.known_figures import checked_figures
from moireid_lab.bench.live import FACE_MM, answer, frames, portrait
from moireid_lab.bench.part import OWN, Asked, Part, Row, answer_of
from moireid_studio.challenge.challenge import Prompt, draw_prompts
from moireid_studio.challenge.session import READY_S, LiveCheck

CLIPS, COPY = 6, 100
Pictures = list[np.ndarray]


def answered(number: int, build: int, chance: random.Random) -> tuple[Pictures, list[Prompt]]:
    """Pictures of a person who answers prompts, and the prompts."""
    prompts = draw_prompts(SEEN_S + READY_S, chance)
    course = answer(prompts, FACE_MM, reaction_s=chance.uniform(0.3, 1.2))
    length_s, own = prompts[-1].at_s + 6.0, Build.typical(build)
    seed = chance.randrange(1 << 30)
    return list(frames(badge_of(number), portrait(), course, length_s=length_s, fps=FPS, seed=seed, build=own)), prompts


def session(claim: Question, pictures: Pictures, prompts: Sequence[Prompt]) -> dict[str, Any]:
    """The verdict of a live check."""
    now_s = 0.0
    check = LiveCheck(claim, draw=lambda _: list(prompts), now=lambda: now_s)
    check.ask(0.0)
    for k, picture in enumerate(pictures):
        now_s = k / FPS + WAY_S
        ended = [one for one in check.push(picture, k / FPS, now_s) if one["event"] == "verdict"]
        if ended:
            return ended[0]
    return check.finish()


def judged(number: int, folder: Path) -> Row:
    """One badge: enrolled live, then checked live."""
    chance, badge = random.Random(3400 + number), badge_of(number)
    first, prompts = answered(number, number, chance)
    event = session(Question(badge, badge.id, enrolling=True), first, prompts)
    answers = {"enrolled": answer_of(event["verdict"], true=True)}
    row: Row = {"kind": "webcam, 720p", "answers": answers, "verdict": event["verdict"]}
    if "as_built" not in event:
        return row
    found = checked_figures(event["as_built"], badge)
    row |= {"gain": found.gain_ratio, "gain_sd": found.gain_sd, "offset_sd": found.offset_sd}
    claim = Question(badge, badge.id, as_built=found, level="live")
    films = {"again": answered(number, number, chance), "copy": answered(number, number + COPY, chance)}
    films["replay"] = first, draw_prompts(SEEN_S + READY_S, chance)
    for kind, film in films.items():
        answers[kind] = answer_of(session(claim, *film)["verdict"], true=kind == "again")
    return row


def cases(asked: Asked) -> dict[str, int]:
    """All badges."""
    return {f"badge {number}": number for number in range(asked.clips or CLIPS)}


QUESTIONS = {
    "enrolled": "Is a badge's first live session, which measures it, accepted?",
    "again": "Is the same badge accepted again at the level live?",
    "copy": "Is a copy rejected whose sheet was put on anew?",
    "replay": "Is the first session's film rejected, played to new prompts?",
}
PART = Part(QUESTIONS, OWN, cases, judged)
