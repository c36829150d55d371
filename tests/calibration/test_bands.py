"""Bands of a chart against the formula that made them.  Each test names the fault that it catches."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.badge import Badge
from moireid.calibration.bands import BandFit, read_bands
from moireid.calibration.chart_reading import ChartView
from moireid.designer.chart import design_chart

PHASE, CAMERAS = 0.3, ((90.0, 60.0, -600.0), (120.0, 80.0, -640.0))


@pytest.fixture(scope="module")
def chart() -> Badge:
    return design_chart()


def views_of(chart: Badge, lens_per_mm: float, noise: float, rng: np.random.Generator) -> list[ChartView]:
    """Pictures of a sheet that has this line frequency: fringes with a second harmonic, on light that falls off."""
    views = []
    for camera in CAMERAS:
        fit = BandFit([ChartView(np.array(camera), np.zeros((1, 1)))], chart)
        parts = len(fit.across_mm) // len(fit.printed)
        argument = np.concatenate(
            [fit.phase_rad(0, slice(k, k + parts), lens_per_mm) for k in range(0, len(fit.across_mm), parts)]
        )
        side = np.linspace(-1, 1, argument.shape[1])
        light = 120 + 8 * side - 5 * side**2 + 25 * np.cos(argument + PHASE) + 6 * np.cos(2 * argument + 1)
        views.append(ChartView(np.array(camera), light + noise * rng.standard_normal(light.shape)))
    return views


def test_readable_bands_show_the_lens_within_their_error_bars(chart, rng):
    """Catches: parts of another band, views that are mixed up, an error bar that forgets how many samples there are."""
    q = 1.0007 / chart.lens.pitch_mm
    readings = read_bands(views_of(chart, q, 3.0, rng), chart)
    usable = [reading for reading in readings if reading.readable]
    off = np.array([(reading.lens_per_mm - q) / reading.sd for reading in usable])
    assert len(usable) >= 12 and 0.2 < np.sqrt(np.mean(off**2)) < 1.6
    # Bands near the match show less than one and a half fringes, which shading could make too.
    assert all(abs(reading.fringes) < 2.5 for reading in readings if not reading.readable)
