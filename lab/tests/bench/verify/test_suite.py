"""The verifier's bench: its arithmetic on figures made up.  Each test states what it catches."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.verifier import Question, Verifier
from moireid.verifier.video import Film
from moireid_lab.bench.verify import verify_suite as verify
from moireid_lab.bench.verify.films import DecodedFilm, FilmTruth, Kind, phase_error_rad


def test_the_phase_error_counts_what_lies_between_the_frames_used():
    """Catches: an error over the frames used alone, which would call leaving frames out free; an offset that counts."""
    clock = np.arange(0, 4, 1 / 30)
    true = np.sin(2 * math.pi * clock)
    assert phase_error_rad(clock, true + 0.7, clock, true) == pytest.approx(0, abs=1e-12)
    # A straight line over a step h misses a sine by up to (w h)^2 / 8; the mean square of arch times sine is 4 / 15.
    coarse = phase_error_rad(clock[::4], true[::4], clock, true)
    assert coarse == pytest.approx((2 * math.pi * 4 / 30) ** 2 / 8 * math.sqrt(4 / 15), rel=0.15)
    assert phase_error_rad(clock[:1], true[:1], clock, true) is None
    assert phase_error_rad(clock[:0], true[:0], clock, true) is None


@pytest.mark.slow
def test_the_bench_measures_the_verifier_on_a_film_made_outside(films, prototype):
    """Catches: signs of phase or gain turned, other estimators than were asked for."""
    frames = list(Film(films / "genuine_1.0m.mp4").frames())[:90]
    times = np.array([frame.time_s for frame in frames])
    verifier = Verifier(Question(prototype), running=False)
    for frame in frames:
        verifier.push(frame)
    signal = verifier.finish()[0].measurement.gratings[0]
    filmed = DecodedFilm(Kind("", 1.0), prototype, frames, FilmTruth(times, signal.measured_rad, signal.predicted_rad))
    plain = verify.timed(filmed, verify.DEFAULT, 1)
    assert plain["right"] and plain["verdict"] == "accept"
    assert plain["phase_rad"] == pytest.approx(0, abs=1e-9) and plain["pose_rad"] == pytest.approx(0, abs=1e-9)
    assert abs(plain["gain_error"]) < 0.02 and len(plain["cpu_ms"]) == 1
