"""Table and plot of films made up.  Each test states what it would catch."""

from __future__ import annotations

import re
from typing import Any

import pytest

from moireid_lab.bench.forgers.cases import cases
from moireid_lab.bench.suites import SUITES


def row(case: str, verdict: str, *why: str, genuine: bool = False, seconds: float = 2.0) -> dict[str, Any]:
    return {"case": case, "genuine": genuine, "seed": 0, "verdict": verdict, "why": list(why), "seconds": seconds}


@pytest.fixture
def result() -> dict[str, Any]:
    rows = [
        row("8 photographs", "inconclusive", "spacing", "late"),
        row("8 photographs", "inconclusive", "spacing", seconds=3.0),
        row("8 photographs", "accept", seconds=4.0),
        row("frozen", "reject", "gain"),
        row("plain", "accept", genuine=True),
        row("a hand", "inconclusive", "covered", genuine=True),
    ]
    return {"suite": "forgers", "rows": rows}


def test_the_table_counts_verdicts_of_each_case_under_its_heading(result):
    """Catches: inconclusive films among the rejected, a genuine case under the forgeries, a reason that is rare."""
    lines = SUITES["forgers"].table(result).splitlines()
    cells = {line[:58].strip(): line[58:].split() for line in lines}
    assert cells["8 photographs"] == ["1", "2", "0", "3.0", "spacing"]
    assert cells["frozen"] == ["0", "0", "1", "2.0", "gain"]
    assert cells["plain"] == ["1", "0", "0", "2.0"] and cells["a hand"] == ["0", "1", "0", "2.0", "covered"]
    order = [line[:58].strip() for line in lines]
    assert order.index("frozen") < order.index("genuine, as hands and editors spoil it") < order.index("plain")


def test_the_plot_has_a_bar_of_one_for_each_case_in_the_table_s_order(result):
    """Catches: bars that are left out or turned round, verdicts drawn over one another, headings taken for cases."""
    (axes,) = SUITES["forgers"].plot(result).axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert [name for name in names if not name.startswith("genuine") and name != "forged"] == [
        "8 photographs",
        "frozen",
        "plain",
        "a hand",
    ]
    shares = {bars.get_label(): dict(zip(names, bars, strict=True)) for bars in axes.containers}
    assert [
        shares[label]["8 photographs"].get_width() for label in ("accept", "inconclusive", "reject")
    ] == pytest.approx([1 / 3, 2 / 3, 0])
    assert shares["inconclusive"]["8 photographs"].get_x() == pytest.approx(1 / 3)
    assert shares["reject"]["frozen"].get_width() == shares["accept"]["plain"].get_width() == 1
    # From the top.
    assert axes.get_ylim()[0] > axes.get_ylim()[1]


@pytest.mark.parametrize("genuine", [True, False])
def test_a_result_of_one_kind_alone_is_reported_too(result, genuine):
    """Catches: a crash on a partial run, an empty heading in the plot."""
    part = {"rows": [one for one in result["rows"] if one["genuine"] == genuine]}
    (axes,) = SUITES["forgers"].plot(part).axes
    bold = [label.get_text() for label in axes.get_yticklabels() if label.get_fontweight() == "bold"]
    assert bold == ["genuine, as hands and editors spoil it" if genuine else "forged"]
    assert SUITES["forgers"].table(part)


def test_no_two_cases_have_one_name_and_all_fit_the_table():
    """Catches: films of two cases counted as one; a name that runs into the figures."""
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names) and max(map(len, names)) < 58
    assert {case.genuine for case in cases()} == {True, False}
    assert not [name for name in names if re.search(r"\d%", name)]
