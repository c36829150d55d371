"""Forgeries by a false law of motion: only the fringes are false; they are those of a camera at another place.

A forged film shows the lens as a camera elsewhere would see it, while page, markers and motion stay true.  Each
trajectory is a false parallax coordinate at the badge's centre over time.  It has the mean of the true one, and its
spread if it moves at all, so that no forgery is found by its size alone.  Within one frame, from its first row to its
last, the fringes move with the true camera, by less than 0.01 rad over the badge.

`rear_layer.py` holds the kinds that need more than one trajectory, and what a film of any kind shows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.simulate.motion import measured_run

Array = NDArray[np.float64]
#: Kinds that are one false trajectory for the whole badge.
TRAJECTORIES = ("frozen", "drift", "randomwalk", "late", "gain_low", "gain_high", "reversed", "splice", "wobble")
#: Kinds whose parts follow trajectories of their own.
FIELDS = ("patchy", "generative")
#: Kinds that are a flat picture.
FLAT = ("photo", "screen")
KINDS = TRAJECTORIES + FIELDS + FLAT
LATE_S = 0.25
GAIN_LOW, GAIN_HIGH = 0.5, 1.9
#: Correlation time of the random walk: with it the walk moves about as fast as a hand.
MEMORY_S = 0.8
#: The wander on top of the right gain, as a share of the true spread.
WOBBLE = 0.3


def false_camera(kind: str, camera_mm: Array, fps: float, seed: int) -> Array:
    """Camera centres (T, 3) from which the fringes are shown, board frame.

    Parameters: kind: one of `TRAJECTORIES`; camera_mm (T, 3): the true centres; fps: of the film; seed: of chance.
    Convention: the parallax coordinates Cx/|Cz| and Cy/|Cz| are forged, the distance stays true.
    Raises: SpecError for an unknown kind.
    Source: each kind is one wrong law of motion.
    """
    if kind not in TRAJECTORIES:
        raise SpecError(f"forgery {kind!r} is no false trajectory; choose one of {', '.join(TRAJECTORIES)}")
    distance = np.abs(camera_mm[:, 2:])
    true = camera_mm[:, :2] / distance
    mean, spread = true.mean(axis=0), true.std(axis=0)
    if kind == "frozen":
        shown = np.broadcast_to(true[0], true.shape)
    elif kind == "drift":
        shown = mean + spread * np.linspace(-1, 1, len(true))[:, None] * np.sqrt(3.0)
    elif kind == "randomwalk":
        shown = mean + spread * random_walk(len(true), fps, seed)
    elif kind == "splice":
        shown = mean + spread * _of_unit_spread(_other_film(len(true), fps, seed))
    elif kind == "wobble":
        shown = true + WOBBLE * spread * _apart_from(true, random_walk(len(true), fps, seed))
    elif kind == "late":
        delay = max(1, round(LATE_S * fps))
        shown = true[np.maximum(np.arange(len(true)) - delay, 0)]
    else:
        gain = {"gain_low": GAIN_LOW, "gain_high": GAIN_HIGH, "reversed": -1.0}[kind]
        shown = mean + gain * (true - mean)
    return np.column_stack([shown * distance, camera_mm[:, 2]])


def random_walk(count: int, fps: float, seed: int) -> Array:
    """Two smooth random walks (T, 2), mean 0 and standard deviation 1 over the film."""
    from scipy.ndimage import gaussian_filter1d

    steps = np.random.default_rng(seed).standard_normal((count, 2))
    keep = np.exp(-1.0 / (MEMORY_S * fps))
    path = np.zeros_like(steps)
    for frame in range(1, count):
        path[frame] = keep * path[frame - 1] + steps[frame]
    return _of_unit_spread(gaussian_filter1d(path, 0.1 * fps, axis=0))


def _other_film(count: int, fps: float, seed: int) -> Array:
    """Parallax coordinates (T, 2) of another true film: the measured run, from a second that the seed draws.

    It begins 7 to 20 s into the run, so it is another piece than a film that shows the run from its beginning.
    """
    begin = np.random.default_rng(seed).uniform(7.0, 20.0)
    camera = measured_run(1000.0)(begin + np.arange(count) / fps).camera_mm
    return np.asarray(camera[:, :2] / np.abs(camera[:, 2:]))


def _apart_from(true: Array, path: Array) -> Array:
    """The part of a path (T, 2) that is uncorrelated with the true one, for each axis, spread 1: the gain stays 1."""
    true = true - true.mean(axis=0)
    share = (true * path).sum(axis=0) / np.maximum((true**2).sum(axis=0), 1e-30)
    return _of_unit_spread(path - share * true)


def _of_unit_spread(path: Array) -> Array:
    """The path less its mean, in units of its standard deviation; zeros where it stays still."""
    path = path - path.mean(axis=0)
    return np.asarray(path / np.maximum(path.std(axis=0), 1e-12))
