"""The verifier's bench: its arithmetic on figures made up.  Each test states what it catches."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.verifier import Question, Verifier
from moireid.verifier.picture import Frame
from moireid.verifier.video import Film
from moireid_lab.bench.bench_frame import table_text
from moireid_lab.bench.verify import verify_suite as verify
from moireid_lab.bench.verify.films import KINDS, DecodedFilm, FilmTruth, Kind, phase_error_rad


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


def test_a_setting_leaves_out_and_shrinks_frames_as_a_film_of_them_would_have_them():
    """Catches: numbers with gaps, which stop the page from being followed; pictures shifted by half a pixel."""
    ramp = np.add.outer(np.zeros(60), np.arange(80)).astype(np.uint8) * 2
    frames = [Frame(k, k / 30, ramp) for k in range(8)]
    used = list(verify.used_frames(frames, (3, 1 / 2)))
    assert [frame.index for frame in used] == [0, 1, 2] and [frame.time_s for frame in used] == [0, 0.1, 0.2]
    assert used[0].luma.shape == (30, 40)
    # The middle of the picture stays the middle: a pixel of the half size is the mean of its four.
    assert used[0].luma.mean() == pytest.approx(ramp.mean(), abs=0.6) and used[0].luma[0, 0] == 1
    whole = list(verify.used_frames(frames, verify.DEFAULT))
    assert [(frame.index, frame.time_s, frame.picture) for frame in whole] == [
        (frame.index, frame.time_s, frame.picture) for frame in frames
    ]


def test_the_knee_is_the_least_error_times_time_of_what_is_right_on_all_films():
    """Catches: a knee at a setting that accepts a forgery, or by the time of one run alone."""
    made = {(1, 1.0): (0.010, 8.0, True), (2, 1.0): (0.011, 4.0, True), (4, 1.0): (0.012, 2.0, False)}
    films = [
        {"film": kind.name, "forge": kind.forge, "every": every, "scale": scale, "phase_rad": phase, "pose_rad": phase}
        | {"gain_error": -phase, "right": right or kind.forge is None, "cpu_ms": [ms, ms, 9 * ms]}
        for kind in KINDS
        for (every, scale), (phase, ms, right) in made.items()
    ]
    rows = list(verify.table(films))
    assert [row["cpu_ms"] for row in rows] == [8.0, 4.0, 2.0] and rows[0]["gain_error"] == pytest.approx(0.010)
    assert "the knee is at every 2. frame, full size: 0.0156 rad in 4.00 CPU ms" in table_text(verify.BENCH, films)
    assert list(verify.knee([film | {"right": False} for film in films])) == ["no setting judges all films right"]


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
