"""Smoothing over the times of odd files.  Beside each test: what it catches."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.camera.smoothing import rising, smooth_camera

ERROR = (1e-3, 1e-3)
#: Each time is given twice.
PAIRS = np.repeat(np.arange(60) / 30, 2)


def course(rng) -> np.ndarray:
    """Camera centres, mm, of a hand that sways."""
    way = np.sin(2 * np.pi * 0.5 * PAIRS)
    return np.column_stack([100 * way, 20 * way, np.full(len(way), -1000.0)]) + rng.normal(0, 0.3, (len(way), 3))


@pytest.mark.parametrize("begin_s", [0.0, 1.7e9, 1e300])
def test_repeated_times_are_made_to_rise_whenever_a_film_begins(begin_s):
    """Catches: times from 1970 on, at which what makes them rise is lost, and a spline divides by nothing."""
    assert np.all(np.diff(rising(begin_s + PAIRS)) > 0)


def test_a_course_is_smoothed_alike_after_any_pause(rng):
    """Catches: places without a number, which ended in a traceback; times counted over a long pause."""
    camera = course(rng)
    usual = smooth_camera(camera, PAIRS, ERROR)
    assert smooth_camera(camera, 1.7e9 + PAIRS, ERROR) == pytest.approx(usual, abs=0.01)
    both = smooth_camera(np.vstack([camera, camera]), np.concatenate([PAIRS, 1e9 + PAIRS]), ERROR)
    assert both == pytest.approx(np.vstack([usual, usual]), abs=0.01)
