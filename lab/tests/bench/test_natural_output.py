"""Table and plot of rows made up.  Each test names what it would catch."""

from __future__ import annotations

import math
from typing import Any

import pytest

from moireid_lab.bench.natural import accepted_share, groups, median_odds, nested_pairs, with_enough_motion
from moireid_lab.bench.suites import SUITES


def row(seconds: int, start_s: int, verdict: str, *why: str, **more: Any) -> dict[str, Any]:
    usual = {"motion": "walk", "distance_m": 1.0, "seed": 0, "score": 2.0, "excitation_rad": 0.5, "judge_s": 0.6}
    part = {"seconds": seconds, "start_s": start_s, "frames": 30 * seconds, "verdict": verdict, "why": list(why)}
    return usual | part | more


@pytest.fixture
def result() -> dict[str, Any]:
    rows = [
        row(10, 0, "accept", score=4.0, judge_s=1.2),
        row(10, 10, "inconclusive", "spacing", score=1.0),
        row(4, 0, "inconclusive", "motion", score=None, excitation_rad=None),
        row(4, 10, "accept", "motion", excitation_rad=0.2),
        row(4, 0, "reject", distance_m=2.0),
        row(4, 0, "accept", motion="sway"),
    ]
    return {"suite": "natural", "rows": rows}


def test_groups_are_in_the_order_of_motions_distances_and_lengths(result):
    """Catches: lengths in the order of the rows; two distances in one group."""
    keys = [("walk", 1.0, 4), ("walk", 1.0, 10), ("walk", 2.0, 4), ("sway", 1.0, 4)]
    assert list(groups(result)) == keys
    assert [len(rows) for rows in groups(result).values()] == [2, 2, 1, 1]


def test_figures_are_those_of_the_rows_that_have_them(result):
    """Catches: odds that are missing counted as 0; a film without excitation counted as one that moves."""
    near = groups(result)["walk", 1.0, 4]
    assert accepted_share(near) == 0.5 and median_odds(near) == 2.0 and math.isnan(median_odds(near[:1]))
    assert with_enough_motion([*near, row(4, 0, "accept", excitation_rad=0.3)]) == [
        row(4, 0, "accept", excitation_rad=0.3)
    ]


def test_nested_pairs_are_of_one_film(result):
    """Catches: a part compared with one that does not hold it, or of another film; the order of verdicts reversed."""
    assert nested_pairs(result["rows"]) == (1, 2)
    rows = [row(20, 0, "reject"), row(10, 10, "inconclusive"), row(10, 15, "accept"), row(20, 5, "accept", seed=1)]
    assert nested_pairs(rows) == (1, 1)
    assert nested_pairs([row(10, 0, "accept"), row(10, 0, "reject")]) == (0, 0)


def test_the_table_has_a_line_for_each_group(result):
    """Catches: columns of another verdict; seconds for milliseconds; pairs that are not counted."""
    lines = [" ".join(line.split()) for line in SUITES["natural"].table(result).splitlines()]
    assert lines[1] == "walk 1 m 4 s 2 1 1 0 0 of 0 2.00 600 5.00 motion"
    assert lines[2] == "walk 1 m 10 s 2 1 1 0 1 of 2 2.50 900 3.00 spacing"
    assert lines[3] == "walk 2 m 4 s 1 0 0 1 0 of 1 2.00 600 5.00"
    assert lines[-1] == "the longer part's verdict is worse than that of a part inside it: 1 of 2 pairs"


def test_the_plot_has_a_line_for_each_motion_and_distance(result):
    """Catches: distances in one line; lengths that are not in order; odds drawn as shares."""
    shares, odds = SUITES["natural"].plot(result).axes
    drawn = {line.get_label(): (list(line.get_xdata()), list(line.get_ydata())) for line in shares.lines}
    assert drawn == {"walk 1 m": ([4, 10], [0.5, 0.5]), "walk 2 m": ([4], [0.0]), "sway 1 m": ([4], [1.0])}
    assert list(odds.lines[0].get_ydata()) == [2.0, 2.5]
    assert [label.get_text() for label in odds.get_xticklabels()] == ["4", "10"]
