"""The table of explanations, for people: what could have moved the fringes, and which explanations remain.

Convention: odds are those of the law over a rival, so they count against the rival; a share is in how many of 100 cases
a rival would look as much like the law as this film does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from moireid.verifier.decision.comparison import CONTAINING, LAW
from moireid.verifier.decision.figures import in_words
from moireid.verifier.decision.findings import NAMED_RESIDUAL_SHARE
from moireid.verifier.explanations.rivals import RIVALS
from moireid.verifier.limits import CALIBRATION_CAP_LOG10, MAX_RIVAL_LOG10, MAX_RIVAL_SHARE

#: An entry of `explanations`, as in the JSON of a report.
Entry = Mapping[str, Any]
#: What the fringes would do, as the end of "the fringes would ...".
DOES = {
    LAW: "follow the law of optics, with errors that every film has",
    **{rival.name: rival.words for rival in RIVALS},
    "place": "go with the badge's place in the picture",
    "spell": "leave the law for a while",
    "wander": "follow the law, and wander on top of it",
    "rows": "follow the law, but each row a little differently",
    "places": "follow the law, but each place of a row a little differently",
    "photographs_at_one_distance": "be those of photographs from one distance, moved by the law",
    "photographs_in_turn": "be those of a few photographs, shown in turn or faded into each other",
    "photographs_faded": "be those of more photographs, faded into each other",
    "photographs_laid_over": "be those of photographs, all placed over each other",
}
#: Rivals that are judged by the spacing and shape of the fringes, and not by their motion.
PHOTOGRAPHS = tuple(name for name in DOES if name.startswith("photographs"))
#: Reminder that is shown with all odds.
NO_PROBABILITY = (
    "They are no probability that the film is genuine: for that, one must also know how many films are forged in the "
    "first place."
)


@dataclass(frozen=True)
class RivalRow:
    """One explanation: what the fringes would do, the odds against it as a power of ten, its share in 100 cases, and
    whether it remains; law: whether it is the law of optics itself.
    """

    does: str
    power: str
    share: str
    remains: bool
    law: bool = False


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
    factor, cases = 10**MAX_RIVAL_LOG10, 100 * MAX_RIVAL_SHARE
    compared = (
        f"The law of optics and {rivals} other explanations of how the fringes moved, and of their shape, were each "
        f"fitted to this film. Another explanation remains if it fits the film more than {factor:.0f} times better "
        f"than the law does, or if it would look as much like the law as this film does in more than {cases:.0f} of "
        "100 cases."
    )
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


def best_rival(document: Mapping[str, Any]) -> Entry | None:
    """The rival that explains a film better than the law does; None if none does so by more than chance.

    Convention: as `decision.findings`; one that names a motion of the fringes, with a small residual, comes before one
        that only adds freedom to the law; of several that are equally good within a factor of ten, the first of the
        table, which is the simplest.
    """
    better = [one for one in _rivals(document) if one["log10_odds"] < -MAX_RIVAL_LOG10]
    most = NAMED_RESIDUAL_SHARE * ((document.get("invariant") or {}).get("excitation_rad") or 0.0)
    close = [one for one in better if one["parameters"].get("residual_rad", 0.0) <= most]
    specific = [one for one in close if one["name"] not in CONTAINING]
    return simplest(specific or better)


def simplest(entries: Sequence[Entry]) -> Entry | None:
    """Of entries with odds, the first whose odds are within a factor of ten of the best; None of none."""
    least = min((one["log10_odds"] for one in entries), default=0.0)
    return next((one for one in entries if one["log10_odds"] <= least + MAX_RIVAL_LOG10), None)


def _rivals(document: Mapping[str, Any]) -> list[Entry]:
    """All rivals of the motion that have odds."""
    known = document.get("explanations") or []
    return [one for one in known if one["name"] not in (LAW, *PHOTOGRAPHS) and one["log10_odds"] is not None]


def _row(entry: Entry) -> RivalRow:
    law, odds, share = entry["name"] == LAW, entry["log10_odds"], entry["share"]
    does = DOES.get(entry["name"], entry["name"].replace("_", " "))
    if detail := _detail(entry):
        does = f"{does} ({detail})"
    power = "" if law or odds is None else _power(odds)
    return RivalRow(does, power, "" if share is None else _share(share), bool(entry["fits"]), law)


def _detail(entry: Entry) -> str:
    """The parameters that fit best, in a few words; "" if there is none of use to people."""
    found = {name: value for name, value in entry["parameters"].items() if value is not None}
    if "start_s" in found and "end_s" in found:
        return f"at best from {found['start_s']:.1f} to {found['end_s']:.1f} s"
    if "late_s" in found:
        return f"at best {abs(found['late_s']):.2g} s {'late' if found['late_s'] > 0 else 'early'}"
    if "photographs" in found:
        return f"at best {found['photographs']:.0f} of them"
    if "gain" in found and entry["name"] != LAW:
        return f"at best {found['gain']:.2g} times as far"
    return ""


def _power(log10: float) -> str:
    """A power of ten in words of figures: 2.5, −5.4, 182."""
    text = f"{log10:.0f}" if abs(log10) >= 10 else f"{log10:.1f}"
    text = "0" if float(text) == 0 else text
    return text.replace("-", "−")


def _share(share: float) -> str:
    return "0" if share == 0 else f"{100 * share:.2g}"
