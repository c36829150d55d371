"""The signals of a film as arrays, text and data frame."""

from __future__ import annotations

import numpy as np
import pytest

from kit.places import FILMS
from moireid.badge import load_badge
from moireid.verifier import Question, Report, verify
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
