"""The headline of every forgery of `simulate --forge` names what was forged.

By `benchmarks/headlines.py`, on the signals that are kept of the forged golden films (`tests/data/golden`).
"""

from __future__ import annotations

from typing import Any

import pytest

from kit.places import ROOT, TESTS
from moireid.simulate.forgeries.trajectories import KINDS
from moireid.verifier.report.headline import BROKEN

FILMS = sorted((TESTS / "data" / "golden").glob("forged-*.signals"))


@pytest.fixture
def table(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import headlines

    return headlines


def test_no_headline_misleads(table: Any) -> None:
    """Catches: fringes that rest called late; parts that move apart called late; a motion of its own without a size;
    a finding with other words than the headline's; a kind that is added, and whose headline nobody reads."""
    rows = [table.judged(film) for film in FILMS]
    assert [f"{row['kind']} {row['motion']}" for row in rows if row["judged"] != "right"] == []
    assert all(sum(row["kind"] == kind for row in rows) >= 2 for kind in ("true", *KINDS))
    assert [row for row in rows if row["kind"] == "true" and row["verdict"] == "reject"] == []
    for row in rows:
        words = row["headline"].partition("do not follow the law: they ")[2]
        of_a_rival = bool(words) and words != BROKEN["parts"]
        assert any(f"Fringes that {words} explain" in text for text in row["findings"]) == of_a_rival
        if "differ from the law" in row["headline"]:
            assert " of its motion, most from " in row["headline"] or " times its motion, most from " in row["headline"]


def test_what_counts_as_misleading(table: Any) -> None:
    """Catches: a judgement that calls everything right."""
    assert set(table.CAUSES) == {"true", *KINDS}
    late, half = "The fringes do not follow the law: they come late", "they move half as far as they should"
    assert table.is_right("late", "reject", late) and table.is_right("gain_low", "reject", half)
    for kind, title in (("frozen", late), ("patchy", late), ("gain_high", half), ("late", "Genuine"), ("true", late)):
        assert not table.is_right(kind, "reject", title), kind
    assert not table.is_right("drift", "reject", "Not accepted") and table.is_right("drift", "inconclusive", "Cannot")
