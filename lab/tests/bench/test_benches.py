"""Tables and plots of the benches, on films made up.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid_lab.bench.bench_frame import Bench, bench_of
from moireid_lab.bench.bench_plots import plot_of
from moireid_lab.bench.forgers.cases import cases
from moireid_lab.bench.suites import BENCHES, PARTS, SUITES, module_of, names_of


def test_every_bench_can_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a module that was moved; a bench in two suites; a suite of which one bench alone cannot be asked."""
    monkeypatch.setattr("sys.path", list(__import__("sys").path))
    monkeypatch.setenv("PYTHONPATH", "")
    assert sum(map(len, SUITES.values())) == len(BENCHES) and set(PARTS) < set(BENCHES)
    for name in BENCHES:
        assert isinstance(bench_of(name), Bench), name
        assert (name in PARTS) == hasattr(importlib.import_module(module_of(name)), "PART"), name
    assert names_of("natural") == ["natural"] and names_of("films") == list(SUITES["films"])


def test_help_names_every_bench_of_a_suite_of_several_and_no_other() -> None:
    """Catches: a bench that is gone, or a new one, in the list that people choose from."""
    said = CliRunner().invoke(moireid, ["lab", "bench", "--help"]).stdout.partition("SUITE may also")[0]
    lines = re.findall(r"^  (\w+) {3,}(.*(?:\n {8,}.*)*)", said, re.MULTILINE)
    assert [suite for suite, _ in lines] == list(SUITES)
    for suite, text in lines:
        named = " ".join(text.split()).rpartition(":")[2].split(", ")
        assert [name.strip() for name in named] == list(SUITES[suite]) or len(SUITES[suite]) == 1


def test_a_bench_prints_its_table_and_writes_its_rows(tmp_path: Path) -> None:
    """Catches: rows that are not written; a run that overwrites another; an unknown option taken."""
    command = ["lab", "bench", "priors", "--out", str(tmp_path)]
    done = CliRunner().invoke(moireid, command)
    assert done.exit_code == 0 and "Cllr" in done.stdout
    assert sorted(path.name for path in tmp_path.iterdir()) == ["priors.json", "priors.jsonl", "priors.svg"]
    again, none = (CliRunner().invoke(moireid, [*command, *more]) for more in ([], ["--never", "1"]))
    assert again.exit_code == none.exit_code == 2 and "--overwrite" in again.stderr


def test_no_two_attacks_have_one_name_and_all_fit_the_table() -> None:
    """Catches: films of two cases counted as one; a name that runs into the figures."""
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names) and max(map(len, names)) < 58


def test_figures_are_drawn_against_each_other_and_outcomes_counted() -> None:
    """Catches: two series in one line; a row without a figure drawn at 0; an outcome counted twice."""
    rows = [{"x": 1.0, "y": 2.0, "of": "a"}, {"x": 2.0, "y": 4.0, "of": "b"}, {"x": 3.0, "y": None, "of": "a"}]
    (axes,) = plot_of(rows, ("x", "y", "of")).axes
    assert {line.get_label(): list(line.get_xdata()) for line in axes.lines} == {"a": [1.0], "b": [2.0]}
    counted = [{"question": "q", "kind": "k", "right": 2, "inconclusive": 1, "wrong": 0}]
    (axes,) = plot_of(counted, ()).axes
    assert [bar.get_width() for bar in axes.patches] == [2, 1, 0]
