"""Forgeries: everything true but the place from which the fringes think they are seen.

A forged film shows the lens as a camera elsewhere would see it, while page, markers and motion stay true.  Each kind
is a false course of the parallax tangent at the badge's centre, with the true one's spread where it has a spread, so
that no forgery gives itself away by its size.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError

Array = NDArray[np.float64]
KINDS = ("frozen", "drift", "randomwalk", "late", "gain_low", "gain_high", "reversed")
LATE_S = 0.25
GAIN_LOW, GAIN_HIGH = 0.5, 1.9
#: A random walk that forgets within this time wanders about as fast as a hand does.
MEMORY_S = 0.8


def false_camera(kind: str, camera_mm: Array, fps: float, seed: int) -> Array:
    """Camera centres (T, 3) from which the fringes are shown, board frame.

    Parameters: camera_mm (T, 3): the true centres; fps: of the film; seed: of the random walk.
    Convention: the tangents Cx/|Cz| and Cy/|Cz| are forged, the distance stays true.
    Raises: SpecError for a kind that is none.
    Source: the kinds of the project's contract: a wrong law of motion each.
    """
    if kind not in KINDS:
        raise SpecError(f"forgery {kind!r} is not known; choose one of {', '.join(KINDS)}")
    distance = np.abs(camera_mm[:, 2:])
    true = camera_mm[:, :2] / distance
    mean, spread = true.mean(axis=0), true.std(axis=0)
    ramp = np.linspace(-1, 1, len(true))[:, None] * np.sqrt(3.0)
    if kind == "frozen":
        shown = np.broadcast_to(true[0], true.shape)
    elif kind == "drift":
        shown = mean + spread * ramp
    elif kind == "randomwalk":
        shown = mean + spread * _random_walk(len(true), fps, seed)
    elif kind == "late":
        delay = max(1, round(LATE_S * fps))
        shown = true[np.maximum(np.arange(len(true)) - delay, 0)]
    else:
        gain = {"gain_low": GAIN_LOW, "gain_high": GAIN_HIGH, "reversed": -1.0}[kind]
        shown = mean + gain * (true - mean)
    return np.column_stack([shown * distance, camera_mm[:, 2]])


def _random_walk(count: int, fps: float, seed: int) -> Array:
    """Two smooth random courses (T, 2), mean 0 and standard deviation 1 over the film."""
    from scipy.ndimage import gaussian_filter1d

    steps = np.random.default_rng(seed).standard_normal((count, 2))
    keep = np.exp(-1.0 / (MEMORY_S * fps))
    course = np.zeros_like(steps)
    for frame in range(1, count):
        course[frame] = keep * course[frame - 1] + steps[frame]
    course = gaussian_filter1d(course, 0.1 * fps, axis=0)
    course = course - course.mean(axis=0)
    return np.asarray(course / np.maximum(course.std(axis=0), 1e-12))
