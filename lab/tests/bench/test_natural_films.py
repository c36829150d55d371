"""Parts of films on natural motion, and their figures.  Each test names what it would catch."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from kit.places import ROOT


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import natural_films

    return natural_films


def part(length_s: int, start_s: int, verdict: str, film: str = "a", **more: Any) -> dict[str, Any]:
    usual = {"kind": "true", "distance_m": 1.0, "score": 2.0, "excitation_rad": 0.5, "judge_s": 0.6, "why": "motion"}
    own = {"film": film, "length_s": length_s, "start_s": start_s, "frames": 30 * length_s, "verdict": verdict}
    return usual | own | more


def test_no_part_overlaps_another_of_its_length_and_all_are_inside_longer_ones(bench: Any):
    """Catches: parts that reach over a longer one's end, so that pairs are lost; a fifth part."""
    starts = bench.part_starts((4, 7, 10, 20, 40), 40)
    assert starts == {40: [0], 20: [0, 20], 10: [0, 10, 20, 30], 7: [0, 10, 20, 30], 4: [0, 10, 20, 30]}
    for longer, length in pairwise(starts):
        assert np.all(np.diff(starts[length]) >= length)
        assert all(any(a <= b and b + length <= a + longer for a in starts[longer]) for b in starts[length])
    assert bench.part_starts((4, 7, 40), 13) == {7: [0], 4: [0]}


def test_figures_are_of_the_parts_that_have_them_and_pairs_of_one_film(bench: Any):
    """Catches: odds that are missing counted as 0; a part compared with one that does not hold it, or of another film;
    a forgery among the true parts."""
    rows = [
        part(10, 0, "accept", score=4.0),
        part(4, 0, "inconclusive", score=None, excitation_rad=None),
        part(4, 2, "reject", film="b"),
        part(10, 1, "accept", film="b", kind="drift"),
        part(4, 4, "accept", excitation_rad=0.2),
        part(10, 10, "inconclusive"),
    ]
    short, long, lies, passed, pairs = bench.table(rows)
    assert (short["accept"], short["log10 odds"], short["of >= 0.3 rad"]) == (1, 2.0, "0 of 1")
    assert (long["accept"], long["inconclusive"], lies["forged"], passed["accepted"]) == (1, 1, "drift", "b")
    assert pairs == {"pairs of parts": 2, "longer worse": 0}
    rows += [part(10, 20, "inconclusive"), part(4, 21, "accept")]
    assert list(bench.table(rows))[-1] == {"pairs of parts": 3, "longer worse": 1}
