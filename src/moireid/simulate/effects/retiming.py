"""Effects on frame times, and over time.

Frame times: frames that are blended, repeated, frozen, lost or jittered, and slow motion.
Over time: noise reduction that mixes each picture with the one before, as it was after mixing.

Convention: the times in the file are evenly spaced; the effect is that a frame shows another time than its own.
Source: recursive temporal filters of camera pipelines; compensated ones move the picture before along the optical
flow, and trust it less where it still differs (Ehret et al. 2019, and the like).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.effects.effect import Effect, Kind, Luma, Step, Take, Timing, alone

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
            # The last weighs a hair more, so that the truth of this frame is its own.
            parts.append([(j, 1 / len(some) + (1e-6 if j == k else 0.0)) for j in some])
        return Timing(fps, parts)

    return Effect(times=times)


def repeated(figure: float) -> Effect:
    """Filmed at a share of the file's rate; each frame of the file shows the last one taken."""

    def times(frames: int, fps: float, seed: int) -> Timing:
        return _plain(figure * fps, np.floor(np.arange(frames) * figure + 1e-9))

    return Effect(times=times)


def frozen(figure: float) -> Effect:
    """The picture is frozen for so many s, again and again, and then jumps to where it would be."""

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
    """Frames taken so many s before or after the times in the file, as a standard deviation."""

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
RETIMINGS = (
    Kind("blend", (25 / 30, 0.8, 0.5), "rate of the camera by the file's, neighbours mixed", PULLDOWN, blended),
    Kind("mix", (2, 3, 5), "frames of which each is the mean", "long exposures feigned by editors", averaged),
    Kind("repeat", (25 / 30, 0.8, 0.5), "rate of the camera by the file's, frames repeated", PULLDOWN, repeated),
    Kind("freeze", (0.1, 0.3, 1.0), "standstill every 2 s, s", "gaps of a wireless line", frozen),
    Kind("skip", (0.02, 0.05, 0.15), "share of frames lost, times closed up", "losses of recorders of calls", skipped),
    Kind(
        "jitter",
        (0.002, 0.005, 0.01),
        "standard deviation of a frame's true time from that in the file, s",
        "web cameras wait a part of a frame for the bus and for light",
        jittered,
    ),
    Kind("slow-motion", (2.0, 4.0, 8.0), "rate of the camera by the file's", "60, 120 and 240 played at 30", slowed),
)


#: A difference of so many counts is taken for motion and not for noise: about three times a phone's noise.
MOTION_COUNTS = 8.0
#: Flow is sought at a half of the picture's size, where it is as good and four times as fast.
FLOW_SCALE = 0.5


def recursive(figure: float) -> Effect:
    """Each picture has so large a share of the one before."""

    def begin(take: Take) -> Step:
        before: list[np.ndarray] = []

        def step(number: int, luma: Luma) -> Luma:
            last = before.pop() if before else luma.astype(np.float32)
            mixed = (1 - figure) * luma + np.float32(figure) * last
            before.append(mixed.astype(np.float32))
            return np.asarray(np.rint(mixed), np.uint8)

        return step

    return alone(begin)


def compensated(figure: float) -> Effect:
    """The same, the picture before moved along the optical flow; less of it where the two still differ."""

    def begin(take: Take) -> Step:
        flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)
        width, height = take.size
        columns, rows = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
        before: list[np.ndarray] = []

        def step(number: int, luma: Luma) -> Luma:
            if not before:
                before.append(luma.astype(np.float32))
                return luma
            last = before.pop()
            small = [
                cv2.resize(one, None, fx=FLOW_SCALE, fy=FLOW_SCALE, interpolation=cv2.INTER_AREA)
                for one in (luma, np.rint(last).astype(np.uint8))
            ]
            way = cv2.resize(flow.calc(small[0], small[1], None), take.size) / np.float32(FLOW_SCALE)
            moved = cv2.remap(
                last, columns + way[..., 0], rows + way[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )
            off = cv2.blur(np.abs(luma - moved), (5, 5))
            share = np.float32(figure) * np.exp(-((off / np.float32(MOTION_COUNTS)) ** 2))
            mixed = luma + share * (moved - luma)
            before.append(mixed.astype(np.float32))
            return np.asarray(np.rint(np.clip(mixed, 0, 255)), np.uint8)

        return step

    return alone(begin)


MIXINGS = (
    Kind(
        "tnr",
        (0.15, 0.3, 0.45),
        "share of the picture before in each picture, without motion compensation",
        "what programs for web cameras and low light mix",
        recursive,
    ),
    Kind(
        "tnr-mc",
        (0.3, 0.5, 0.7),
        "share of the picture before, moved along the optical flow",
        "phones mix more once they compensate motion",
        compensated,
    ),
)
