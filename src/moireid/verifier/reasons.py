"""Reasons: the findings behind a verdict, each with measured value, limit and unit."""

from __future__ import annotations

import math
from collections.abc import Set
from dataclasses import asdict, dataclass
from typing import Any, Literal

Verdict = Literal["accept", "reject", "inconclusive"]
Level = Literal["pass", "fail", "undecided", "note"]


@dataclass(frozen=True)
class Reason:
    """One finding: `code` is stable for programs, `text` is a sentence for people."""

    code: str
    level: Level
    measured: float | str | None
    limit: float | str | None
    unit: str
    text: str

    def to_json(self) -> dict[str, Any]:
        """As a JSON object; figures that are not finite become null."""
        return {key: json_number(value) for key, value in asdict(self).items()}


def json_number(value: Any) -> Any:
    """The value, rounded to six significant digits if a float, or None if JSON has no such number."""
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def worst(reasons: list[Reason]) -> Verdict:
    """The verdict from its reasons: "reject" if one fails, else "inconclusive" if one is undecided or none passes."""
    return worst_level({reason.level for reason in reasons})


def worst_level(levels: Set[Level]) -> Verdict:
    """As `worst`, from the levels of the reasons."""
    if "fail" in levels:
        return "reject"
    if "undecided" in levels or "pass" not in levels:
        return "inconclusive"
    return "accept"
