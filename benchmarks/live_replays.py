"""Replays of rendered films against fresh challenges: run `.venv/bin/python benchmarks/live_replays.py [--films 50]`.

films: a person before a webcam follows a challenge with a true badge: traced fringes, a photographed face, tremor,
    noise, 720p at 24 frames a second, coded as JPEG as the page codes them; one process for each processor.
own: some go through `LiveCheck` with the challenge that they answer, and should be accepted.
replay: it is played to a fresh challenge, begun at the moment that suits this best, which the replayer knows before:
    paused on its first picture till then, or without its beginning.  None may be accepted.
stall: once in the challenge the connection stalls for so long: pictures on their way come late, the page drops
    those that it would have to queue (six ahead), and the check must not reject.  But a film answers each prompt when
    it was planned; where the stall delays a prompt, the answer comes too soon, and is rejected for that.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import cv2
import numpy as np
from live_speed import FACE_MM, FPS, portrait

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.verifier.session.claim import Claim
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import LostJob
from moireid_lab.bench.live import answer, course_of, frames, passes_in_order
from moireid_studio.challenge.challenge import Prompt, draw_prompts
from moireid_studio.challenge.session import READY_S, LiveCheck

#: Badge and face are seen by then; the first prompt of what the film answers comes no sooner.
SEEN_S = 1.5
#: The page's own limit of pictures on their way, and how long one is on its way.
MOST_AHEAD, WAY_S = 6, 0.05
STALLS_S = (0.3, 0.5, 1.0)
NAMES = ("Ada Lovelace", "Emmy Noether", "Grace Hopper", "Lise Meitner", "Mary Somerville")
Picture = tuple[float, float, bytes]  #: When it was taken and when it arrived, s, and its JPEG.


@dataclass(frozen=True)
class Clip:
    """One film: its number, from which all that is random in it comes, and whether only its replay is wanted."""

    number: int
    replay_alone: bool


def scored(clip: Clip) -> dict[str, Any]:
    """What the live check says of a film, its replay, and the film over connections that stall."""
    chance = random.Random(1000 + clip.number)
    name = NAMES[clip.number % len(NAMES)]
    # Fixed by the name, so that every run films the same badges.
    payload = hashlib.sha256(f"moireid/spacing/0/{name}".encode()).digest()[:8]
    badge = design_badge(Request(name), payload)
    before = draw_prompts(SEEN_S + READY_S, chance)
    course = answer(before, FACE_MM, reaction_s=chance.uniform(0.3, 1.2))
    length_s = before[-1].at_s + 6.0
    pictures = frames(badge, portrait(), course, length_s=length_s, fps=FPS, seed=clip.number)
    film: Iterable[bytes] = (
        cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes() for picture in pictures
    )
    results = {}
    stall_at_s = chance.uniform(before[0].at_s, before[-1].at_s)
    if not clip.replay_alone:
        film = list(film)
        timed = [(k / FPS, k / FPS + WAY_S, coded) for k, coded in enumerate(film)]
        results = {
            f"stall {stall_s:g}": checked(badge, stalled(timed, stall_at_s, stall_s), before) for stall_s in STALLS_S
        } | {"own": checked(badge, timed, before)}
    # The replayer knows the prompts in advance, and the best moment to start the clip.
    fresh = draw_prompts(before[0].at_s, chance)
    seen = course_of(course, before, length_s=length_s, seed=clip.number)
    shifts = np.arange(SEEN_S - before[0].at_s, fresh[-1].at_s - before[0].at_s, 0.25)
    best_s = max(shifts, key=lambda shift_s: (passes_in_order(seen, fresh, shift_s), -abs(shift_s)))
    results["replay"] = checked(
        badge, ((k / FPS, k / FPS + WAY_S, coded) for k, coded in enumerate(begun_at(film, round(best_s * FPS)))), fresh
    )
    return results


def begun_at(film: Iterable[bytes], start: int) -> Iterator[bytes]:
    """A film that is paused on its first picture for so many pictures, or lacks as many where that is negative."""
    pictures = iter(film)
    if start > 0:
        first = next(pictures)
        yield from [first] * (start + 1)
    yield from islice(pictures, max(-start, 0), None)


def stalled(timed: Sequence[Picture], at_s: float, stall_s: float) -> list[Picture]:
    """The film over a connection that stalls once: what was sent comes after it, what was not sent is dropped."""
    sent = [
        (taken, at_s + stall_s if at_s <= arrived < at_s + stall_s else arrived, coded)
        for taken, arrived, coded in timed
    ]
    waiting = [one for one in sent if one[1] == at_s + stall_s]
    dropped = {one[0] for one in waiting[MOST_AHEAD:]}
    return [one for one in sent if one[0] not in dropped]


def checked(badge: Badge, film: Iterable[Picture], prompts: Sequence[Prompt]) -> tuple[str, str, int]:
    """The verdict of a session on a film, the first finding that is no pass, and how many prompts were judged."""
    now_s, judged = 0.0, 0
    check = LiveCheck(Claim(badge, badge.id), draw=lambda _: list(prompts), now=lambda: now_s)
    check.ask(0.0)
    verdict: dict[str, Any] | None = None
    for taken_s, now_s, coded in film:
        for event in check.push(cv2.imdecode(np.frombuffer(coded, np.uint8), cv2.IMREAD_GRAYSCALE), taken_s, now_s):
            judged += event["event"] == "prompted"
            verdict = event if event["event"] == "verdict" else verdict
        if check.ended:
            break
    verdict = verdict or check.finish()
    why = next((one["text"] for one in verdict["reasons"] if one["level"] == verdict_level(verdict)), "")
    return verdict["verdict"], why, judged


def verdict_level(verdict: dict[str, Any]) -> str:
    """The level of the findings that made a verdict."""
    return {"reject": "fail", "inconclusive": "undecided"}.get(verdict["verdict"], "pass")


def main() -> None:
    """Print verdicts by kind."""
    # Other processes know this file by its name alone.
    from live_replays import Clip, scored

    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--films", type=int, default=50)
    asked.add_argument("--controls", type=int, default=10, help="films that are also checked as what they are")
    asked.add_argument("--workers", type=int)
    given = asked.parse_args()
    verdicts: dict[str, Counter[str]] = {}
    followed: Counter[int] = Counter()
    for count, (place, done) in enumerate(
        run_tasks(scored, [Task((Clip(k, k >= given.controls),)) for k in range(given.films)], workers=given.workers),
        start=1,
    ):
        found = done.outcomes[0]
        if isinstance(found, LostJob):
            print(f"film {place} was lost: {found.why}")
            continue
        followed[found["replay"][2]] += 1
        for kind, (verdict, why, judged) in found.items():
            verdicts.setdefault(kind, Counter())[verdict] += 1
            if (verdict == "accept") is (kind == "replay") or (kind == "own" and verdict != "accept"):
                print(f"film {place}, {kind}: {verdict} after {judged} prompts: {why}", flush=True)
        print(f"{count} of {given.films}", file=sys.stderr)
    for kind, found in verdicts.items():
        print(f"{kind:>10}: " + ", ".join(f"{count} {verdict}" for verdict, count in found.items()))
    print(
        f"prompts that replays were judged by, of six: {dict(sorted(followed.items()))}; load {os.getloadavg()[0]:.1f}"
    )


if __name__ == "__main__":
    main()
