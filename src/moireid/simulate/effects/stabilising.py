"""Stabilisers that move the picture frame by frame, rows that wobble, and rolling shutters.

Convention: a positive shutter reads from the top row to the bottom, a negative one from the bottom up.
Source: readout times by gyroflow's lens profiles: of 92 phones 1.4 ms (5 %), 14.5 ms (median), 33.6 ms (95 %).
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.effects.effect import Effect, Kind, Luma, Step, Take, alone
from moireid.simulate.effects.framing import reframed
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
#: Figures in px are for pictures of this width.
WIDTH = 1280
#: Standard deviation of the window over which a stabiliser smooths the camera's path, s.
SMOOTHING_S = 0.5
#: A stabiliser that may move the picture by 25 px may turn it by a degree.
TURN_RAD_PER_PX = math.radians(1.0) / 25
#: Frequencies of rows that wobble: those of a hand.
WOBBLE_HZ = (0.5, 4.0)


def stabilised(figure: float) -> Effect:
    """The path of what lies straight ahead, smoothed by shifts and turns of the picture, px at most; cropped so far."""
    from scipy.ndimage import gaussian_filter1d

    def begin(take: Take) -> tuple[Step, Take]:
        width, height = take.size
        margin = figure * width / WIDTH
        path, turn = _path(take)
        sigma = SMOOTHING_S * take.fps
        # The margin is approached softly, as by stabilisers that avoid jolts.
        most = np.array([margin, margin * height / width])
        shift = most * np.tanh((gaussian_filter1d(path, sigma, axis=0, mode="nearest") - path) / most)
        limit = figure * TURN_RAD_PER_PX
        roll = limit * np.tanh((gaussian_filter1d(turn, sigma, mode="nearest") - turn) / limit)
        scale = width / (width - 2 * margin)
        return reframed(take, _turned(take.size, shift, roll, scale), take.size)

    return Effect(begin=begin)


def _path(take: Take) -> tuple[Array, Array]:
    """Where the mean view's far end is seen (T, 2), px, and the camera's roll (T,), rad."""
    turns = take.poses.rotation
    ahead = turns[:, 2].mean(axis=0)
    upright = np.cross(ahead, turns[:, 0].mean(axis=0))
    seen, up = turns @ ahead, turns @ upright
    return take.focal_px * seen[:, :2] / np.maximum(seen[:, 2:], 0.1), np.arctan2(-up[:, 0], up[:, 1])


def _turned(size: tuple[int, int], shift: Array, roll: Array, scale: float) -> Array:
    """Maps (T, 3, 3) that turn about the picture's middle by -roll, magnify, and shift."""
    middle = (np.array(size) - 1) / 2
    maps = np.tile(np.eye(3), (len(shift), 1, 1))
    cos, sin = scale * np.cos(roll), scale * np.sin(roll)
    maps[:, 0, 0], maps[:, 0, 1], maps[:, 1, 0], maps[:, 1, 1] = cos, -sin, sin, cos
    maps[:, :2, 2] = middle + scale * shift - maps[:, :2, :2] @ middle
    return maps


def wobbling(figure: float) -> Effect:
    """Rows that shift against each other: a picture skewed by up to so many degrees, and bent by half as much."""

    def begin(take: Take) -> Step:
        width, height = take.size
        down = np.linspace(-0.5, 0.5, height)[:, None]
        shapes = np.stack([down, 0.25 * np.sin(2 * np.pi * down)])
        times = np.arange(len(take)) / take.fps
        rng = take.rng
        waves = _waves(rng, times, 4) * math.tan(math.radians(figure)) * height
        columns, rows = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))

        def step(number: int, luma: Luma) -> Luma:
            x, y = np.tensordot(waves[number].reshape(2, 2), shapes, axes=1)
            # Rows that are read too high or too low are a fifth as far off as sideways: hands turn sideways more.
            way = (columns + x).astype(np.float32), (rows + 0.2 * y).astype(np.float32)
            return np.asarray(cv2.remap(luma, *way, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.uint8)

        return step

    return alone(begin)


def _waves(rng: np.random.Generator, times: Array, count: int) -> Array:
    """Smooth random motions (T, count) whose largest is 1: sums of four sines."""
    rates, starts = rng.uniform(*WOBBLE_HZ, (4, count)), rng.uniform(0, 2 * np.pi, (4, count))
    waves = np.sin(2 * np.pi * rates * times[:, None, None] + starts).sum(axis=1)
    return np.asarray(waves / np.abs(waves).max(axis=0))


def rolling(figure: float) -> Effect:
    """A camera whose rows are read one after the other within so many s."""

    def camera(scene: Scene) -> Scene:
        return replace(scene, camera=replace(scene.camera, shutter_s=figure))

    return Effect(scene=camera)


READOUT = "gyroflow's profiles of 92 phones: 5 %, median, 95 %"
KINDS = (
    Kind(
        "eis",
        (15.0, 25.0, 40.0),
        "the picture's shift, px of 1280 columns at most; turned by up to a degree for 25",
        "2 to 6 % of the width on each side, as editors' and phones' stabilisers crop",
        stabilised,
    ),
    Kind(
        "jello",
        (0.2, 0.45, 1.0),
        "skew of a frame, degrees at most; bent by half as much",
        "a phone's f of 0.75 long sides and 14.5 ms, turned at the mean speed of TUM's fr1 xyz, desk and rpy",
        wobbling,
    ),
    Kind("shutter", (0.0014, 0.0145, 0.0336), "readout from the top, s", READOUT, rolling),
    Kind("shutter-up", (0.0014, 0.0145, 0.0336), "readout from the bottom, s", READOUT, lambda s: rolling(-s)),
)
