"""Calls, answered and replayed: run `.venv/bin/python benchmarks/call_replays.py [--answered 10] [--replays 50]`.

answered: a person in a call hears the prompts that are read aloud, and follows them with a true badge.  The call's
    delay, there and back, goes from 100 to 1,500 ms; 2 % of the pictures are lost; pictures are coded by H.264 at
    1.5 Mbit/s, shown in a tile of 960 px, and coded as JPEG by the asker's page.  Nine of ten should be accepted.
jumping: the same with a delay that jumps up by a second in the middle.
replay: an attacker plays a film of an earlier answered call, and pauses it until each prompt comes.  None may be
    accepted.
--widths 320 480 640: answered calls in tiles of these widths.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from live_speed import FACE_MM, portrait

from moireid.designer import Request, design_badge
from moireid.verifier.session.claim import Claim
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import LostJob
from moireid_lab.bench.live import Caller, PausingPlayer, coded, frames
from moireid_studio.challenge.challenge import draw_prompts
from moireid_studio.challenge.chance import likeliest_chance, same_moves_chance
from moireid_studio.challenge.clock import CALL
from moireid_studio.challenge.session import LiveCheck

FPS, LOSS, WIDTH, LONGEST_S = 24.0, 0.02, 960, 150.0
NAMES = ("Ada Lovelace", "Emmy Noether", "Grace Hopper", "Lise Meitner", "Mary Somerville")


@dataclass(frozen=True)
class Call:
    """One call; all that is random in it comes from its number.  jump_s: by how much its delay grows."""

    number: int
    kind: str
    delay_s: float
    width: int = WIDTH
    jump_s: float = 0.0


def held(call: Call) -> dict[str, Any]:
    """Verdict of a call, the finding that made it, how many prompts were judged, and how long it took."""
    chance = random.Random(f"{call.kind} {call.number}")
    name = NAMES[call.number % len(NAMES)]
    # Fixed by the name, so that every run films the same badges.
    badge = design_badge(Request(name), hashlib.sha256(f"moireid/spacing/0/{name}".encode()).digest()[:8])
    who: Any = Caller(FACE_MM, call.delay_s, chance)
    if call.kind == "replay":
        who = PausingPlayer(draw_prompts(3.0, chance, pace=CALL), FACE_MM, call.delay_s)
    now_s, judged, verdict = 0.0, 0, None
    check = LiveCheck(
        Claim(badge, badge.id), draw=lambda at_s: draw_prompts(at_s, chance, pace=CALL), pace=CALL, now=lambda: now_s
    )
    check.ask(0.0)
    filmed = frames(badge, portrait(), who, length_s=LONGEST_S, fps=FPS, seed=call.number)
    for number, picture in enumerate(_sampled(filmed, call, chance)):
        back_s = call.delay_s / 2 + (call.jump_s if number / FPS > 20 else 0.0)
        now_s = number / FPS + back_s
        for event in check.push(picture, now_s, now_s + 0.03):
            if event["event"] == "prompt":
                who.hear(event["move"], now_s)
            judged += event["event"] == "prompted"
            verdict = event if event["event"] == "verdict" else verdict
        if check.ended:
            break
    verdict = verdict or check.finish()
    level = {"reject": "fail", "inconclusive": "undecided"}.get(verdict["verdict"], "pass")
    why = [one["text"] for one in verdict["reasons"] if one["level"] == level]
    return {"verdict": verdict["verdict"], "why": why[0] if why else "", "judged": judged, "took_s": now_s}


def _sampled(filmed: Iterator[np.ndarray], call: Call, chance: random.Random) -> Iterator[np.ndarray]:
    """The tile as the asker's page sends it."""
    for picture in coded(filmed, call.width, FPS, loss=LOSS, chance=chance):
        jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])[1]
        yield np.asarray(cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE), np.uint8)


def main() -> None:
    """Print verdicts by kind."""
    # Other processes know this file by its name alone.
    from call_replays import Call, held

    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--answered", type=int, default=10)
    asked.add_argument("--jumping", type=int, default=2)
    asked.add_argument("--replays", type=int, default=50)
    asked.add_argument("--widths", type=int, nargs="*", default=[])
    asked.add_argument("--workers", type=int)
    given = asked.parse_args()
    delays = np.linspace(0.1, 1.5, max(given.answered, 2))
    calls = [Call(k, "answered", float(delays[k])) for k in range(given.answered)]
    calls += [Call(k, "jumping", 0.4, jump_s=1.0) for k in range(given.jumping)]
    calls += [Call(k, "replay", float(delays[k % len(delays)])) for k in range(given.replays)]
    calls += [Call(k, f"{width} px wide", 0.4, width) for width in given.widths for k in range(2)]
    verdicts: dict[str, Counter[str]] = {}
    for count, (place, done) in enumerate(run_tasks(held, [Task((one,)) for one in calls], workers=given.workers), 1):
        call, found = calls[place], done.outcomes[0]
        if isinstance(found, LostJob):
            print(f"{call} was lost: {found.why}")
            continue
        verdicts.setdefault(call.kind, Counter())[found["verdict"]] += 1
        print(
            f"{call.kind}, delay {call.delay_s:.2f} s: {found['verdict']} after {found['judged']} prompts and "
            f"{found['took_s']:.0f} s" + (f": {found['why']}" if found["verdict"] != "accept" else ""),
            flush=True,
        )
        print(f"{count} of {len(calls)}", file=sys.stderr)
    for kind, counted in verdicts.items():
        print(f"{kind:>14}: " + ", ".join(f"{count} {verdict}" for verdict, count in counted.items()))
    print(
        f"computed chance of one paused replay {same_moves_chance(CALL):.1e}, of the likeliest one "
        f"{likeliest_chance(CALL):.1e}; load {os.getloadavg()[0]:.1f}"
    )


if __name__ == "__main__":
    main()
