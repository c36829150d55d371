"""Times: frames that are blended, repeated, frozen, lost or jittered, and slow motion.

Convention: the file tells evenly spaced times throughout; a frame that shows another time than it tells is the effect.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.effects.effect import Effect, Kind, Timing

#: Frozen or lost spells begin as often, s.
SPELL_S = 2.0
#: Jittered frames lie on a grid so many times as fine as the file's frames.
FINE = 16


def blended(figure: float) -> Effect:
    """Filmed at a share of the file's rate; each frame of the file mixes the two frames around its time."""

    def times(frames: int, fps: float, seed: int) -> Timing:
        place = np.arange(frames) * figure
        low = np.floor(place + 1e-9).astype(int)
        shares = np.clip(place - low, 0, 1)
        parts = [
            ((k, 1 - share), (k + 1, share)) if share > 1e-6 else ((k, 1.0),)
            for k, share in zip(low.tolist(), shares.tolist(), strict=True)
        ]
        return Timing(figure * fps, parts)

    return Effect(times=times)


def averaged(figure: float) -> Effect:
    """Each frame of the file is the mean of so many frames, the last of which is its own."""

    def times(frames: int, fps: float, seed: int) -> Timing:
        parts = []
        for k in range(frames):
            some = range(max(k - int(figure) + 1, 0), k + 1)
            # The last weighs a hair more, so that the truth beside the film is its own.
            parts.append([(j, 1 / len(some) + (1e-6 if j == k else 0.0)) for j in some])
        return Timing(fps, parts)

    return Effect(times=times)


def repeated(figure: float) -> Effect:
    """Filmed at a share of the file's rate; each frame of the file shows the last one taken."""

    def times(frames: int, fps: float, seed: int) -> Timing:
        return _plain(figure * fps, np.floor(np.arange(frames) * figure + 1e-9))

    return Effect(times=times)


def frozen(figure: float) -> Effect:
    """The picture stands still for so many s, again and again, and then jumps to where it would be."""

    def times(frames: int, fps: float, seed: int) -> Timing:
        number = np.arange(frames)
        for first in _starts(frames, fps, seed):
            held = slice(first, first + max(round(figure * fps), 1))
            number[held] = number[max(first - 1, 0)]
        return _plain(fps, number)

    return Effect(times=times)


def skipped(figure: float) -> Effect:
    """A share of the frames is lost, and the times of the others are closed up, so that the film runs too fast."""

    def times(frames: int, fps: float, seed: int) -> Timing:
        kept = np.random.default_rng(seed).random(round(2 * frames / (1 - figure)) + 20) >= figure
        return _plain(fps, np.flatnonzero(kept)[:frames])

    return Effect(times=times)


def jittered(figure: float) -> Effect:
    """Frames taken so many s before or after the times that the file tells, as a standard deviation."""

    def times(frames: int, fps: float, seed: int) -> Timing:
        off = figure * fps * np.random.default_rng(seed).standard_normal(frames)
        # No frame comes before the one before it.
        place = np.maximum.accumulate(np.maximum(np.arange(frames) + np.clip(off, -0.45, 0.45), 0))
        return _plain(FINE * fps, np.rint(FINE * place))

    return Effect(times=times)


def slowed(figure: float) -> Effect:
    """Filmed at so many times the file's rate."""
    return Effect(times=lambda frames, fps, seed: _plain(figure * fps, np.arange(frames)))


def _plain(fps: float, numbers: NDArray[np.generic]) -> Timing:
    return Timing(fps, [((int(number), 1.0),) for number in numbers.tolist()])


def _starts(frames: int, fps: float, seed: int) -> list[int]:
    """First frames of spells, one within each SPELL_S."""
    rng, every = np.random.default_rng(seed), max(round(SPELL_S * fps), 2)
    return [int(begin + rng.uniform(0.1, 0.6) * every) for begin in range(0, frames, every)]


PULLDOWN = "25, 24 and 15 frames a second in 30"
KINDS = (
    Kind("blend", (25 / 30, 0.8, 0.5), "rate of the camera by the file's, neighbours mixed", PULLDOWN, blended),
    Kind("mix", (2, 3, 5), "frames of which each is the mean", "long exposures feigned by editors", averaged),
    Kind("repeat", (25 / 30, 0.8, 0.5), "rate of the camera by the file's, frames repeated", PULLDOWN, repeated),
    Kind("freeze", (0.1, 0.3, 1.0), "standstill every 2 s, s", "gaps of a wireless line", frozen),
    Kind("skip", (0.02, 0.05, 0.15), "share of frames lost, times closed up", "losses of recorders of calls", skipped),
    Kind(
        "jitter",
        (0.002, 0.005, 0.01),
        "standard deviation of a frame's true time about the told one, s",
        "web cameras wait a part of a frame for the bus and for light",
        jittered,
    ),
    Kind("slow-motion", (2.0, 4.0, 8.0), "rate of the camera by the file's", "60, 120 and 240 played at 30", slowed),
)
