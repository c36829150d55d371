"""The frame of benches: tables, choice of cases, output.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from kit.in_place import in_place
from moireid.errors import SpecError
from moireid_lab.bench import bench_frame, bench_rows
from moireid_lab.bench.bench_frame import Wish
from moireid_lab.evaluation.text_table import table_lines

COLUMNS = {"film": "name <6", "gain": ">7.2f", "share": "fine.share >6.0%", "why": "<1", "sum": ">4"}


def test_a_row_shows_what_it_has_of_the_columns():
    """Catches: columns in a row's own order, a heading that is no key of the row, a table that goes on under others."""
    rows = [
        {"gain": 1.234, "name": "a", "why": ["x", "y"], "hidden": 1},
        {"gain": None, "name": "long name", "why": []},
        {"sum": 2},
        {"fine": {"share": 0.5}, "name": "b"},
    ]
    assert list(table_lines(rows, COLUMNS)) == [
        "film      gain why",
        "a         1.23 x y",
        "long name       -",
        "",
        " sum",
        "   2",
        "",
        "film    share",
        "b         50%",
    ]


def test_names_are_those_that_are_asked_for():
    """Catches: a name that no case has taken for all."""
    assert Wish(only="^b").chosen(["ab", "ba"]) == ["ba"]
    with pytest.raises(SpecError, match="no case's name holds 'z'"):
        Wish(only="z").chosen(["a"])


def test_each_gives_rows_by_name_and_keeps_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: a kept row that is made again, or is of another program, seed or length; rows of cases that were not
    wanted, progress that is not reported."""
    monkeypatch.setattr(bench_rows, "run_tasks", in_place)
    made, steps = list[int](), list[tuple[int, int | None]]()
    wish = Wish(only="[ab]", kept=tmp_path / "rows.jsonl", progress=lambda *step: steps.append(step))

    def work(job: int) -> dict[str, int]:
        made.append(job)
        return {"value": job}

    for _ in range(2):
        assert [row["value"] for row in wish.each(work, {"a": 1, "b": 2, "c": 3})] == [1, 2]
    assert made == [1, 2] and steps == [(1, 2), (2, 2)]
    for other in (replace(wish, quick=True), replace(wish, seed=1)):
        assert len(list(other.each(work, {"a": 1}))) == 1
    monkeypatch.setattr(bench_frame, "sources_digest", lambda module: "another program")
    assert len(list(wish.each(work, {"a": 1}))) == 1 and made == [1, 2, 1, 1, 1]
