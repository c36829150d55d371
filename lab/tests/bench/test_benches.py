"""Tables and plots of the benches, on films made up.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import importlib
import math
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid_lab.bench.bench_frame import Bench, table_text
from moireid_lab.bench.bench_plots import plot_of
from moireid_lab.bench.forgers import forgers_suite as forgers
from moireid_lab.bench.forgers.cases import cases
from moireid_lab.bench.reality import BENCH as REALITY
from moireid_lab.bench.reality import gain_error, residual
from moireid_lab.bench.suites import BENCHES, SUITES, module_of, names_of


def test_every_bench_can_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a module that was moved; a bench in two suites; a suite of which one bench alone cannot be asked."""
    monkeypatch.setattr("sys.path", list(__import__("sys").path))
    monkeypatch.setenv("PYTHONPATH", "")
    assert sum(map(len, SUITES.values())) == len(BENCHES)
    for name in BENCHES:
        assert isinstance(importlib.import_module(module_of(name)).BENCH, Bench), name
    assert names_of("natural") == ["natural"] and names_of("films") == list(SUITES["films"])


def test_a_bench_prints_its_table_and_writes_its_rows(tmp_path: Path) -> None:
    """Catches: an option of its own that does not reach it; a run that overwrites another; an unknown option taken."""
    command = ["lab", "bench", "priors", "--out", str(tmp_path)]
    done = CliRunner().invoke(moireid, command)
    assert done.exit_code == 0 and "Cllr on the other half" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["priors.json"]
    again, none = (CliRunner().invoke(moireid, [*command, *more]) for more in ([], ["--table", "none.csv"]))
    assert again.exit_code == none.exit_code == 2 and "--overwrite" in again.stderr
    other = CliRunner().invoke(moireid, ["bench", "priors", "--never", "1"])
    assert other.exit_code == 2 and "options of its own: --table" in other.stderr


def attack(case: str, verdict: str, *why: str, genuine: bool = False, seconds: float = 2.0) -> dict[str, Any]:
    return {"case": case, "genuine": genuine, "seed": 0, "verdict": verdict, "why": list(why), "seconds": seconds}


ATTACKS = [
    attack("8 photographs", "inconclusive", "spacing", "late"),
    attack("8 photographs", "inconclusive", "spacing", seconds=3.0),
    attack("8 photographs", "accept", seconds=4.0),
    attack("frozen", "reject", "gain"),
    attack("a hand", "inconclusive", "covered", genuine=True),
]


def test_verdicts_are_counted_for_each_case_under_its_heading() -> None:
    """Catches: inconclusive films among the rejected, a genuine case under the forgeries, bars that overlap."""
    lines = table_text(forgers.BENCH, ATTACKS).splitlines()
    cells = {line[:58].strip(): line[58:].split() for line in lines}
    assert cells["8 photographs"] == ["1", "2", "0", "3.0", "spacing"]
    assert cells["frozen"] == ["0", "0", "1", "2.0", "gain"] and cells["a hand"] == ["0", "1", "0", "2.0", "covered"]
    (axes,) = plot_of(list(forgers.BENCH.table(ATTACKS)), list(forgers.BENCH.columns), ()).axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    bars = {bars.get_label(): dict(zip(names, bars, strict=True)) for bars in axes.containers}
    assert bars["inconclusive"]["8 photographs, spacing"].get_x() == 1
    assert bars["reject"]["frozen, gain"].get_width() == 1


def test_no_two_attacks_have_one_name_and_all_fit_the_table() -> None:
    """Catches: films of two cases counted as one; a name that runs into the figures."""
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names) and max(map(len, names)) < 58


def changed(effect: str, verdict: str, *why: str, gain: float | None = 1.0, **more: Any) -> dict[str, Any]:
    usual = {"strength": "ordinary", "distance_m": 1.0, "badge": "true", "residual_rad": 0.02, "seconds": 2.0}
    return {"effect": effect, "verdict": verdict, "why": list(why), "gain": gain} | usual | more


def test_true_and_forged_films_of_an_effect_are_apart() -> None:
    """Catches: forged films among the true ones; strengths thrown together; a film without a gain counted as 0."""
    rows = [
        changed("zoom", "reject", "gain", "spacing", gain=0.8),
        changed("zoom", "accept", gain=1.0, seconds=4.0),
        changed("zoom", "inconclusive", "motion", gain=None, residual_rad=None, strength="light"),
        changed("zoom", "reject", "gain", badge="gain_low", gain=0.5),
        changed("none", "accept"),
    ]
    assert gain_error(rows[:1]) == pytest.approx(0.2) and math.isnan(gain_error(rows[2:3]))
    assert residual(rows) == 0.02 and math.isnan(residual(rows[2:3]))
    lines = table_text(REALITY, rows).splitlines()
    assert lines[1].split()[:3] == ["none", "1", "m"]
    ordinary = [line.split()[4:] for line in lines if line.startswith("zoom ordinary")]
    assert ordinary[0] == ["1", "0", "1", "0.141", "0.020", "3.0", "gain,", "spacing"]
    assert ordinary[1][:3] == ["0", "0", "1"]
    assert lines[-2] == "true films at ordinary strength: 2 (accept 1, inconclusive 0, reject 1)"


def test_figures_are_drawn_against_each_other_and_outcomes_counted() -> None:
    """Catches: two series in one line; a row without a figure drawn at 0; an outcome counted twice."""
    rows = [{"x": 1.0, "y": 2.0, "of": "a"}, {"x": 2.0, "y": 4.0, "of": "b"}, {"x": 3.0, "y": None, "of": "a"}]
    (axes,) = plot_of(rows, ["x"], ("x", "y", "of")).axes
    assert {line.get_label(): list(line.get_xdata()) for line in axes.lines} == {"a": [1.0], "b": [2.0]}
    (axes,) = plot_of(rows, ["x"], ("of",)).axes
    assert [bar.get_width() for bar in axes.patches] == [2, 1]
