"""Figures of rows made up.  Each test names what it would catch."""

from __future__ import annotations

import math
from typing import Any

import pytest

from moireid_lab.bench.natural import BENCH, accepted_share, groups, median_odds, nested_pairs, with_enough_motion


def row(seconds: int, start_s: int, verdict: str, *why: str, **more: Any) -> dict[str, Any]:
    usual = {"motion": "walk", "distance_m": 1.0, "seed": 0, "score": 2.0, "excitation_rad": 0.5, "judge_s": 0.6}
    part = {"seconds": seconds, "start_s": start_s, "frames": 30 * seconds, "verdict": verdict, "why": list(why)}
    return usual | part | more


@pytest.fixture
def rows_made() -> list[dict[str, Any]]:
    return [
        row(10, 0, "accept", score=4.0, judge_s=1.2),
        row(10, 10, "inconclusive", "spacing", score=1.0),
        row(4, 0, "inconclusive", "motion", score=None, excitation_rad=None),
        row(4, 10, "accept", "motion", excitation_rad=0.2),
        row(4, 0, "reject", distance_m=2.0),
        row(4, 0, "accept", motion="sway"),
    ]


def test_groups_are_in_the_order_of_motions_distances_and_lengths(rows_made):
    """Catches: lengths in the order of the rows; two distances in one group."""
    keys = [("walk", 1.0, 4), ("walk", 1.0, 10), ("walk", 2.0, 4), ("sway", 1.0, 4)]
    assert list(groups(rows_made)) == keys
    assert [len(rows) for rows in groups(rows_made).values()] == [2, 2, 1, 1]


def test_figures_are_those_of_the_rows_that_have_them(rows_made):
    """Catches: odds that are missing counted as 0; a film without excitation counted as one that moves."""
    near = groups(rows_made)["walk", 1.0, 4]
    assert accepted_share(near) == 0.5 and median_odds(near) == 2.0 and math.isnan(median_odds(near[:1]))
    assert with_enough_motion([*near, row(4, 0, "accept", excitation_rad=0.3)]) == [
        row(4, 0, "accept", excitation_rad=0.3)
    ]


def test_nested_pairs_are_of_one_film(rows_made):
    """Catches: a part compared with one that does not hold it, or of another film; the order of verdicts reversed."""
    assert nested_pairs(rows_made) == (1, 2)
    assert [row["accept"] for row in BENCH.table(rows_made)] == [1, 1, 0, 1]
    rows = [row(20, 0, "reject"), row(10, 10, "inconclusive"), row(10, 15, "accept"), row(20, 5, "accept", seed=1)]
    assert nested_pairs(rows) == (1, 1)
    assert nested_pairs([row(10, 0, "accept"), row(10, 0, "reject")]) == (0, 0)
