"""The findings of a report in the order in which people need them: failures, what is inconclusive, warnings, passes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

#: One finding, as in the JSON of a report.
Finding = Mapping[str, Any]
#: What says most comes first; all other codes follow as they were found.
WEIGHTIEST = (
    *("revoked", "suspended", "expired"),
    *("name", "identities", "identity", "beats", "enrolled", "genuine", "built", "cells_move"),
    # Rivals of the law that say what the fringes do; `wander` only says that they leave it.
    *("explanations", "still", "drift", "late", "place", "another_gain", "own_motion", "spell"),
    *("gain", "agreement", "rows", "places", "residual", "spacing", "waveform", "wander"),
)
#: What makes everything else inconclusive comes before what it makes inconclusive.
CAUSES = (
    *("badge_absent", "fringes", "camera", "mixed_frames", "small", "covered"),
    *("motion_gaps", "phase_gaps", "motion"),
)
#: Notes that warn; all others are for experts.
WARNINGS = frozenset(
    {
        "claim_source",
        "look_alike",
        "chosen_line",
        "hidden_letters",
        "name_derived",
        "copyable",
        "others",
        "times",
        "covered",
        "pose_outliers",
        "challenge",
    }
)


@dataclass(frozen=True)
class Findings:
    """Findings by what they mean: they fail, make the film inconclusive, warn, or hold; the rest is for experts."""

    fail: tuple[Finding, ...]
    open: tuple[Finding, ...]
    warn: tuple[Finding, ...]
    hold: tuple[Finding, ...]
    rest: tuple[Finding, ...]

    @property
    def first(self) -> tuple[Finding, ...]:
        """What is shown unfolded, failures first."""
        return self.fail + self.open + self.warn

    @property
    def failed(self) -> dict[str, Finding]:
        """The first failure of each code."""
        return {finding["code"]: finding for finding in reversed(self.fail)}


def sorted_findings(reasons: Sequence[Finding]) -> Findings:
    """Sort the findings of a report, as in its JSON."""

    def of(*levels: str) -> list[Finding]:
        order = CAUSES + WEIGHTIEST if levels == ("undecided",) else WEIGHTIEST
        return sorted((one for one in reasons if one["level"] in levels), key=lambda one: _rank(one["code"], order))

    notes = of("note")
    return Findings(
        tuple(of("fail")),
        tuple(of("undecided")),
        tuple(note for note in notes if note["code"] in WARNINGS),
        tuple(of("pass")),
        tuple(note for note in notes if note["code"] not in WARNINGS),
    )


def _rank(code: str, order: Sequence[str]) -> int:
    return order.index(code) if code in order else len(order)
