"""The chance that an older film follows a challenge, and what is wrong with the picture of a call.

An older film is the right answer to an earlier challenge, drawn as this one is.  In a call the part of the window in
which one person is shown, the *tile*, may be too small or show several people (`TileWatch`).

Convention: chances from 0 to 1; the pictures of a tile come without their surroundings.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.picture import Frame
from moireid.verifier.reasons import Reason
from moireid.verifier.session.faces import FaceFinder
from moireid_studio.challenge.challenge import FACE, Place, allowed, moved, sideways
from moireid_studio.challenge.clock import HERE, SOONEST_S, Pace


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

    In a call it is that of a replay, as a forger may pause an older film until a prompt is read aloud.
    Source: summed over places on the grid and moves to a side, without the challenges that are drawn again.
    """
    once, twice, _ = _sums(pace)
    return twice / once**2


def likeliest_chance(pace: Pace = HERE) -> float:
    """Chance of the likeliest challenge, which a thief of the badge may film once, and play and pause later."""
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


#: Least width of a tile, px; those of `moireid lab bench live` have 960.
LEAST_WIDTH_PX = 480
#: A picture that repeats the last one is left out for so long after it.  A call whose picture was lost shows the one
#: before again: taken for a badge at rest, it would make the next one look like a jump.  No longer than that of two
#: pictures, because a call in which nothing moves must still be seen to rest.
REPEATS_S = 0.08
#: Time between two counts of faces, s, and the share of them that may find several: a poster, or a passer-by.
COUNT_S, MOST_CROWDED = 2.0, 0.25


class TileWatch:
    """Looks at a tile now and then.  Raises: MissingExtraError where dlib is not installed."""

    def __init__(self) -> None:
        self._finder = FaceFinder()
        self._due_s, self._taken_s = -np.inf, -np.inf
        self._last: NDArray[np.uint8] | None = None
        self.width_px, self.looks, self.crowded = 0, 0, 0
        #: Whether the tile left its place, or changed its size; another person may be in it since.
        self.moved = False

    def repeated(self, luma: NDArray[np.uint8], arrival_s: float) -> bool:
        """Whether a picture only repeats the one before, as where one was lost on its way."""
        if self._last is not None and arrival_s - self._taken_s < REPEATS_S and np.array_equal(luma, self._last):
            return True
        self._last, self._taken_s = luma, arrival_s
        return False

    def push(self, frame: Frame) -> None:
        """Take a frame."""
        self.width_px = frame.luma.shape[1]
        if frame.time_s >= self._due_s:
            self._due_s = frame.time_s + COUNT_S
            self.looks += 1
            self.crowded += self._count(frame.luma) > 1

    def _count(self, luma: NDArray[np.uint8]) -> int:
        return len(self._finder.all(luma))

    def reasons(self) -> tuple[Reason, ...]:
        """Findings on what was seen so far; none where all is well."""
        found: tuple[Reason, ...] = ()
        if self.looks and self.width_px < LEAST_WIDTH_PX:
            text = f"The tile is {self.width_px} px wide; enlarge it to {LEAST_WIDTH_PX} px or more, or pin the person."
            found += (Reason("tile", "undecided", float(self.width_px), float(LEAST_WIDTH_PX), "px", text),)
        if self.moved:
            text = "The tile moved or changed its size. Pin the person, choose the tile again, and begin again."
            found += (Reason("tile_moved", "undecided", 1.0, 0.0, "moves", text),)
        share = self.crowded / max(self.looks, 1)
        if share > MOST_CROWDED:
            text = (
                f"More than one face was in the tile at {share:.0%} of the looks. Whose hand holds the badge is not "
                "known then; ask that one person alone is seen, and begin again."
            )
            found += (Reason("faces", "undecided", share, MOST_CROWDED, "share", text),)
        return found
