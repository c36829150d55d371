"""Table and plot of films made up.  Each test states what it would catch."""

from __future__ import annotations

import math
from typing import Any

import pytest

from moireid_lab.bench.reality import gain_error, residual
from moireid_lab.bench.suites import SUITES


def row(effect: str, verdict: str, *why: str, gain: float | None = 1.0, **more: Any) -> dict[str, Any]:
    usual = {"strength": "ordinary", "distance_m": 1.0, "badge": "true", "residual_rad": 0.02, "seconds": 2.0}
    return {"effect": effect, "verdict": verdict, "why": list(why), "gain": gain} | usual | more


@pytest.fixture
def result() -> dict[str, Any]:
    rows = [
        row("zoom", "reject", "gain", "spacing", gain=0.8),
        row("zoom", "accept", gain=1.0, seconds=4.0),
        row("zoom", "inconclusive", "spacing", strength="strong", distance_m=2.0),
        row("zoom", "inconclusive", "motion", gain=None, residual_rad=None, strength="light"),
        row("zoom", "reject", "gain", badge="gain_low", gain=0.5),
        row("zoom", "accept", badge="wobble"),
        row("none", "accept"),
    ]
    return {"suite": "reality", "rows": rows}


def test_errors_are_those_of_the_films_that_have_a_gain():
    """Catches: a mean of gains in place of their error; a film without a gain counted as 0."""
    films = [row("zoom", "accept", gain=value) for value in (0.9, 1.1, None)]
    assert gain_error(films) == pytest.approx(0.1) and math.isnan(gain_error(films[2:]))
    shown = [row("zoom", "accept", residual_rad=value) for value in (0.01, 0.02, 0.9, None)]
    assert residual(shown) == 0.02 and math.isnan(residual(shown[3:]))


def test_the_table_separates_true_and_forged_films(result):
    """Catches: forged films among the true ones; strengths or distances thrown together; the first row elsewhere."""
    lines = SUITES["reality"].table(result).splitlines()
    assert lines[0].startswith("true badge") and lines[1].split()[:3] == ["none", "1", "m"]
    cells = {tuple(line.split()[:3]): line.split()[4:] for line in lines if line.startswith("zoom")}
    assert cells["zoom", "light", "1"] == ["0", "1", "0", "nan", "nan", "2.0", "motion"]
    assert cells["zoom", "strong", "2"] == ["0", "1", "0", "0.000", "0.020", "2.0", "spacing"]
    ordinary = [line.split()[4:] for line in lines if line.startswith("zoom ordinary")]
    assert ordinary[0] == ["1", "0", "1", "0.141", "0.020", "3.0", "gain,", "spacing"]
    assert ordinary[1][:3] == ["1", "0", "1"]
    # Films without an effect, and those of other strengths, are not in the sum.
    assert lines[-2] == "true films at ordinary strength: 2 (accept 1, inconclusive 0, reject 1)"
    assert lines[-1] == "forged films at ordinary strength: 2 (accept 1, inconclusive 0, reject 1)"


def test_the_plot_has_three_bars_for_each_effect_of_the_true_films(result):
    """Catches: bars that are not of one; strengths in one place; forged films drawn as true ones."""
    shares, errors, residuals, seconds = SUITES["reality"].plot(result).axes
    assert [label.get_text() for label in shares.get_yticklabels()] == ["none", "zoom"]
    widths: dict[float, float] = {}
    for bar in shares.patches:
        place = bar.get_y() + bar.get_height() / 2
        widths[round(place, 2)] = widths.get(round(place, 2), 0.0) + bar.get_width()
    assert widths == pytest.approx({-0.27: 0, 0.0: 1, 0.27: 0, 0.73: 1, 1.0: 1, 1.27: 1})
    ordinary = {line.get_label(): line.get_xdata() for line in errors.lines}["ordinary"]
    assert ordinary == pytest.approx([0, 0.2 / math.sqrt(2)])
    assert residuals.get_xlabel() == "residual, rad" and seconds.get_xlabel() == "verify, s a film"


def test_true_films_alone_are_reported_too(result):
    """Catches: a crash on a quick run."""
    part = {"rows": [one for one in result["rows"] if one["badge"] == "true" and one["effect"] == "zoom"]}
    assert "forged" not in SUITES["reality"].table(part) and SUITES["reality"].plot(part)
