"""The chance that an older film follows a challenge.

Convention: an older film is the right answer to an earlier challenge, drawn as this one is.
"""

from __future__ import annotations

import numpy as np

from moireid.verifier.live.challenge import FACE, Place, allowed, moved, sideways
from moireid.verifier.live.pace import HERE, SOONEST_S, Pace


def replay_chance(*, pace: Pace = HERE, slack_s: float = 0.0, draws: int = 200_000) -> float:
    """Chance that a replay of the right answer to one challenge passes another challenge.

    Both challenges must have the same moves, and the same times up to one shift, which the attacker may choose, and up
    to the limits.  slack_s: how far a sender may lie about times (`clock`).
    Convention: an upper bound: shift and reactions are the best ones in hindsight.
    Source: the moves' part is summed over all challenges; the times' part is drawn `draws` times from a fixed seed.
    """
    rng = np.random.default_rng(1)
    gaps = rng.uniform(*pace.gap_s, (2, draws, pace.moves - 1))
    apart = np.cumsum(np.diff(gaps, axis=0)[0], axis=1)
    apart = np.column_stack([np.zeros(draws), apart])
    in_time = float(np.mean(np.ptp(apart, axis=1) <= pace.latest_s - SOONEST_S + slack_s))
    return in_time * same_moves_chance(pace)


def same_moves_chance(pace: Pace = HERE) -> float:
    """Chance that two challenges have the same moves: the sum of the squares of all challenges' probabilities.

    In a call it is that of a replay, as whoever plays an older film may pause it until a prompt is read aloud.
    Source: summed over places on the grid and moves to a side, without the challenges that are drawn again.
    """
    once, twice, _ = _sums(pace)
    return twice / once**2


def likeliest_chance(pace: Pace = HERE) -> float:
    """Chance of the likeliest challenge, which somebody may film who once has the badge, and plays and pauses later."""
    once, _, most = _sums(pace)
    return most / once


def _sums(pace: Pace) -> tuple[float, float, float]:
    """Over all challenges with enough moves to a side: sum of probabilities, sum of their squares, the greatest."""
    kept, moves = np.zeros(3), pace.moves
    for face_at in range(1, moves):
        # For each place and number of moves to a side.
        sums = {((0, 0, 0), 0): (1.0, 1.0, 1.0)}
        for k in range(moves):
            following: dict[tuple[Place, int], tuple[float, float, float]] = {}
            for (place, aside), (once, twice, most) in sums.items():
                ways = [FACE] if k == face_at else allowed(place)
                share = 1 / len(ways)
                for move in ways:
                    there = moved(place, move), min(aside + sideways(move), pace.sideways)
                    a, b, c = following.get(there, (0.0, 0.0, 0.0))
                    following[there] = a + once * share, b + twice * share**2, max(c, most * share)
            sums = following
        share = 1 / (moves - 1)
        for (_, aside), (once, twice, most) in sums.items():
            if aside == pace.sideways:
                kept += once * share, twice * share**2, 0.0
                kept[2] = max(kept[2], most * share)
    return float(kept[0]), float(kept[1]), float(kept[2])
