"""Forgeries on a film's own trajectory: each rival of the law, at its best.

Page and markers move truly; the lens region's picture is taken from the view of a rival.  `drift_fitted`: a view that
moves at the constant speed that fits the true one best.  `late_300ms`, `late_700ms`: the true view so much earlier.
`place_fitted`: a view that goes with the badge's place in the picture, as far as fits best.  `gain_0.5`, `gain_0.8`,
`gain_1.25`: parallax times that.  `wander`: true, and a smooth motion of 0.2 rad on it.  `spell_300ms`, `spell_600ms`:
true, but the fringes stay still for so long where they should move fastest.  `sheared`: as `gain_1.25`, and each frame,
markers and all, is sheared at random by 0.3 %, so that poses are uncertain and hide the gain.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from outside.forge import Lie
from outside.motion import Course

Array = NDArray[np.float64]
KINDS = (
    "drift_fitted", "late_300ms", "late_700ms", "place_fitted", "gain_0.5", "gain_0.8", "gain_1.25", "wander",
    "spell_300ms", "spell_600ms", "sheared",
)  # fmt: skip
#: Size of the wander as a tangent: 0.2 rad of phase over the 7.2 rad per unit of tangent that the board has.
WANDER, WANDER_HZ = 0.2 / 7.2, (0.2, 1.0)
#: Random shear of a frame, its standard deviation.
SHEAR = 0.003
#: Times at which a trajectory is looked at, per second.
STEPS_PER_S = 60


def rival_lie(kind: str, course: Course, seconds: float, rng: np.random.Generator) -> Lie:
    """The forgery of that kind about a course."""
    tangent = _tangent(kind, course, seconds, rng)

    def eye(t: Array) -> Array:
        place = course.views(np.maximum(t, 0.0))[0]
        place[:, 0] = -place[:, 2] * tangent(t)
        return place

    return Lie(eye, lambda t: np.zeros((0, 4)), np.zeros((1, 1), bool))


def _tangent(kind: str, course: Course, seconds: float, rng: np.random.Generator) -> Callable[[Array], Array]:
    """The tangent of the rival's view over time."""
    clock = np.arange(0.0, seconds + 0.5, 1 / STEPS_PER_S)
    places, turns = course.views(clock)
    true = -places[:, 0] / places[:, 2]
    path = CubicSpline(clock, true)
    of_time = lambda t: path(np.clip(t, 0.0, clock[-1]))  # noqa: E731
    name, _, figure = ("gain_1.25" if kind == "sheared" else kind).partition("_")
    if name == "drift":
        slope, start = np.polyfit(clock, true, 1)
        return lambda t: start + slope * t
    if name == "late":
        delay = float(figure.removesuffix("ms")) / 1000
        return lambda t: of_time(t - delay)
    if name == "place":
        middle = np.einsum("kji,kj->ki", turns, -places)
        table = np.column_stack([np.ones(len(clock)), middle[:, :2] / middle[:, 2:]])
        fitted = CubicSpline(clock, table @ np.linalg.lstsq(table, true, rcond=None)[0])
        return lambda t: fitted(np.clip(t, 0.0, clock[-1]))
    if name == "gain":
        return lambda t: true.mean() + float(figure) * (of_time(t) - true.mean())
    if name == "wander":
        hz, phase = rng.uniform(*WANDER_HZ, 4), rng.uniform(0, 2 * np.pi, 4)
        return lambda t: of_time(t) + WANDER / np.sqrt(2) * np.sin(2 * np.pi * np.outer(t, hz) + phase).sum(axis=1)
    if name == "spell":
        length = float(figure.removesuffix("ms")) / 1000
        steps = round(length * STEPS_PER_S)
        begin = clock[int(np.argmax(np.abs(true[steps:] - true[:-steps])))]
        return lambda t: of_time(np.where((t >= begin) & (t < begin + length), begin, t))
    raise ValueError(f"forgery {kind!r} is not known; choose one of {', '.join(KINDS)}")


def sheared(picture: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """A frame's luma (H, W), each axis sheared at random along the other, about the middle."""
    height, width = picture.shape
    a, b = rng.normal(0.0, SHEAR, 2)
    turn = np.array([[1.0, a, -a * height / 2], [b, 1.0, -b * width / 2]])
    return np.asarray(cv2.warpAffine(picture, turn, (width, height), borderMode=cv2.BORDER_REPLICATE), np.uint8)
