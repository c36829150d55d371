"""Which films the suite makes, and one of them judged.  Each test states what it would catch."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from moireid.errors import SpecError
from moireid.simulate.effects.table import KINDS, STRENGTHS
from moireid.simulate.forgeries.trajectories import KINDS as FORGED
from moireid.simulate.motion import NAMED
from moireid_lab.bench import reality
from moireid_lab.bench.bench_frame import Wish
from moireid_lab.bench.reality import DISTANCES_M, FORGERIES, NOTHING, cases, usual


def test_every_effect_is_filmed_at_every_strength_and_distance():
    """Catches: an effect that is new and not measured; two cases under one name; a forgery that is none."""
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names) and cases()[0].effect == NOTHING and cases()[0].badge == "true"
    true = {(case.effect, case.strength, case.distance_m) for case in cases() if case.badge == "true"}
    assert true >= {(effect, strength, away) for effect in KINDS for strength in STRENGTHS for away in DISTANCES_M}
    assert {case.badge for case in cases()} == {"true", *FORGERIES} and set(FORGERIES) <= set(FORGED)
    assert set(reality.MOTIONS) <= set(NAMED)


def test_forged_films_are_ordinary_and_quick_ones_true_and_near():
    """Catches: hours of films that were not asked for; true films of a strength that are forgotten."""
    whole = [case for case in cases() if usual(case, quick=False)]
    quick = [case for case in cases() if usual(case, quick=True)]
    assert {case.strength for case in whole if case.badge != "true"} == {"ordinary"}
    assert {case.strength for case in whole if case.badge == "true"} == set(STRENGTHS)
    assert len(quick) == 1 + len(KINDS) and {(case.badge, case.distance_m) for case in quick} == {("true", 1.0)}


def test_rows_are_kept_and_only_finds_what_is_not_usual(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: a run that begins anew; `--only` that cannot ask for a strongly changed forged film."""
    made: list[tuple[str, int, int]] = []

    def rows(work: Any, jobs: Any, **how: Any) -> list[dict[str, Any]]:
        made.extend(job for _, job in jobs)
        assert how["kept"] == tmp_path / "reality.jsonl" and all(f"{job[0]}|{job[1]}" in key for key, job in jobs)
        return []

    monkeypatch.setattr("moireid_lab.bench.bench_frame.made_rows", rows)
    asked = Wish(seed=4, kept=tmp_path / "reality.jsonl")
    assert list(reality.rows(replace(asked, clips=2, only="^zoom:strong 2 m gain_low$"))) == []
    assert made == [("zoom:strong 2 m gain_low", seed, reality.FRAMES) for seed in (4, 5)]
    made.clear()
    list(reality.rows(replace(asked, quick=True)))
    assert len(made) == 1 + len(KINDS)
    with pytest.raises(SpecError, match="no case's name holds 'zooom'"):
        list(reality.rows(replace(asked, only="zooom")))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "verdict"), [("none:ordinary 1 m true", "accept"), ("none:ordinary 1 m reversed", "reject")]
)
def test_a_film_without_effects_is_judged_as_it_is(name, verdict):
    """Catches: a forged film made as a true one; a row that JSON cannot hold."""
    row = reality.run_case((name, 0, 240))
    assert row["verdict"] == verdict and row["tracked"] == 240 and row["badge"] == name.split()[-1]
    assert json.loads(json.dumps(row, allow_nan=False)) == row | {"axis_px": list(row["axis_px"])}
