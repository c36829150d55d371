"""The benches' own arithmetic, on rows made of numbers.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from moireid_lab.bench import stability as stability
from moireid_lab.bench.identity import identity_suite as identity


def test_every_clip_of_a_bench_has_chance_of_its_own():
    """Catches: one payload or motion for all, a seed that shifts with the number of clips, the copy built as the
    original is.
    """
    few, many = identity.clips_of(2, 0), identity.clips_of(3, 0)
    assert many[: len(few)] == few and identity.clips_of(2, 1) != few
    payloads = [clip.payload for name, clip in many if name not in ("original", "copy")]
    assert len(set(payloads)) == len(payloads) and len({clip.motion_seed for _, clip in many}) == len(many)
    by_kind = {name: clip for name, clip in few if name in ("enrolled", "original", "copy")}
    assert by_kind["original"].build_seed == by_kind["enrolled"].build_seed == by_kind["copy"].build_seed
    assert by_kind["original"].assembly_seed is None and by_kind["copy"].assembly_seed is not None


@pytest.mark.parametrize(
    ("expected", "verdict", "decoded", "codes", "outcome"),
    [
        ("read", "accept", "aa", [], "right"),
        ("read", "inconclusive", "aa", ["gain"], "right"),
        ("read", "inconclusive", None, ["identity"], "inconclusive"),
        ("read", "reject", "aa", ["gain"], "wrong"),
        ("read", "accept", "bb", [], "wrong"),
        ("accept", "accept", "aa", [], "right"),
        ("accept", "inconclusive", "aa", ["gain"], "inconclusive"),
        ("motion", "inconclusive", None, ["motion", "identity"], "right"),
        ("motion", "inconclusive", None, ["identity"], "inconclusive"),
        ("motion", "accept", "aa", [], "wrong"),
        ("motion", "reject", None, ["motion", "cells"], "wrong"),
        ("accept or inconclusive", "inconclusive", None, ["gain"], "right"),
        ("accept or inconclusive", "reject", None, ["correlation"], "wrong"),
    ],
)
def test_a_case_is_wrong_where_it_names_another_or_rejects_a_true_badge(expected, verdict, decoded, codes, outcome):
    """Catches: a wrong identity or a rejection excused; an acceptance without motion called right; any reason taken for
    the right one."""
    report = SimpleNamespace(verdict=verdict, identity=SimpleNamespace(decoded_id=decoded))
    case, badge = stability.StabilityCase("", expected), SimpleNamespace(id="aa")
    assert stability.outcome_of(case, report, badge, codes) == outcome
    other_way = stability.StabilityCase("", beat=-1.0)
    if verdict == "reject":
        assert stability.outcome_of(other_way, report, badge, codes) == "refused"
