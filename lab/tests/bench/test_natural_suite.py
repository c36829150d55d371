"""Which films the suite makes, and one of them judged.  Each test names what it would catch."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from moireid.errors import SpecError
from moireid.simulate.motion import NAMED
from moireid.verifier.session.chapters import CHAPTER_FRAMES
from moireid_lab.bench import natural
from moireid_lab.bench.bench_frame import Wish
from moireid_lab.bench.natural import DISTANCES_M, LENGTHS_S, MOTIONS, QUICK_LENGTHS_S, cases, usual


def test_every_motion_is_filmed_at_every_distance():
    """Catches: two cases under one name; a motion that does not exist; a film of more than one chapter."""
    assert {case.name for case in cases()} == {f"{motion} {away:g} m" for motion in MOTIONS for away in DISTANCES_M}
    assert set(MOTIONS) <= set(NAMED) and set(QUICK_LENGTHS_S) <= set(LENGTHS_S)
    assert natural.FRAMES == 1200 and natural.FRAMES <= CHAPTER_FRAMES
    assert [case.name for case in cases() if usual(case, quick=True)] == ["walk 1 m"]
    assert all(usual(case, quick=False) for case in cases())


def test_rows_are_of_the_parts_of_each_film(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: a run that begins anew; a quick run that shows every length; rows that do not name their film."""
    made: list[tuple[str, int, int]] = []

    def films(work: Any, jobs: Any, **how: Any) -> list[dict[str, Any]]:
        made.extend(job for _, job in jobs)
        assert how["kept"] == tmp_path / "natural.jsonl" and all(f"{job[0]}|{job[1]}" in key for key, job in jobs)
        return [
            {"case": name, "seed": seed, "parts": [{"seconds": seconds} for seconds in LENGTHS_S]}
            for _, (name, seed, _) in jobs
        ]

    monkeypatch.setattr("moireid_lab.bench.bench_frame.made_rows", films)
    asked = Wish(seed=4, kept=tmp_path / "natural.jsonl")
    rows = list(natural.rows(replace(asked, clips=2, only="^sway 2 m$")))
    assert made == [("sway 2 m", seed, natural.FRAMES) for seed in (4, 5)]
    assert rows[-1] == {"motion": "sway", "distance_m": 2.0, "seed": 5, "seconds": 40}
    assert len(rows) == 2 * len(LENGTHS_S)
    made.clear()
    rows = list(natural.rows(replace(asked, quick=True)))
    assert made == [("walk 1 m", 4, natural.FRAMES)] and [row["seconds"] for row in rows] == [4, 10]
    with pytest.raises(SpecError, match="no case's name holds 'run'"):
        list(natural.rows(replace(asked, only="run")))


@pytest.mark.slow
def test_a_short_film_is_judged_in_parts():
    """Catches: a part judged on the whole track; a row that JSON cannot hold; a true badge that is not accepted."""
    found = natural.run_case(("sway 1 m", 0, 8 * natural.FPS))
    rows = natural.rows_of_film(found, LENGTHS_S)
    assert [(row["seconds"], row["start_s"], row["frames"]) for row in rows] == [(7, 0, 210), (4, 0, 120)]
    assert all((row["verdict"], row["identity"]) == ("accept", "match") for row in rows)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
