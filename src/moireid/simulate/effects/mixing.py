"""Temporal noise reduction: each picture mixed with the one before, as it was after mixing.

Source: recursive temporal filters of camera pipelines; compensated ones move the picture before along the optical
flow, and trust it less where it still differs (Ehret et al. 2019, and the like).
"""

from __future__ import annotations

import cv2
import numpy as np

from moireid.simulate.effects.effect import Effect, Kind, Luma, Step, Take, alone

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


KINDS = (
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
