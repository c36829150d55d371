"""The live challenge: random prompts, shown only when they are due, and whether the badge followed them in time.

A clip that was recorded earlier may show genuine fringes, but not the motion requested now.  So moves and their times
are drawn at random, and each prompt is shown only when it is due.  Each move must begin soon after its prompt, go far
enough in the right direction, and start from rest.

Convention: left and right are those of the person who holds the badge.  Places are in *amounts*, (T, 3): to the
    person's left, up, and nearer; 1 is the least motion that a prompt requires.  They are measured in the unmirrored
    picture, and need no focal length: a place across is px over px/mm, a distance a ratio of scales.
"""

from __future__ import annotations

import math
import random
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.measuring import MAX_GAP_S
from moireid.verifier.reasons import Level, Reason
from moireid.verifier.timeline import Spans
from moireid_studio.challenge.clock import DONE_S, HERE, SOONEST_S, SPREAD_S, Pace

Array = NDArray[np.float64]
Place = tuple[int, int, int]  #: Steps to the person's left, up, and nearer.
#: The possible moves: axis and sign of each.  "face" is missing because it is a place and not a direction.
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
#: The same as it is read aloud in a call.
ALOUD = {
    "left": "Please move the badge to your left, by a hand's length, and hold it still.",
    "right": "Please move the badge to your right, by a hand's length, and hold it still.",
    "up": "Please move the badge up a little, and hold it still.",
    "down": "Please move the badge down a little, and hold it still.",
    "nearer": "Please bring the badge nearer to the camera, and hold it still.",
    "farther": "Please take the badge farther from the camera, and hold it still.",
    FACE: "Please hold the badge across your face, and keep it there.",
}
#: One amount: sideways, upright, and as a ratio of distances.  It is half of what the prompt says, as people do not
#: measure.  A laptop's picture is half as high as it is wide.
SIDEWAYS_MM, UPRIGHT_MM, AMOUNT_RATIO = 100.0, 50.0, 1.12
#: A move begins when the badge leaves its place by this share of an amount; at rest it stays within it: a hand moves by
#: a centimetre at rest.
BEGUN = 0.25
#: While the badge moves in the prompted direction, it may move across by at most this share of that.
ASTRAY = 0.75
#: A move takes at most this long from its beginning.
MOST_MOVE_S = DONE_S - SOONEST_S
#: Before a prompt the badge must rest for this long.
REST_S = 0.5
#: The badge must stay in front of the face for this long, and the next prompt comes later by this time.
HOLD_S = 1.2
#: Amounts per second that no hand reaches (1.5 m sideways).
MOST_SPEED = 15.0
#: Frames needed to detect rest.
MIN_FRAMES = 4


@dataclass(frozen=True)
class Prompt:
    """One move and the time of its prompt, s on the clock of the track."""

    move: str
    at_s: float


@dataclass(frozen=True)
class PromptPath:
    """The badge's path: times_s (T,), rising; place (T, 3) in amounts; before_face (T,): whether it covered the
    face."""

    times_s: Array
    place: Array
    before_face: NDArray[np.bool_]


def place_of(page: Array, middle_mm: Array, image_px: tuple[int, int]) -> Array:
    """Place of the badge, (3,), in amounts, from a homography page mm -> px; only differences have a meaning.

    Convention: module docstring; the picture's centre is the view axis.
    Source: weak perspective: the larger singular value of the homography's Jacobian is focal length over distance, for
        any rotation of the page.
    """
    x, y, w = page @ (*middle_mm, 1.0)
    px = np.array([x, y]) / w
    jacobian = (page[:2, :2] - np.outer(px, page[2, :2])) / w
    scale = float(np.linalg.svd(jacobian, compute_uv=False)[0])
    across = (px - (np.array(image_px) - 1) / 2) / scale
    return np.array([across[0] / SIDEWAYS_MM, -across[1] / UPRIGHT_MM, math.log(scale) / math.log(AMOUNT_RATIO)])


def draw_prompts(start_s: float, chance: random.Random | None = None, *, pace: Pace = HERE) -> list[Prompt]:
    """A challenge: prompts, the first at `start_s` or somewhat later.

    Parameters
    ----------
    chance
        The random generator; None, except in tests: that of the system.

    Notes
    -----
    Convention: moves lead at most one amount away from the middle along each axis, so the badge stays in view; all
    allowed moves are equally likely; the one across the face is never the first. A challenge with too few moves to a
    side is drawn again.
    """
    chance = chance or secrets.SystemRandom()
    asked, (least_s, most_s) = _drawn_moves(chance, pace.moves), pace.gap_s
    while sum(map(sideways, asked)) < pace.sideways:
        asked = _drawn_moves(chance, pace.moves)
    at_s, prompts = start_s + chance.uniform(0, most_s - least_s), list[Prompt]()
    for move in asked:
        prompts.append(Prompt(move, at_s))
        at_s += chance.uniform(least_s, most_s) + (HOLD_S if move == FACE and not pace.in_call else 0.0)
    return prompts


def _drawn_moves(chance: random.Random, moves: int) -> list[str]:
    face_at, place, asked = chance.randrange(1, moves), (0, 0, 0), list[str]()
    for k in range(moves):
        asked.append(FACE if k == face_at else chance.choice(allowed(place)))
        place = moved(place, asked[-1])
    return asked


def sideways(move: str) -> bool:
    """Whether a move goes to a side."""
    return move != FACE and WAYS[move][0] == 0


def allowed(place: Place) -> list[str]:
    """Moves (other than across the face) that stay in view from a place on the grid of amounts.

    "up" is allowed only from below: from the middle it leads to the face, and "across your face" would then require no
    move.  Near the camera the picture has only room for the middle, so "nearer" is not allowed while the badge is up or
    down.
    """
    found = []
    for move, (axis, sign) in WAYS.items():
        x, y, z = moved(place, move)
        rises = axis == 1 and sign > 0
        if max(abs(x), abs(y), abs(z)) <= 1 and not (rises and y > 0) and not (z > 0 and y != 0 and axis > 0):
            found.append(move)
    return found


def moved(place: Place, move: str) -> Place:
    """The place on the grid after a move; the face is above the middle."""
    if move == FACE:
        return (0, 1, place[2])
    axis, sign = WAYS[move]
    steps = list(place)
    steps[axis] += sign
    return steps[0], steps[1], steps[2]


def from_start(prompts: Sequence[Prompt]) -> Callable[[float], list[Prompt]]:
    """What gives prompts that were drawn already, their times counted from a challenge's beginning, s."""
    return lambda start_s: [Prompt(one.move, start_s + one.at_s) for one in prompts]


def judge_challenge(
    path: PromptPath, prompts: Sequence[Prompt], pace: Pace = HERE, frames_s: Array | None = None
) -> tuple[Reason, ...]:
    """A finding for each prompt, in order; parameters and convention as `judge_prompt`."""
    return tuple(judge_prompt(path, prompt, pace, frames_s) for prompt in prompts)


def judge_unbroken(path: PromptPath, prompts: Sequence[Prompt], frames_s: Array, pace: Pace = HERE) -> Reason:
    """Whether the badge was in view without a break from before the first prompt until the last one was followed.

    Otherwise an attacker could play pieces of an older clip as the prompts come: the phase is not tracked across a
    longer gap, and a hand cannot jump to another place.

    Parameters
    ----------
    frames_s : array (N,)
        Times of all frames, also of those without the badge.

    Notes
    -----
    Convention: measured is the longest gap, s; "undecided" for a gap, "fail" for a jump; in a call "undecided" for
    both, as its picture stops and jumps where the network falters.
    """
    ends = (prompts[0].at_s - REST_S, prompts[-1].at_s + pace.latest_s) if prompts else (0.0, 0.0)
    within = (path.times_s >= ends[0]) & (path.times_s <= ends[1])
    if within.sum() < MIN_FRAMES:
        return Reason("unbroken", "undecided", None, MAX_GAP_S, "s", "The badge was not in view during the moves.")
    times, place = path.times_s[within], path.place[within]
    steps = np.diff(times)
    bounds = np.concatenate([[ends[0]], times])
    last = int(np.diff(bounds).argmax())
    longest = float(bounds[last + 1] - bounds[last])
    speed = float((np.abs(np.diff(place, axis=0)).max(axis=1) / np.maximum(steps, pace.frame_s)).max())
    if speed > MOST_SPEED:
        text = "The badge jumped from one place to another faster than a hand moves."
        if pace.in_call:
            text += " A call does so where its line falters: begin again, with no other program that loads the line."
        return Reason("unbroken", "undecided" if pace.in_call else "fail", longest, MAX_GAP_S, "s", text)
    if longest > MAX_GAP_S and not np.any((frames_s > bounds[last]) & (frames_s < bounds[last + 1])):
        text = f"No picture came for {longest:.1f} s during the moves; use a faster connection, and begin again."
        return Reason("unbroken", "undecided", longest, MAX_GAP_S, "s", text)
    if longest > MAX_GAP_S:
        text = f"The badge was out of sight for {longest:.1f} s; keep it in the picture all along, and begin again."
        return Reason("unbroken", "undecided", longest, MAX_GAP_S, "s", text)
    return Reason(
        "unbroken", "pass", longest, MAX_GAP_S, "s", "The badge was in view without a break through all moves."
    )


def judge_prompt(path: PromptPath, prompt: Prompt, pace: Pace = HERE, frames_s: Array | None = None) -> Reason:
    """Whether the badge rested before one prompt, and followed it in time; measured: reaction, s.

    Parameters
    ----------
    frames_s : array (N,)
        Times of all frames, also of those without the badge; None for those of the path.

    Notes
    -----
    Convention: "fail" if the badge moved early, late, not at all, or elsewhere; "undecided" if it was not seen, or if
    pictures are missing that might have shown it follow.
    Source: the limits above.
    """
    found = _judged(path, prompt, pace)
    if found.level != "fail":
        return found
    until_s = prompt.at_s + pace.done_s + (HOLD_S if prompt.move == FACE else 0.0)
    times = path.times_s if frames_s is None else frames_s
    times = times[(times >= prompt.at_s - REST_S) & (times <= until_s)]
    lost_s = float(np.diff(times).max(initial=0.0))
    if lost_s <= MAX_GAP_S:
        return found
    text = (
        f"{WORDS[prompt.move]}: no picture came for {lost_s:.1f} s meanwhile; use a faster connection, and begin again."
    )
    return replace(found, level="undecided", text=text)


def _judged(path: PromptPath, prompt: Prompt, pace: Pace) -> Reason:
    """The same, as if no picture were missing."""
    since = path.times_s - prompt.at_s
    before = (since >= -REST_S) & (since < SOONEST_S)
    after = np.flatnonzero((since >= SOONEST_S) & (since <= pace.done_s + (HOLD_S if prompt.move == FACE else 0.0)))
    if before.sum() < MIN_FRAMES or len(after) < MIN_FRAMES:
        text = "the badge was not in view; keep it, with its four markers or its frame, in the picture"
        return _finding(prompt, "undecided", None, text, pace)
    rest = np.median(path.place[before], axis=0)
    if np.abs(path.place[before] - rest).max() > BEGUN:
        text = "the badge moved before it was asked; hold it still until the next prompt"
        return _finding(prompt, "fail", None, text, pace)
    gone = path.place[after] - rest
    begun = np.flatnonzero(np.abs(gone).max(axis=1) > BEGUN)
    reaction = float(since[after[begun[0]]]) if len(begun) else None
    if reaction is None or reaction > pace.latest_s:
        words = "did not move" if reaction is None else f"moved {reaction:.1f} s after it"
        text = f"the badge {words}; it must move within {pace.latest_s:g} s"
        return _finding(prompt, "fail", reaction, text, pace)
    # Also where an answer may begin late, the move itself may take no longer than in a room: no detour is an answer.
    after = after[since[after] <= reaction + MOST_MOVE_S + (HOLD_S if prompt.move == FACE else 0.0)]
    if prompt.move == FACE:
        return _across_face(path, prompt, after, reaction, pace)
    axis, sign = WAYS[prompt.move]
    gone = gone[: len(after)]
    along, aside = sign * gone[:, axis], np.abs(np.delete(gone, axis, axis=1)).max(axis=1)
    there = np.flatnonzero((along >= 1.0) & (aside <= ASTRAY * along))
    back = np.flatnonzero(along <= -1.0)
    if not len(there) or (len(back) and back[0] < there[0]):
        way = "the other way" if len(back) else "elsewhere, or not far enough"
        text = f"the badge went {way}; go {_amount(prompt.move)} as asked and stop"
        return _finding(prompt, "fail", reaction, text, pace)
    return _finding(prompt, "pass", reaction, f"followed after {reaction:.1f} s", pace)


def over_s(prompt: Prompt, pace: Pace, found: Reason | None = None) -> float:
    """The time after which what `judge_prompt` found of a prompt cannot change any more, s.

    In a call that is as soon as it was followed, or the move that was begun has taken too long.
    """
    hold_s = HOLD_S if prompt.move == FACE else 0.0
    if pace.in_call and found is not None and found.level == "pass":
        return -math.inf
    if pace.in_call and found is not None and isinstance(found.measured, float):
        return prompt.at_s + min(found.measured + MOST_MOVE_S, pace.done_s) + hold_s
    return prompt.at_s + pace.done_s + hold_s


def _across_face(path: PromptPath, prompt: Prompt, after: NDArray[np.int64], reaction: float, pace: Pace) -> Reason:
    """Whether the badge covered the face for `HOLD_S`, beginning soon after the prompt."""
    times = path.times_s[after]
    spans = Spans()
    for time_s in times[path.before_face[after]]:
        spans.add(float(time_s))
    by_s = prompt.at_s + min(pace.done_s, reaction + MOST_MOVE_S)
    held = [end - start for start, end in spans.spans if start <= by_s]
    longest = max(held, default=0.0)
    if longest < HOLD_S:
        text = f"the badge was before the face for {longest:.1f} s; stay until the next prompt ({HOLD_S:g} s or more)"
        return _finding(prompt, "fail", reaction, text, pace)
    return _finding(
        prompt, "pass", reaction, f"followed after {reaction:.1f} s, and held for {longest:.1f} s or more", pace
    )


def _amount(move: str) -> str:
    return ("20 cm", "10 cm", "a hand's length")[WAYS[move][0]]


def judge_delay(answers: Sequence[Reason]) -> Reason:
    """Whether the answers of a call came after one delay: what reading aloud, the call and reacting take together.

    Parameters
    ----------
    answers
        Findings of `judge_prompt`, of prompts that were followed.

    Notes
    -----
    Convention: measured is how much later the latest answer came than the soonest, s; "undecided" if that is too much.
    """
    took = [answer.measured for answer in answers if answer.level == "pass" and isinstance(answer.measured, float)]
    if not took:
        return Reason("delay", "undecided", None, SPREAD_S, "s", "No prompt was followed, so the delay is not known.")
    apart = max(took) - min(took)
    text = (
        f"The answers came {min(took):.1f} to {max(took):.1f} s after the prompts, reading aloud and the call's delay "
    )
    if apart <= SPREAD_S:
        return Reason("delay", "pass", apart, SPREAD_S, "s", text + "included.")
    text += f"included. They may differ by {SPREAD_S:g} s; read each prompt as soon as it is shown, and begin again."
    return Reason("delay", "undecided", apart, SPREAD_S, "s", text)


def _finding(prompt: Prompt, level: Level, reaction: float | None, text: str, pace: Pace) -> Reason:
    return Reason("prompt", level, reaction, pace.latest_s, "s", f"{WORDS[prompt.move]}: {text}.")
