"""The table of explanations: its rows, the one that is the cause of what a film shows, and odds in words.

It holds no array, so that a report is shown without NumPy.

Convention: odds are decadic logarithms of the law's over a rival's, above 0 where the law is likelier.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from moireid.verifier import limits
from moireid.verifier.reasons import json_number

#: The honest explanation's name in the table.
LAW = "law"
#: The law plus another motion, and the law but for a while: they lower a score where they fit better, and never raise
#: it.
LAW_PLUS = ("own_motion", "spell")
#: Least calibrated logarithm of the odds, and its words; the same words serve below 0, for the forged explanation.
SCALE = (
    (4.0, "very strong"),
    (3.0, "strong"),
    (2.0, "moderately strong"),
    (1.0, "moderate"),
    (0.3, "weak"),
)


@dataclass(frozen=True)
class Explanation:
    """One row of the table.

    name: of the explanation; log10_odds: of the law over it, 0 for the law itself;
    parameters: that fit best; share: how often it would look as law-like as this film, None where that is not asked;
    fits: whether it remains as an explanation of this film; share_at_most: the share's upper bound; as_good: whether a
    drift explains each part of the film as well as the law does.
    """

    name: str
    log10_odds: float | None
    parameters: dict[str, float]
    share: float | None
    fits: bool
    share_at_most: float | None = None
    as_good: bool = False

    @property
    def better_than_law(self) -> bool:
        """Whether it fits the film better than the law does, by more than chance."""
        return self.log10_odds is not None and self.log10_odds < -limits.MAX_RIVAL_LOG10

    @property
    def close(self) -> bool:
        """Whether it leaves no more of the film than the law may leave of one that could be honest."""
        left, limit = (self.parameters.get(name) for name in ("deviation_rad", "explains_below_rad"))
        return left is not None and limit is not None and left <= limit

    def ahead_of(self, others: Sequence[Explanation]) -> bool:
        """Whether it is better than each of the others by more than chance."""
        odds = [one.log10_odds for one in others if one.log10_odds is not None and one is not self]
        return self.log10_odds is not None and self.log10_odds < min(odds, default=0.0) - limits.MAX_RIVAL_LOG10

    def to_json(self) -> dict[str, Any]:
        """As an entry of `explanations` of `verify --json`."""
        shown = {"name": self.name, "log10_odds": json_number(self.log10_odds), "fits": self.fits}
        parameters = {name: json_number(value) for name, value in self.parameters.items()}
        shares = {"share": json_number(self.share), "share_at_most": json_number(self.share_at_most)}
        return shown | shares | {"parameters": parameters}


def cause_of(table: Sequence[Explanation]) -> Explanation | None:
    """The rival that says what the fringes of a film do instead of the law; None where none is better than the law.

    1. What was measured of the whole motion, where it leaves as little as the law must: `still`, `another_gain`.
    2. Another motion of the whole film that leaves as little, and is better than all others by more than chance; then
       the law but for a while, if it leaves as little of the rest of the film.
    3. Else only that the fringes move by themselves.

    Convention: table: of a film, without the law's own row.
    """
    whole = [one for one in table if one.name not in LAW_PLUS]
    better = [one for one in table if one.better_than_law]
    close = [one for one in better if one.close]
    measured = [one for one in close if one.name in ("still", "another_gain")]
    clear = [one for one in close if one.name == "spell" or (one in whole and one.ahead_of(whole))]
    rest = [one for one in better if one.name == "own_motion"]
    return next(iter([*measured, *clear, *rest]), None)


def in_words(log10: float) -> str:
    """The support that calibrated odds give, as a sentence's end."""
    for least, words in SCALE:
        if abs(log10) >= least:
            return f"{words} support for {'the law' if log10 > 0 else 'another explanation'}"
    return "no support either way"
