"""Which of the camera's frames the file shows, and when.  Each test names what it would catch."""

from __future__ import annotations

import csv
from pathlib import Path

import av
import numpy as np
import pytest

from moireid.simulate.effects.effect import Timing, timing_of
from moireid.simulate.effects.table import KINDS, STRENGTHS, effect_named
from moireid.simulate.filming import film, truth_path
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene

FRAMES, FPS = 300, 30.0


def timing(*names: str) -> Timing:
    return timing_of([effect_named(name) for name in names], FRAMES, FPS, seed=4)


def times(name: str) -> np.ndarray:
    """The mean time that each frame of the file shows, s."""
    made = timing(name)
    return np.array([sum(number * weight for number, weight in part) for part in made.parts]) / made.fps


@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind.make(kind.figures[0]).times])
@pytest.mark.parametrize("strength", STRENGTHS)
def test_times_never_run_backwards_and_weights_add_to_one(name, strength):
    """Catches: a number below 0; a film that is too short; weights that darken a frame."""
    made = timing(f"{name}:{strength}")
    assert len(made.parts) == FRAMES
    assert all(abs(sum(weight for _, weight in part) - 1) < 1e-5 for part in made.parts)
    last = np.array([part[-1][0] for part in made.parts])
    assert last.min() >= 0 and np.all(np.diff(last) >= 0) and made.count == last[-1] + 1


def test_blending_keeps_the_told_times_and_repeating_lags():
    """Catches: neighbours' weights exchanged; 24 frames a second played as 30; every frame repeated."""
    output = np.arange(FRAMES) / FPS
    assert times("blend") == pytest.approx(output)
    made = timing("blend")
    assert made.fps == pytest.approx(24)
    assert np.array(made.parts[1]) == pytest.approx(np.array([[0, 0.2], [1, 0.8]]))
    lag = output - times("repeat")
    assert lag.min() == pytest.approx(0) and lag.max() == pytest.approx(4 / 5 / 24)
    shown = np.array([part[0][0] for part in timing("repeat").parts])
    assert np.count_nonzero(np.diff(shown) == 0) == pytest.approx(FRAMES / 5, abs=1)


def test_a_film_shows_its_mixed_and_repeated_frames_and_the_truth_tells_them(prototype, tmp_path: Path):
    """Catches: frames rendered twice, whose noise differs; a mix of wrong frames; truth of frames not shown."""
    scene = Scene(prototype, Build(), Camera(480, 272, 363.0, noise_counts=3.0, exposure_drift=0.0))
    motion = motion_named("linear", distance_mm=600.0, seed=2)
    films = {}
    for name, fps, effects in (("plain", 24.0, []), ("blend", 30.0, ["blend"]), ("repeat", 30.0, ["repeat"])):
        path = tmp_path / f"{name}.mp4"
        film(scene, motion, path, frames=8, fps=fps, seed=1, crf=1, effects=[effect_named(one) for one in effects])
        with av.open(str(path)) as container:
            films[name] = np.stack([frame.to_ndarray(format="gray") for frame in container.decode(video=0)]).astype(int)
    plain = films["plain"]
    mixed = 0.2 * plain[0] + 0.8 * plain[1]
    assert np.abs(films["blend"][1] - mixed).mean() < 1.0 < np.abs(films["blend"][1] - plain[1]).mean()
    assert np.abs(films["repeat"][1] - plain[0]).mean() < 1.0 and np.abs(films["repeat"][6] - plain[4]).mean() < 1.0
    with truth_path(tmp_path / "repeat.mp4").open(encoding="utf-8") as stream:
        truth = list(csv.DictReader(stream))
    assert [float(row["time_s"]) for row in truth] == pytest.approx(np.arange(8) / 30, abs=1e-6)
    shown = motion(np.floor(np.arange(8) * 0.8 + 1e-9) / 24).camera_mm[:, 0]
    assert [float(row["camera_x_mm"]) for row in truth] == pytest.approx(shown, abs=1e-4)
