"""Brightness: tone mapping, sharpening halos, exposure that follows the fringes, and glare.

Convention: pictures are coded by a square root, as `recording.sensor` codes them; stops are factors of two of light.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.effects.effect import Effect, Kind, Luma, Step, Take, alone
from moireid.simulate.light import light_named
from moireid.simulate.scene import Scene

Float = NDArray[np.float32]
#: Tiles of an equalised picture across and down, OpenCV's usual.
TILES = (8, 8)
#: The base of a picture in local tone mapping: edge-keeping filter, its reach as a share of the width, and counts.
BASE_SHARE, BASE_COUNTS = 0.02, 40.0
#: Standard deviation of an editor's unsharp mask, px, wider than a camera's own.
HALO_PX = 3.0
#: Lights by their glare.
LAMPS = ("lamp", "window", "sun")
#: Side of the metered spot, mm on the page; time in which exposure comes two thirds of the way, s; its steps, stops.
SPOT_MM, METERING_S, STEP_STOPS = 9.0, 0.15, 1 / 8


def equalised(figure: float) -> Effect:
    """Contrast-limited adaptive histogram equalisation with this limit of contrast (Zuiderveld 1994)."""

    def begin(take: Take) -> Step:
        clahe = cv2.createCLAHE(figure, TILES)
        return lambda number, luma: np.asarray(clahe.apply(luma), np.uint8)

    return alone(begin)


def compressed(figure: float) -> Effect:
    """Local tone mapping: the base's contrast is lowered by a share, detail is kept (Durand and Dorsey 2002)."""

    def begin(take: Take) -> Step:
        reach = max(round(BASE_SHARE * take.size[0]), 2)

        def step(number: int, luma: Luma) -> Luma:
            full = luma.astype(np.float32)
            base = cv2.ximgproc.guidedFilter(full, full, reach, BASE_COUNTS**2)
            mapped = full - figure * (base - base.mean())
            return np.asarray(np.clip(np.rint(mapped), 0, 255), np.uint8)

        return step

    return alone(begin)


def haloed(figure: float) -> Effect:
    """An unsharp mask of this strength."""

    def step(number: int, luma: Luma) -> Luma:
        soft = cv2.GaussianBlur(luma, (0, 0), HALO_PX)
        return np.asarray(cv2.addWeighted(luma, 1 + figure, soft, -figure, 0), np.uint8)

    return alone(lambda take: step)


def metered(figure: float) -> Effect:
    """An exposure metered on a spot amid the fringes, which evens out a share of the spot's swings, in steps."""

    def begin(take: Take) -> Step:
        state = {"stops": 0.0, "aim": 0.0}
        keep = np.exp(-1 / (METERING_S * take.fps))

        def step(number: int, luma: Luma) -> Luma:
            gain = 2.0 ** (STEP_STOPS * round(state["stops"] / STEP_STOPS))
            shown = np.clip(np.sqrt(gain) * luma.astype(np.float32), 0, 255)
            # Metered before the gain, so that this loop cannot swing by itself.
            light = _spot(take, number, luma.astype(np.float32))
            state["aim"] = state["aim"] or light
            wanted = figure * np.log2(state["aim"] / max(light, 1e-3))
            state["stops"] = keep * state["stops"] + (1 - keep) * wanted
            return np.asarray(np.rint(shown), np.uint8)

        return step

    return alone(begin)


def _spot(take: Take, number: int, luma: Float) -> float:
    """Mean light of the spot amid the gratings, 0 to 1; of the whole picture where the spot is out of sight."""
    x, y = take.centre_mm
    half = SPOT_MM / 2
    square = np.array([[[x - half, y - half]], [[x + half, y + half]]])
    (left, top), (right, bottom) = np.rint(cv2.perspectiveTransform(square, take.pages[number])[:, 0]).astype(int)
    part = luma[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)]
    return float(np.mean((part if part.size else luma) ** 2) / 255**2)


def glaring(figure: float) -> Effect:
    """A light that shines on the badge and is mirrored by its lenses; the figure is its place in LAMPS."""
    name = LAMPS[int(figure)]

    def lit(scene: Scene) -> Scene:
        return replace(scene, light=light_named(name))

    return Effect(scene=lit)


KINDS = (
    Kind(
        "clahe", (1.5, 2.5, 4.0), "limit of contrast, 8 by 8 tiles", "OpenCV's usual is 40, editors' 2 to 3", equalised
    ),
    Kind("tone-map", (0.2, 0.4, 0.6), "share of the base's contrast taken away", "Durand and Dorsey 2002", compressed),
    Kind("halos", (0.5, 1.0, 2.0), "strength of an unsharp mask of 3 px", "editors offer up to 5", haloed),
    Kind(
        "exposure",
        (0.25, 0.5, 1.0),
        "share of a spot's swings that exposure evens out, in steps of 1/8 stop",
        "1 is a spot metered by a tap on the badge",
        metered,
    ),
    Kind("glare", (0, 1, 2), "the light: lamp, window, sun", "light of `simulate`", glaring),
)
