"""The films: each motion at 1 m and 2 m, of a true badge."""

from __future__ import annotations

from dataclasses import dataclass

#: Two measured motions, and one that is made.
MOTIONS = ("walk", "handheld", "sway")
DISTANCES_M = (1.0, 2.0)
#: Lengths of the parts that are judged, s.
LENGTHS_S = (4, 7, 10, 20, 40)
QUICK_LENGTHS_S = (4, 10)


@dataclass(frozen=True)
class Case:
    """motion: of `simulate.motion`; distance_m: mean distance of camera and badge, m."""

    motion: str
    distance_m: float

    @property
    def name(self) -> str:
        """As `--only` matches it and rows are kept by it."""
        return f"{self.motion} {self.distance_m:g} m"


def cases() -> list[Case]:
    """All of them."""
    return [Case(motion, distance) for motion in MOTIONS for distance in DISTANCES_M]


def usual(case: Case, *, quick: bool) -> bool:
    """Whether a case is filmed unless asked for by name; quick: the walk at 1 m alone."""
    return not quick or (case.motion, case.distance_m) == (MOTIONS[0], DISTANCES_M[0])
