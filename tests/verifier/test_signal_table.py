"""The signals of a film as arrays, text and data frame."""

from __future__ import annotations

import builtins
import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from kit.places import FILMS
from moireid.badge import load_badge
from moireid.errors import MissingExtraError, SpecError
from moireid.verifier import Question, Report, verify
from moireid.verifier.report.phase_figure import phase_figure
from moireid.verifier.signal_table import SignalTable


@pytest.fixture(scope="module")
def report() -> Report:
    return verify(FILMS / "genuine_1.0m.mp4", Question(load_badge(FILMS / "badge.json")))


def test_the_columns_are_the_measurement_s(report: Report) -> None:
    """Catches: columns of another frame, grating or sign than those that were judged."""
    signals, found = report.signals(), report.measurement
    assert found is not None
    assert {len(column) for column in signals.values()} == {len(found.times_s)}
    assert np.array_equal(signals["camera_z_mm"], found.camera_mm[:, 2])
    assert np.array_equal(signals["predicted_rad_0"], found.gratings[0].predicted_rad)
    x0, _, x1, _ = report.badge.outline_mm
    u = (signals["camera_x_mm"] - (x0 + x1) / 2) / np.abs(signals["camera_z_mm"])
    assert np.allclose(signals["parallax_x"], u)
    assert np.corrcoef(signals["measured_rad_0"], signals["predicted_rad_0"])[0, 1] > 0.99


def test_csv_and_table_are_the_same(report: Report) -> None:
    """Catches: a column that is lost or moved; frames that become fractions."""
    signals = report.signals()
    read = SignalTable.from_csv(signals.to_csv())
    assert list(read) == list(signals)
    assert read["frame"].dtype == np.int64
    for name, column in signals.items():
        assert np.allclose(read[name], column, rtol=1e-5, atol=1e-9), name
    assert read.to_csv() == signals.to_csv()


def test_what_was_not_measured_has_columns_and_no_rows() -> None:
    """Catches: an error for a film without a badge, in place of the header alone."""
    report = verify(FILMS / "genuine_1.0m.mp4", Question(load_badge(FILMS / "badge_mask.json")))
    if report.measurement is None:
        signals = report.signals()
        assert "predicted_rad_0" in signals and {len(column) for column in signals.values()} == {0}
        assert SignalTable.from_csv(signals.to_csv()).keys() == signals.keys()
        with pytest.raises(SpecError, match="nothing could be measured"):
            phase_figure(report.signals())
    empty = SignalTable.of({"predicted_rad_0": np.empty(0)})
    assert len(SignalTable.from_csv(empty.to_csv())["frame"]) == 0
    with pytest.raises(SpecError, match="nothing could be measured"):
        empty.most_moved()


def test_the_plot_shows_what_was_measured(report: Report) -> None:
    """Catches: axes exchanged, unreadable frames drawn, and a grating that is not there."""
    signals = SignalTable(report.signals())
    signals["phase_sd_rad_0"] = signals["phase_sd_rad_0"].copy()
    signals["phase_sd_rad_0"][10:20] = np.inf
    time, slope = phase_figure(signals).axes
    law, seen = time.lines
    assert np.allclose(law.get_ydata(), signals["predicted_rad_0"], equal_nan=True)
    assert np.flatnonzero(np.isnan(seen.get_ydata())).tolist() == list(range(10, 20))
    assert np.array_equal(slope.lines[1].get_xdata(), signals["predicted_rad_0"])
    with pytest.raises(SpecError, match="grating 7 is not on this badge"):
        phase_figure(signals, 7)


def test_a_data_frame_needs_pandas(report: Report, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: pandas loaded, or asked for, where no data frame is; a traceback where it is absent."""
    loading = builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> ModuleType:
        if name == "pandas":
            raise ImportError(name)
        return loading(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtraError, match="pip install pandas"):
        report.signals().to_frame()
    monkeypatch.setattr(builtins, "__import__", loading)
    fake = ModuleType("pandas")
    fake.DataFrame = dict  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "pandas", fake)
    assert report.signals().to_frame().keys() == report.signals().keys()
