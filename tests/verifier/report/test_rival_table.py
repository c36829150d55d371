"""The table of explanations.  At each test: the wrong implementation it catches.

Documents are put together by hand, as `verify --json` prints them.
"""

from __future__ import annotations

from typing import Any

import pytest

from moireid.verifier.explanations.rivals import RIVALS
from moireid.verifier.explanations.table import LAW_PLUS, cause_of
from moireid.verifier.explanations.words import WORDS
from moireid.verifier.limits import CALIBRATION_CAP_LOG10
from moireid.verifier.report.rival_table import odds_line, rivals_in, table_of


def entry(name: str, odds: float | None = 5.0, share: float | None = None, **parameters: float) -> dict[str, Any]:
    remains = (odds is not None and odds < -1) or (share or 0.0) > 0.02
    return {"name": name, "log10_odds": odds, "share": share, "fits": remains, "parameters": parameters}


LAW = {"name": "law", "log10_odds": 0.0, "share": None, "fits": True, "parameters": {"gain": 1.0, "lag_rad": 0.01}}


def document(*rivals: dict[str, Any], calibrated: float | None = 1.2) -> dict[str, Any]:
    return {"invariant": {"calibrated_log10": calibrated}, "explanations": [LAW, *rivals]}


def test_each_rival_that_is_compared_has_words() -> None:
    """Catches: a rival that is added and shown by its code, or one that is gone and keeps its words."""
    assert set(WORDS) == {"law", *(rival.name for rival in RIVALS), *LAW_PLUS}
    assert len({words.does for words in WORDS.values()}) == len(WORDS)
    assert {name for name, words in WORDS.items() if not words.remedy} == {"law"}


def test_odds_and_shares_are_shown_as_they_count() -> None:
    """Catches: the sign of the odds turned around; 99 of 100 shown as 0.99; a row that remains and is not marked."""
    table = table_of(document(entry("drift", -5.42, late_s=0.0), entry("late", 182.6, 0.99, late_s=-0.4)))
    assert table is not None
    law, drift, late = table.rows
    assert law[1:] == ("", "", True, True) and drift[1:] == ("−5.4", "", True, False)
    assert late[1:] == ("183", "99", True, False) and "0.4 s early" in late[0]
    assert "2 other explanations" in table.compared and "gain" not in law[0]


@pytest.mark.parametrize(
    ("calibrated", "words", "power"),
    [
        (1.2, "moderate support for the law", "1.2"),
        (-CALIBRATION_CAP_LOG10, "support for another explanation", f"{CALIBRATION_CAP_LOG10:.1f}"),
        (0.01, "no support either way", "0"),
    ],
)
def test_calibrated_odds_are_in_words_and_no_probability(calibrated: float, words: str, power: str) -> None:
    """Catches: odds against the law that read as odds for it; a number that people take for a probability."""
    table = table_of(document(entry("still"), calibrated=calibrated))
    assert table is not None and words in table.support and table.power == power
    assert table.capped == (abs(calibrated) == CALIBRATION_CAP_LOG10)
    line = odds_line(document(entry("still"), calibrated=calibrated))
    assert words in line and "no probability" in line.lower()


def test_what_is_named_is_the_best_by_far_and_explains_the_film() -> None:
    """Catches: a delay named where a constant speed does as well; a cause that leaves most of the film unexplained."""
    fits = {"deviation_rad": 0.01, "explains_below_rad": 0.1}

    def named(*entries: dict[str, Any]) -> str | None:
        cause = cause_of(rivals_in(document(*entries)))
        return None if cause is None else cause.name

    drift, own = entry("drift", -5.4, **fits), entry("own_motion", -27.0)
    assert named(entry("still", -1.0), drift, entry("late", -4.3, **fits), own) == "drift"
    assert named(drift, entry("late", -5.6, **fits), own) == "own_motion"
    assert named(entry("drift", -5.4, deviation_rad=0.2, explains_below_rad=0.1), own) == "own_motion"
    assert named(entry("drift", 4.0, **fits), own) == "own_motion"
    assert named(entry("drift", -0.9, **fits), entry("late", 3.0)) is None
