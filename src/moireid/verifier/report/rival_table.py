"""The table of explanations, for people: what could have moved the fringes, and which explanations remain.

Convention: odds are those of the law over a rival, so they count against the rival; a share is in how many of 100 cases
a rival would look as much like the law as this film does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from moireid.verifier.explanations.table import LAW, Explanation, in_words
from moireid.verifier.explanations.words import does
from moireid.verifier.limits import CALIBRATION_CAP_LOG10, MAX_RIVAL_LOG10

#: An entry of `explanations`, as in the JSON of a report.
Entry = Mapping[str, Any]
#: Reminder that is shown with all odds.
NO_PROBABILITY = (
    "They are no probability that the film is genuine: for that, one must also know how many films are forged in the "
    "first place."
)


#: One explanation: what the fringes would do, the odds against it as a power of ten, its share in 100 cases, whether it
#: remains, and whether it is the law of optics itself.
RivalRow = tuple[str, str, str, bool, bool]


@dataclass(frozen=True)
class RivalTable:
    """The rows, the law first; what was compared; the support that the calibrated odds give, in words and as a power of
    ten, "" if it is unknown; capped: whether it is the most that the calibration can give.
    """

    rows: tuple[RivalRow, ...]
    compared: str
    support: str = ""
    power: str = ""
    capped: bool = False


def table_of(document: Mapping[str, Any]) -> RivalTable | None:
    """The table of a report; None if nothing was compared, as in reports of format 1."""
    entries = document.get("explanations") or []
    if not entries:
        return None
    rows = tuple(_row(one) for one in entries)
    rivals = len(rows) - 1
    factor = 10**MAX_RIVAL_LOG10
    compared = (
        f"The law of optics and {rivals} other explanations of how the fringes moved were each "
        f"fitted to this film. Another explanation remains if it fits the film more than {factor:.0f} times better "
        "than the law does, or if too many films of it would look as much like the law as this one does."
    )
    strength = document.get("strength")
    compared += f" {strength['words']}" if strength else ""
    calibrated = (document.get("invariant") or {}).get("calibrated_log10")
    if calibrated is None:
        return RivalTable(rows, compared)
    capped = abs(calibrated) >= CALIBRATION_CAP_LOG10
    return RivalTable(rows, compared, in_words(calibrated), _power(abs(calibrated)), capped)


def odds_line(document: Mapping[str, Any]) -> str:
    """The calibrated odds in one line; "" if they are not known."""
    table = table_of(document)
    if table is None or not table.support:
        return ""
    odds = f"10^{table.power} after calibration, {table.support}"
    return f"{odds}. No probability, as it is unknown how many films are forged."


def rivals_in(document: Mapping[str, Any]) -> list[Explanation]:
    """The rivals of the motion in a report."""
    names = [field.name for field in fields(Explanation)]
    known = [one for one in document.get("explanations") or [] if one["name"] != LAW]
    return [Explanation(**{name: one.get(name) for name in names}) for one in known]


def _row(entry: Entry) -> RivalRow:
    law, odds, share = entry["name"] == LAW, entry["log10_odds"], entry["share"]
    power = "" if law or odds is None else _power(odds)
    words = does(entry["name"], {} if law else entry["parameters"])
    return words, power, "" if share is None else f"{100 * share:.2g}", bool(entry["fits"]), law


def _power(log10: float) -> str:
    """A power of ten in words of figures: 2.5, −5.4, 182."""
    text = f"{log10:.0f}" if abs(log10) >= 10 else f"{log10:.1f}"
    text = "0" if float(text) == 0 else text
    return text.replace("-", "−")
