"""Enrolment by a live check, and live checks by its figures: run `moireid lab bench live-enrolment`.

A person before a webcam follows prompts with a true badge, as in `moireid lab bench live`: 720p, 24 pictures a
second.  The first session measures the badge (`witnessed_figures`).  Then, each with new prompts and by these figures:
the same badge answers; a copy of the same files, whose sheet was put on anew, answers; and the first session's film is
played again.  Printed are the figures' error bars, each verdict and what decided it, and sums.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from live_replays import FPS, SEEN_S, WAY_S, badge_of

from moireid.question import Question
from moireid.simulate.scene import Build
from moireid.verifier.session.known_figures import checked_figures
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.live import FACE_MM, answer, frames, portrait
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


def judged(number: int) -> Row:
    """One badge: enrolled live, then checked live."""
    chance, badge = random.Random(3400 + number), badge_of(number)
    first, prompts = answered(number, number, chance)
    event = session(Question(badge, badge.id, enrolling=True), first, prompts)
    row: Row = {"badge": number, "enrolled": event["verdict"], "why": _why(event)}
    if "as_built" not in event:
        return row
    found = checked_figures(event["as_built"], badge)
    row |= {"gain": found.gain_ratio, "gain sd": found.gain_sd, "offset sd": found.offset_sd}
    claim = Question(badge, badge.id, as_built=found, level="live")
    films = {"again": answered(number, number, chance), "copy": answered(number, number + COPY, chance)}
    films["replay"] = first, draw_prompts(SEEN_S + READY_S, chance)
    for kind, film in films.items():
        event = session(claim, *film)
        row |= {kind: event["verdict"], f"{kind}: why": _why(event), f"{kind}: figures": event["identity"]["built"]}
    return row


def _why(event: dict[str, Any]) -> str:
    """The codes that decided a verdict."""
    level = {"reject": "fail", "inconclusive": "undecided"}.get(event["verdict"])
    return ", ".join(dict.fromkeys(one["code"] for one in event["reasons"] if one["level"] == level))


def rows(wish: Wish) -> Iterator[Row]:
    """One row a badge."""
    return wish.each(judged, {f"badge {number}": number for number in range(wish.clips or CLIPS)})


def table(found: list[Row]) -> Iterator[Row]:
    """The badges, then the sums."""
    yield from found
    for kind in ("enrolled", "again", "copy", "replay"):
        counted = Counter(row.get(kind) for row in found)
        yield {"all of": kind} | {verdict: counted[verdict] for verdict in ("accept", "inconclusive", "reject")}


COLUMNS = {"badge": ">5", "enrolled": "<12", "why": "<10", "gain": ">6.3f", "gain sd": ">7.3f", "offset sd": ">9.3f"}
for _kind in ("again", "copy", "replay"):
    COLUMNS |= {_kind: "<12", f"{_kind}: figures": "<16", f"{_kind}: why": "<24"}
COLUMNS |= {"all of": "<18", "accept": ">8", "inconclusive": ">13", "reject": ">8"}
BENCH = Bench(rows, COLUMNS, table=table)
