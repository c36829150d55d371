"""The films: each effect at each strength, at 1 m and 2 m, of a true badge and of forged ones."""

from __future__ import annotations

from dataclasses import dataclass

from moireid.simulate.effects.table import KINDS, STRENGTHS

#: The first row: a film to which nothing was done.
NOTHING = "none"
DISTANCES_M = (1.0, 2.0)
FORGERIES = ("gain_low", "wobble", "drift", "reversed")
#: Of a true badge.
TRUE = "true"


@dataclass(frozen=True)
class Case:
    """effect: of `simulate.effects`, or none; badge: "true", or the kind of the forgery."""

    effect: str
    strength: str
    distance_m: float
    badge: str

    @property
    def name(self) -> str:
        """As `--only` matches it and rows are kept by it."""
        return f"{self.effect}:{self.strength} {self.distance_m:g} m {self.badge}"


def cases() -> list[Case]:
    """All of them, true ones first, the ordinary strength before the others."""
    order = sorted(STRENGTHS, key=lambda strength: strength != "ordinary")
    some = [(NOTHING, "ordinary")] + [(effect, strength) for strength in order for effect in KINDS]
    return [
        Case(effect, strength, distance, badge)
        for badge in (TRUE, *FORGERIES)
        for effect, strength in some
        for distance in DISTANCES_M
    ]


def usual(case: Case, *, quick: bool) -> bool:
    """Whether a case is filmed unless asked for by name: forged ones at the ordinary strength alone; quick: the true
    badge at the ordinary strength, at 1 m.
    """
    if quick:
        return case.badge == TRUE and case.strength == "ordinary" and case.distance_m == DISTANCES_M[0]
    return case.badge == TRUE or case.strength == "ordinary"
