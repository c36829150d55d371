"""The live challenge: prompts that nobody knows before they are due, and whether the badge followed them in time.

A clip that was made before shows true fringes, but not the motion that is asked for now.  So moves are drawn at random,
each with a random time, and told only when due.  Each must begin after its prompt and soon, go the right way far
enough, and start from rest.

Convention: left and right are those of the person who holds the badge.  Places are in *amounts*, (T, 3): to the
person's left, up, and nearer, where 1 is what a prompt asks for at least.  They are told from a picture that is turned
back if it was mirrored, and need no focal length: a place across is px over px/mm, a distance a ratio of scales.
"""

from __future__ import annotations

import math
import random
import secrets
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.limits import MAX_GAP_S
from moireid.verifier.reasons import Level, Reason
from moireid.verifier.timeline import Spans

Array = NDArray[np.float64]
Place = tuple[int, int, int]  #: Steps to the person's left, up, and nearer.
#: What may be asked for, and which way it goes; "face" is no way but a place.
WAYS = {"left": (0, 1), "right": (0, -1), "up": (1, 1), "down": (1, -1), "nearer": (2, 1), "farther": (2, -1)}
FACE = "face"
WORDS = {
    "left": "Move it 20 cm to your left",
    "right": "Move it 20 cm to your right",
    "up": "Move it 10 cm up",
    "down": "Move it 10 cm down",
    "nearer": "Bring it nearer to the camera",
    "farther": "Take it farther from the camera",
    FACE: "Hold it across your face",
}
#: One amount: sideways, upright, and as the ratio of distances: half of what is asked for, as nobody measures.  A
#: laptop's picture is half as high as it is wide.
SIDEWAYS_MM, UPRIGHT_MM, AMOUNT_RATIO = 100.0, 50.0, 1.12
#: A move begins where the badge leaves its place by this share of an amount, and a rest stays within it: a hand wanders
#: by a centimetre.
BEGUN = 0.25
#: While it goes the prompted way by an amount, it goes no other way by more than this share of that.
ASTRAY = 0.75
#: A move begins no sooner after its prompt than people can react, and no later than this; it is done by `DONE_S`.
#: People need 0.2 s to react to what they see and half a second to read a word; the rest is for the way of a picture.
SOONEST_S, LATEST_S, DONE_S = 0.15, 2.0, 3.0
#: Before a prompt the badge rests for so long.
REST_S = 0.5
#: From one prompt to the next: time to be done and at rest again, and as much again at random.
LEAST_GAP_S, MOST_GAP_S = 3.6, 6.4
#: The badge stays before the face for so long, and the next prompt comes so much later.
HOLD_S = 1.2
#: Moves of a challenge, one of which is across the face, and of how many at least go sideways: without, the fringes of
#: most badges hardly move, and tell nothing.
MOVES, SIDEWAYS = 6, 2
#: Amounts a second that no hand makes, 1.5 m sideways, told over no less than the time of a camera's frame.
MOST_SPEED, FRAME_S = 15.0, 1 / 24
#: Fewer frames than this tell no rest.
MIN_FRAMES = 4


@dataclass(frozen=True)
class Prompt:
    """One move and when it is asked for, s on the clock of the track."""

    move: str
    at_s: float


@dataclass(frozen=True)
class Course:
    """Where the badge was: times_s (T,), rising; place (T, 3) in amounts; before_face (T,): whether it overlapped."""

    times_s: Array
    place: Array
    before_face: NDArray[np.bool_]


def place_of(page: Array, middle_mm: Array, image_px: tuple[int, int]) -> Array:
    """Where the badge is, (3,), in amounts, from a homography page mm -> px; only differences of it mean anything.

    Convention: module docstring; the picture's centre is the view axis.
    Source: weak perspective: the larger singular value of the homography's Jacobian is focal length over distance,
    however the page is turned.
    """
    x, y, w = page @ (*middle_mm, 1.0)
    px = np.array([x, y]) / w
    jacobian = (page[:2, :2] - np.outer(px, page[2, :2])) / w
    scale = float(np.linalg.svd(jacobian, compute_uv=False)[0])
    across = (px - (np.array(image_px) - 1) / 2) / scale
    return np.array([across[0] / SIDEWAYS_MM, -across[1] / UPRIGHT_MM, math.log(scale) / math.log(AMOUNT_RATIO)])


def draw_prompts(start_s: float, chance: random.Random | None = None, *, moves: int = MOVES) -> list[Prompt]:
    """A challenge: `moves` prompts, the first at `start_s` or somewhat later.

    Parameters: chance: where it comes from; the system's own generator, but in tests.
    Convention: moves lead at most one amount off the middle along each way, so they stay in view; each allowed one is
    as likely as the other; the one across the face comes at any place but the first.  Challenges with fewer than
    `SIDEWAYS` moves to a side are drawn anew.
    """
    chance = chance or secrets.SystemRandom()
    asked = _drawn_moves(chance, moves)
    while sum(_sideways(move) for move in asked) < SIDEWAYS:
        asked = _drawn_moves(chance, moves)
    at_s, prompts = start_s + chance.uniform(0, MOST_GAP_S - LEAST_GAP_S), list[Prompt]()
    for move in asked:
        prompts.append(Prompt(move, at_s))
        at_s += chance.uniform(LEAST_GAP_S, MOST_GAP_S) + (HOLD_S if move == FACE else 0.0)
    return prompts


def _drawn_moves(chance: random.Random, moves: int) -> list[str]:
    face_at, place, asked = chance.randrange(1, moves), (0, 0, 0), list[str]()
    for k in range(moves):
        asked.append(FACE if k == face_at else chance.choice(allowed(place)))
        place = moved(place, asked[-1])
    return asked


def _sideways(move: str) -> bool:
    return move != FACE and WAYS[move][0] == 0


def allowed(place: Place) -> list[str]:
    """Moves, but across the face, that stay in view from a place on the grid of amounts.

    Up is asked for from below alone: up from the middle leads before the face by itself, and "across your face" would
    then ask for no move.  Near the camera the picture is not high enough for more than the middle, and nobody is sent
    nearer while the badge is up or down.
    """
    found = []
    for move, (axis, sign) in WAYS.items():
        x, y, z = moved(place, move)
        rises = axis == 1 and sign > 0
        if max(abs(x), abs(y), abs(z)) <= 1 and not (rises and y > 0) and not (z > 0 and y != 0 and axis > 0):
            found.append(move)
    return found


def moved(place: Place, move: str) -> Place:
    """The place on the grid after a move; before the face is above the middle."""
    if move == FACE:
        return (0, 1, place[2])
    axis, sign = WAYS[move]
    steps = list(place)
    steps[axis] += sign
    return steps[0], steps[1], steps[2]


def judge_challenge(course: Course, prompts: Sequence[Prompt]) -> tuple[Reason, ...]:
    """A finding for each prompt, in order.

    Convention: "fail" where the badge moved early, late, not, or elsewhere; "undecided" where it was not seen.
    """
    return tuple(judge_prompt(course, prompt) for prompt in prompts)


def judge_unbroken(course: Course, prompts: Sequence[Prompt], frames_s: Array) -> Reason:
    """Whether the badge was in view without a break from before the first prompt until the last was followed.

    Else pieces of an older clip could be played as they are asked for: over a longer gap the fringes' phase is not
    followed, and a jump to another place is no hand's.
    Parameters: frames_s (N,): when all frames were taken, those without the badge too.
    Convention: measured is the longest gap, s; "undecided" for a gap, "fail" for a jump.
    """
    ends = (prompts[0].at_s - REST_S, prompts[-1].at_s + LATEST_S) if prompts else (0.0, 0.0)
    within = (course.times_s >= ends[0]) & (course.times_s <= ends[1])
    if within.sum() < MIN_FRAMES:
        return Reason("unbroken", "undecided", None, MAX_GAP_S, "s", "The badge was not in view during the moves.")
    times, place = course.times_s[within], course.place[within]
    steps = np.diff(times)
    bounds = np.concatenate([[ends[0]], times])
    last = int(np.diff(bounds).argmax())
    longest = float(bounds[last + 1] - bounds[last])
    speed = float((np.abs(np.diff(place, axis=0)).max(axis=1) / np.maximum(steps, FRAME_S)).max())
    if speed > MOST_SPEED:
        text = "The badge jumped from one place to another faster than a hand moves."
        return Reason("unbroken", "fail", longest, MAX_GAP_S, "s", text)
    if longest > MAX_GAP_S and not np.any((frames_s > bounds[last]) & (frames_s < bounds[last + 1])):
        text = f"No picture came for {longest:.1f} s during the moves; use a faster connection, and begin again."
        return Reason("unbroken", "undecided", longest, MAX_GAP_S, "s", text)
    if longest > MAX_GAP_S:
        text = f"The badge was out of sight for {longest:.1f} s; keep it in the picture all along, and begin again."
        return Reason("unbroken", "undecided", longest, MAX_GAP_S, "s", text)
    return Reason(
        "unbroken", "pass", longest, MAX_GAP_S, "s", "The badge was in view without a break through all moves."
    )


def judge_prompt(course: Course, prompt: Prompt) -> Reason:
    """Whether the badge rested before one prompt, and followed it in time; measured: reaction, s.

    Source: the limits above.
    """
    since = course.times_s - prompt.at_s
    before = (since >= -REST_S) & (since < SOONEST_S)
    after = np.flatnonzero((since >= SOONEST_S) & (since <= DONE_S + (HOLD_S if prompt.move == FACE else 0.0)))
    if before.sum() < MIN_FRAMES or len(after) < MIN_FRAMES:
        text = "the badge was not in view; keep it, with its four markers, in the picture"
        return _finding(prompt, "undecided", None, text)
    rest = np.median(course.place[before], axis=0)
    if np.abs(course.place[before] - rest).max() > BEGUN:
        text = "the badge moved before it was asked; hold it still until the next prompt"
        return _finding(prompt, "fail", None, text)
    gone = course.place[after] - rest
    begun = np.flatnonzero(np.abs(gone).max(axis=1) > BEGUN)
    reaction = float(since[after[begun[0]]]) if len(begun) else None
    if reaction is None or reaction > LATEST_S:
        words = "did not move" if reaction is None else f"moved {reaction:.1f} s after it"
        return _finding(prompt, "fail", reaction, f"the badge {words}; it must move within {LATEST_S:g} s")
    if prompt.move == FACE:
        return _across_face(course, prompt, after, reaction)
    axis, sign = WAYS[prompt.move]
    along, aside = sign * gone[:, axis], np.abs(np.delete(gone, axis, axis=1)).max(axis=1)
    there = np.flatnonzero((along >= 1.0) & (aside <= ASTRAY * along))
    back = np.flatnonzero(along <= -1.0)
    if not len(there) or (len(back) and back[0] < there[0]):
        way = "the other way" if len(back) else "elsewhere, or not far enough"
        return _finding(prompt, "fail", reaction, f"the badge went {way}; go {_amount(prompt.move)} as asked and stop")
    return _finding(prompt, "pass", reaction, f"followed after {reaction:.1f} s")


def _across_face(course: Course, prompt: Prompt, after: NDArray[np.int64], reaction: float) -> Reason:
    """Whether the badge was before the face from soon after the prompt on, for `HOLD_S`."""
    times = course.times_s[after]
    spans = Spans()
    for time_s in times[course.before_face[after]]:
        spans.add(float(time_s))
    held = [end - start for start, end in spans.spans if start <= prompt.at_s + DONE_S]
    longest = max(held, default=0.0)
    if longest < HOLD_S:
        text = f"the badge was before the face for {longest:.1f} s; stay until the next prompt ({HOLD_S:g} s or more)"
        return _finding(prompt, "fail", reaction, text)
    return _finding(prompt, "pass", reaction, f"followed after {reaction:.1f} s, and held for {longest:.1f} s or more")


def _amount(move: str) -> str:
    return ("20 cm", "10 cm", "a hand's length")[WAYS[move][0]]


def _finding(prompt: Prompt, level: Level, reaction: float | None, text: str) -> Reason:
    return Reason("prompt", level, reaction, LATEST_S, "s", f"{WORDS[prompt.move]}: {text}.")


def replay_chance(*, moves: int = MOVES, slack_s: float = 0.0, draws: int = 200_000) -> float:
    """Chance that the true answer to one challenge, replayed, passes another.

    The same moves must be drawn, and at the same times but for one shift, which the replayer may choose, and for what
    the limits leave.  slack_s: by how much a sender may lie about times (`clock`).
    Convention: an upper bound: the shift is the best one in hindsight, and every reaction the one that suits best.
    Source: the moves' part is summed over all challenges; the times' part is drawn `draws` times from a fixed seed.
    """
    rng = np.random.default_rng(1)
    gaps = rng.uniform(LEAST_GAP_S, MOST_GAP_S, (2, draws, moves - 1))
    apart = np.cumsum(np.diff(gaps, axis=0)[0], axis=1)
    apart = np.column_stack([np.zeros(draws), apart])
    in_time = float(np.mean(np.ptp(apart, axis=1) <= LATEST_S - SOONEST_S + slack_s))
    return in_time * same_moves_chance(moves)


def same_moves_chance(moves: int = MOVES) -> float:
    """Chance that two challenges ask for the same moves: the sum of the squares of all challenges' chances.

    Source: counted over places on the grid and moves to a side; those drawn anew are left out of it.
    """
    same, kept = 0.0, 0.0
    for face_at in range(1, moves):
        # Of each place and number of moves to a side: the chances of all ways there, and the sum of their squares.
        sums = {((0, 0, 0), 0): (1.0, 1.0)}
        for k in range(moves):
            following: dict[tuple[Place, int], tuple[float, float]] = {}
            for (place, sideways), (once, twice) in sums.items():
                ways = [FACE] if k == face_at else allowed(place)
                for move in ways:
                    there = moved(place, move), min(sideways + _sideways(move), SIDEWAYS)
                    before = following.get(there, (0.0, 0.0))
                    following[there] = before[0] + once / len(ways), before[1] + twice / len(ways) ** 2
            sums = following
        enough = [value for (_, sideways), value in sums.items() if sideways == SIDEWAYS]
        kept += sum(once for once, _ in enough) / (moves - 1)
        same += sum(twice for _, twice in enough) / (moves - 1) ** 2
    return same / kept**2
