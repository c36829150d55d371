"""The verifier's bench: its arithmetic on figures made up, and some extreme motions.  Each states what it catches."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from moireid.verifier import Question, Verifier
from moireid.verifier.picture import Frame
from moireid.verifier.video import Film
from moireid_lab.bench.bench_frame import table_text
from moireid_lab.bench.verify import verify_suite as verify
from moireid_lab.bench.verify.films import KINDS, DecodedFilm, FilmTruth, Kind, phase_error_rad
from moireid_lab.bench.verify.motion_extremes import cases, outcome_of, read_extreme


def row_of(kind: Kind, setting: verify.EstimatorSetting, *, phase: float, cpu_ms: float, right: bool = True) -> dict:
    return {
        "film": kind.name,
        "forge": kind.forge,
        "setting": verify.asdict(setting),
        "phase_rad": phase,
        "right": right,
        "pose_rad": phase,
        "gain_error": -phase,
        "verdict": "accept" if right == (kind.forge is None) else "reject",
        "ms": [9.0, 10.0, 30.0],
        "cpu_ms": [cpu_ms] * 3,
        "decode_ms": 5.0,
        "decode_cpu_ms": 2.0,
    }


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
    used = list(verify.used_frames(frames, verify.EstimatorSetting(3, 1 / 2)))
    assert [frame.index for frame in used] == [0, 1, 2] and [frame.time_s for frame in used] == [0, 0.1, 0.2]
    assert used[0].luma.shape == (30, 40)
    # The middle of the picture stays the middle: a pixel of the half size is the mean of its four.
    assert used[0].luma.mean() == pytest.approx(ramp.mean(), abs=0.6) and used[0].luma[0, 0] == 1
    whole = list(verify.used_frames(frames, verify.DEFAULT))
    assert [(frame.index, frame.time_s, frame.picture) for frame in whole] == [
        (frame.index, frame.time_s, frame.picture) for frame in frames
    ]


def test_the_knee_is_the_least_error_times_time_of_what_is_right_on_all_films():
    """Catches: a knee at a setting that accepts a forgery, at another estimator, or by the time of one run alone."""
    made = {
        verify.DEFAULT: (0.010, 8.0, True),
        verify.EstimatorSetting(2): (0.011, 4.0, True),
        verify.EstimatorSetting(4): (0.012, 2.0, False),
        verify.EstimatorSetting(estimator="published"): (0.001, 0.1, True),
    }
    films = [
        row_of(kind, setting, phase=phase, cpu_ms=ms, right=right or kind.forge is None)
        for kind in KINDS
        for setting, (phase, ms, right) in made.items()
    ]
    work = [verify._summary(setting, films) for setting in made]
    knee = verify.knee_of(work)
    assert knee is not None and knee["setting"] == verify.asdict(verify.EstimatorSetting(2)) and not knee["default"]
    assert work[2]["accepted_forged"] == sum(kind.forge is not None for kind in KINDS) and work[2]["rejected_true"] == 0
    assert work[0]["ms"] == 10.0 and work[0]["ms_to_decoding"] == 2.0 and work[0]["cpu_ms_to_decoding"] == 4.0
    assert work[0]["gain_error"] == pytest.approx(0.010)
    assert "the knee is at every 2nd frame: 0.0156 rad in 4.00 CPU ms" in table_text(verify.BENCH, films)
    assert len(verify.plot(films).axes) == 3
    assert verify.knee_of([row | {"right": 0} for row in work]) is None


@pytest.mark.slow
def test_the_bench_measures_the_verifier_on_a_film_made_outside(films, prototype):
    """Catches: signs of phase or gain turned, other estimators than were asked for."""
    frames = list(Film(films / "genuine_1.0m.mp4").frames())[:90]
    times = np.array([frame.time_s for frame in frames])
    verifier = Verifier(Question(prototype), running=False)
    for frame in frames:
        verifier.push(frame)
    signal = verifier.finish()[0].measurement.gratings[0]
    filmed = DecodedFilm(
        Kind("", 1.0), prototype, 1450.0, frames, FilmTruth(times, signal.measured_rad, signal.predicted_rad), 1, 1
    )
    plain = verify.timed(filmed, verify.DEFAULT, 1)
    assert plain["right"] and plain["verdict"] == "accept"
    assert plain["phase_rad"] == pytest.approx(0, abs=1e-9) and plain["pose_rad"] == pytest.approx(0, abs=1e-9)
    assert abs(plain["gain_error"]) < 0.02 and len(plain["ms"]) == 1
    published = verify.timed(filmed, verify.EstimatorSetting(estimator="published"), 1)
    assert published["pose_rad"] is None and 0 < published["phase_rad"] < 1.0 and published["tracked"] == 90


@pytest.mark.parametrize(
    ("expected", "verdict", "codes", "outcome"),
    [
        ("accept", "accept", [], "right"),
        ("accept", "inconclusive", ["gain"], "inconclusive"),
        ("accept", "reject", ["gain"], "wrong"),
        ("motion", "inconclusive", ["motion", "identity"], "right"),
        ("motion", "inconclusive", ["identity"], "inconclusive"),
        ("motion", "accept", [], "wrong"),
        ("motion", "reject", ["motion", "cells"], "wrong"),
        ("accept or inconclusive", "inconclusive", ["gain"], "right"),
        ("accept or inconclusive", "reject", ["correlation"], "wrong"),
    ],
)
def test_a_true_film_that_is_rejected_is_wrong_and_one_inconclusive_a_shortfall(expected, verdict, codes, outcome):
    """Catches: a rejection excused, an acceptance without motion called right, any reason taken for the right one."""
    assert outcome_of(expected, verdict, codes) == outcome


@pytest.mark.parametrize(
    "name",
    [
        "two frames",
        pytest.param("turned in the picture's plane", marks=pytest.mark.slow),
        pytest.param("first frame smeared", marks=pytest.mark.slow),
    ],
)
def test_extreme_motions_come_out_as_physics_expects(name):
    """Catches: a true film rejected or accepted for nothing, a figure that is not finite, a row JSON cannot hold."""
    (case,) = [case for case in cases() if case.name == name]
    # With seed 0 the smeared film ends at 6.1 times likelier, where 6.2 is needed: a film's ends are its weakest part.
    row = read_extreme((case.name, 1))
    assert row["outcome"] == "right" and json.dumps(row, allow_nan=False)
    assert name in table_text(verify.BENCH, [row])
