"""How strong a film is: of forgeries that know nothing of the law, how few would look as law-like as it does.

A rival's share is estimated by random draws (`rivals.lookalike_shares`), a few at a time, until it is surely above or
below what an acceptance allows.  So the bounds must hold whenever the draws stop.  Only forgeries with a gain that may
be accepted are drawn: the *chance* of such a gain is known in closed form, and is a bound by itself.

The *strength* of a film is 1 in N, where N is one over the upper bound of the largest share.  It says how
much the film's motion tests, as far as the draws showed before they stopped: a greater strength that is asked for takes
more draws, and can show a greater N.  The *score* is a property of the fringes: the log10 odds of the law over the
rivals, each with the parameters that fit this film best; `calibrated_log10` is the same figure, scaled and capped by
how often such scores were right on honest and forged films, and is the likelihood ratio that the words of ENFSI's scale
belong to.  A film is accepted only if both hold: no rival fits as well, and few would by chance.

Convention: shares from 0 to 1.  The prior is even over the ranges of `verifier.limits`.
Source: confidence sequences by the method of mixtures (Robbins 1970): by Ville's inequality, the likelihood of the
    true share is less than `SHARE_UNSURE` times its mean over a Beta density with a probability of at most
    `SHARE_UNSURE`, however often one looks.  Any density gives valid bounds; one hit in as many as an acceptance allows
    gives the closest ones there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from moireid.verifier import limits


@dataclass(frozen=True)
class LookalikeShare:
    """A rival's share: the estimate, and bounds that hold at whatever number of draws it was made."""

    share: float
    at_least: float
    at_most: float

    @classmethod
    def of(cls, alike: int, drawn: int, allowed: float, chance: float = 1.0) -> LookalikeShare:
        """Of draws, how many look like the film.

        Parameters: allowed: share that an acceptance allows; chance: probability that a forgery is one of those drawn.
        """
        low, high = share_bounds(alike, drawn, allowed / chance)
        return cls(chance * alike / max(drawn, 1), chance * low, chance * high)


def share_bounds(alike: int, drawn: int, asked: float) -> tuple[float, float]:
    """Bounds of a probability after so many draws, of which so many were hits; they hold whenever one stops.

    Parameters: asked: probability about which the bounds are to be closest.
    """
    missed, misses = drawn - alike, 1 / min(asked, 1.0)
    mixed = _log_beta(1 + alike, misses + missed) - _log_beta(1, misses)

    def excluded(share: float) -> bool:
        by_hits = alike * math.log(share) if alike else 0.0
        by_misses = missed * math.log1p(-share) if missed else 0.0
        return mixed - by_hits - by_misses >= -math.log(limits.SHARE_UNSURE)

    estimate, tiny = alike / max(drawn, 1), 1e-12
    low = _edge(tiny, estimate, excluded) if alike else 0.0
    high = _edge(1 - tiny, estimate, excluded) if missed else 1.0
    return low, high


def _log_beta(a: float, b: float) -> float:
    return math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)


def _edge(outer: float, inner: float, excluded: Callable[[float], bool]) -> float:
    """Where the shares that are excluded begin, on the way from the estimate outwards, by bisection."""
    if not excluded(outer):
        return round(outer)
    for _ in range(50):
        middle = 0.5 * (outer + inner)
        outer, inner = (middle, inner) if excluded(middle) else (outer, middle)
    return outer


def one_in(at_most: float) -> int:
    """A share's upper bound as 1 in so many, rounded down; 1 where nothing is excluded."""
    return math.floor(1 / max(at_most, 1e-9) + 1e-9)


def strength_json(strength: int | None) -> dict[str, Any] | None:
    """As the `strength` object of `verify --json`; None where the law does not explain the film."""
    if strength is None:
        return None
    words = (
        "This motion excludes no forgery."
        if strength < 2
        else (f"Of forgeries that know nothing of the law, at most 1 in {strength} would look as this film does.")
    )
    return {"one_in": strength, "words": words}
