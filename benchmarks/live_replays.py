"""Answers, calls and replays against the live check: run `moireid lab bench live [--only call]`.

film: a person before a webcam follows a challenge with a true badge: traced fringes, a photographed face, tremor,
    noise, 720p at 24 frames a second, coded as JPEG as the page codes them.  Some go through `LiveCheck` with the
    challenge that they answer (own), and should be accepted.  Each is played to a fresh challenge (replay), begun
    at the moment that suits this best, which the replayer knows before: paused on its first picture till then, or
    without its beginning.  None may be accepted.
call, answered: a person in a call hears the prompts that are read aloud, and follows them with a true badge.  The
    call's delay, there and back, goes from 100 to 1,500 ms; 2 % of the pictures are lost; pictures are coded by H.264
    at 1.5 Mbit/s, shown in a tile of 960 px, and coded as JPEG by the asker's page.  Nine of ten
    should be accepted.  jumping: with a delay that jumps up by a second in the middle.  replay: an attacker plays a
    film of an earlier answered call, and pauses it until each prompt comes.  None may be accepted.
drawn: a forger before a webcam follows the prompts with a printed board, whose pose his program knows without error.
    It draws the badge over the board by optical flow between two to four stills (`true_films.morph`), and the film is
    later for that by 60 ms and a frame.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from true_films.morph import Morph, stills

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.question import Question
from moireid.simulate.scene import Build, Scene
from moireid_lab.bench.live import (
    FACE_MM,
    REST_MM,
    Caller,
    PausingPlayer,
    answer,
    coded,
    course_of,
    frames,
    passes_in_order,
    portrait,
)
from moireid_lab.bench.part import OWN, Asked, Part, Row, answer_of, interleaved
from moireid_studio.challenge.challenge import draw_prompts
from moireid_studio.challenge.clock import CALL
from moireid_studio.challenge.session import READY_S, LiveCheck

FPS = 24.0
#: Badge and face are seen by then; the first prompt of what the film answers comes no sooner.
SEEN_S = 1.5
#: How long a picture is on its way.
WAY_S = 0.05
#: Of calls: share of pictures that are lost, width of the tile, px, and the longest call.
LOSS, WIDTH, LONGEST_S = 0.02, 960, 150.0
#: Of badges that are drawn: how long a frame takes, s; the parallax that an answer goes to, at most; and by how much
#: that of two neighbouring stills differs, at most, as fringes that are half a turn on seem to go back.
DRAWING_S, MOST_VIEW, MOST_STEP = 0.06, 0.25, 0.3
NAMES = ("Ada Lovelace", "Emmy Noether", "Grace Hopper", "Lise Meitner", "Mary Somerville")
Picture = tuple[float, float, bytes]  #: When it was taken and when it arrived, s, and its JPEG.


def badge_of(number: int) -> Badge:
    """A badge of one of `NAMES`; fixed by the name, so that every run films the same ones."""
    name = NAMES[number % len(NAMES)]
    return design_badge(Order(name, lens="50lpi"), hashlib.sha256(f"moireid/spacing/0/{name}".encode()).digest()[:8])


def checked(
    badge: Badge, film: Iterable[Picture], draw: Callable[[float], Any], hear: Callable[[str, float], None], **pace: Any
) -> str:
    """The verdict of a session on a film.

    Parameters: draw: as `LiveCheck`; hear: called with each prompt and the time.
    """
    now_s, verdict = 0.0, None
    check = LiveCheck(Question(badge, badge.id), draw=draw, now=lambda: now_s, **pace)
    check.ask(0.0)
    for taken_s, now_s, jpeg in film:
        for event in check.push(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE), taken_s, now_s):
            if event["event"] == "prompt":
                hear(event["move"], now_s)
            verdict = event if event["event"] == "verdict" else verdict
        if check.ended:
            break
    return str((verdict or check.finish())["verdict"])


def jpegs(pictures: Iterable[np.ndarray]) -> Iterator[bytes]:
    """Pictures as the page codes them."""
    for picture in pictures:
        yield cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()


def filmed(job: tuple[int, bool]) -> dict[str, str]:
    """What the live check says of a film and of its replay, by kind."""
    number, replay_alone = job
    chance, badge = random.Random(1000 + number), badge_of(number)
    before = draw_prompts(SEEN_S + READY_S, chance)
    course = answer(before, FACE_MM, reaction_s=chance.uniform(0.3, 1.2))
    length_s = before[-1].at_s + 6.0
    film: Iterable[bytes] = jpegs(frames(badge, portrait(), course, length_s=length_s, fps=FPS, seed=number))
    found: dict[str, str] = {}

    def judged(pictures: Iterable[Picture], prompts: Sequence[Any]) -> str:
        return checked(badge, pictures, lambda _: list(prompts), lambda move, shown_s: None)

    def timed(pictures: Iterable[bytes]) -> Iterator[Picture]:
        return ((k / FPS, k / FPS + WAY_S, jpeg) for k, jpeg in enumerate(pictures))

    if not replay_alone:
        film = list(film)
        found["own"] = judged(timed(film), before)
    # The replayer knows the prompts in advance, and the best moment to start the clip.
    fresh = draw_prompts(before[0].at_s, chance)
    seen = course_of(course, before, length_s=length_s, seed=number)
    shifts = np.arange(SEEN_S - before[0].at_s, fresh[-1].at_s - before[0].at_s, 0.25)
    best_s = max(shifts, key=lambda shift_s: (passes_in_order(seen, fresh, shift_s), -abs(shift_s)))
    found["replay"] = judged(timed(begun_at(film, round(best_s * FPS))), fresh)
    return found


def begun_at(film: Iterable[bytes], start: int) -> Iterator[bytes]:
    """A film that is paused on its first picture for so many pictures, or lacks as many where that is negative."""
    pictures = iter(film)
    if start > 0:
        first = next(pictures)
        yield from [first] * (start + 1)
    yield from islice(pictures, max(-start, 0), None)


@dataclass(frozen=True)
class Call:
    """One call; all that is random in it comes from its number.  jump_s: by how much its delay grows."""

    number: int
    kind: str
    delay_s: float
    jump_s: float = 0.0


def called(call: Call) -> dict[str, str]:
    """What becomes of a call."""
    chance, badge = random.Random(f"{call.kind} {call.number}"), badge_of(call.number)
    who: Any = Caller(FACE_MM, call.delay_s, chance)
    if call.kind == "replay":
        who = PausingPlayer(draw_prompts(3.0, chance, pace=CALL), FACE_MM, call.delay_s)
    pictures = frames(badge, portrait(), who, length_s=LONGEST_S, fps=FPS, seed=call.number)
    tile = jpegs(coded(pictures, WIDTH, FPS, loss=LOSS, chance=chance))

    def arriving() -> Iterator[Picture]:
        for number, jpeg in enumerate(tile):
            taken_s = number / FPS + call.delay_s / 2 + (call.jump_s if number / FPS > 20 else 0.0)
            yield taken_s, taken_s + 0.03, jpeg

    found = checked(badge, arriving(), lambda at_s: draw_prompts(at_s, chance, pace=CALL), who.hear, pace=CALL)
    return {"call jumps" if call.jump_s else f"call {call.kind}": found}


def drawn(job: tuple[int, int]) -> dict[str, str]:
    """What the live check says of a badge that is drawn by optical flow between so many stills as the prompts come."""
    number, count = job
    chance, badge = random.Random(7000 + number), badge_of(number)
    prompts = draw_prompts(SEEN_S + READY_S, chance)
    course = answer(prompts, FACE_MM, reaction_s=chance.uniform(0.3, 1.2))
    half = min(MOST_VIEW, MOST_STEP * (count - 1) / 2)
    at = np.linspace(-half, half, count)
    views = np.column_stack([at, np.zeros(count), np.full(count, REST_MM[2])])
    morph = Morph(stills(Scene(badge, Build.typical(number)), views, number)).drawn(Scene(badge, Build.typical(number)))
    length_s = prompts[-1].at_s + 6.0
    film = jpegs(frames(badge, portrait(), course, length_s=length_s, fps=FPS, seed=number, drawn=morph))
    late_s = DRAWING_S + 1 / FPS
    timed = ((k / FPS + late_s, k / FPS + late_s + WAY_S, jpeg) for k, jpeg in enumerate(film))
    found = checked(badge, timed, lambda _: list(prompts), lambda move, shown_s: None)
    return {f"drawn, {count} stills": found}


def judged(job: tuple[str, Any], folder: Path) -> Row:
    """A film, a call, or a badge that is drawn."""
    found = {"film": filmed, "call": called, "drawn": drawn}[job[0]](job[1])
    answers = {
        kind.split(",")[0]: answer_of(verdict, true=kind in ("own", "call answered", "call jumps"))
        for kind, verdict in found.items()
    }
    return {"kind": list(found)[-1], "answers": answers, "verdict": list(found.values())[-1]}


def cases(asked: Asked) -> dict[str, tuple[str, Any]]:
    """All sessions, mixed by kind."""
    count = asked.clips or 10
    delays = np.linspace(0.1, 1.5, max(count, 2)).tolist()
    films = {f"film {k}": ("film", (k, k >= count // 2)) for k in range(count)}
    calls = [Call(k, "answered", delays[k]) for k in range(count)] + [
        Call(k, "replay", delays[k]) for k in range(count)
    ]
    some = {f"call {call.kind} {call.number}": ("call", call) for call in calls}
    some |= {f"call jumps {k}": ("call", Call(k, "jumping", 0.4, 1.0)) for k in range(2)}
    stills = {f"drawn {number} {k}": ("drawn", (k, number)) for k in range(3) for number in (2, 3, 4)}
    return interleaved(films, some, stills)


QUESTIONS = {
    "own": "Is a live answer to its own prompts accepted?",
    "replay": "Is an answer of another time rejected, played at the best moment?",
    "call answered": "Is an answer accepted in a call, 0.1 to 1.5 s late, 2 % of the pictures lost?",
    "call jumps": "The same in a call whose delay jumps by a second?",
    "call replay": "Is an answer of another call rejected, paused until each prompt?",
    "drawn": "Is a badge rejected that is drawn by optical flow between two to four stills as the prompts come?",
}
PART = Part(QUESTIONS, OWN, cases, judged)
