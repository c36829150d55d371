"""The frame: crops, tiles, zoom, auto-framing, focus breathing, stretched pixels, and a virtual background.

For a virtual background a call program cuts out what it takes for the person, and so removes pieces of the badge's
outline.

Convention: pixel centres are whole numbers; a map (3, 3) leads from px of the picture before to px of the one after.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.effects.effect import Effect, Kind, Luma, Step, Take, alone, moved
from moireid.simulate.recording.encode import Recipe

Array = NDArray[np.float64]
#: Rows of what a call program sends of a picture of 16 by 9 (854 x 480).
FRAMED_ROWS = 480
#: Time in which an auto-framing camera lags behind the subject by twice this time, s; ours, as it is seen in calls.
FOLLOWING_S = 0.25
#: A contrast-driven autofocus hunts about as often, and moves the lens within so long, s.
REFOCUS_S, FOCUS_MOVE_S = 1.5, 0.15
#: Grey around a tile, as call programs paint it, and the share of the recording's width between its rim and the tile.
AROUND, TILE_MARGIN = 40, 0.02


def window(take: Take, centres: Array, width: Array, size: tuple[int, int]) -> Array:
    """Maps (T, 3, 3) of windows of the picture, px wide (T,), about centres (T, 2), to pictures of a size."""
    scale = size[0] / width
    maps = np.zeros((len(take), 3, 3))
    maps[:, 0, 0] = maps[:, 1, 1] = scale
    maps[:, :2, 2] = (np.array(size) - 1) / 2 - scale[:, None] * centres
    maps[:, 2, 2] = 1.0
    return maps


def reframed(take: Take, maps: Array, size: tuple[int, int]) -> tuple[Step, Take]:
    """The step that maps every picture, and what is known behind it; bicubic, as editors do."""

    def step(number: int, luma: Luma) -> Luma:
        shown = cv2.warpAffine(luma, maps[number, :2], size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(shown, np.uint8)

    return step, moved(take, maps, size)


def middles(take: Take) -> Array:
    """The pictures' middle, for each frame (T, 2)."""
    return np.tile((np.array(take.size) - 1) / 2, (len(take), 1))


def even(value: float) -> int:
    """The nearest even number; encoders take no other sizes."""
    return 2 * round(value / 2)


def zoomed(zoom: Callable[[Take], Array]) -> Effect:
    """A zoom about the picture's middle; zoom: magnification of each frame, 1 or more."""

    def begin(take: Take) -> tuple[Step, Take]:
        return reframed(take, window(take, middles(take), take.size[0] / zoom(take), take.size), take.size)

    return Effect(begin=begin)


def eased(share: Array) -> Array:
    """From 0 to 1 without a jolt, for a share of the way below 0 to above 1."""
    held = np.clip(share, 0, 1)
    return np.asarray(held * held * (3 - 2 * held))


def slow_zoom(figure: float) -> Effect:
    """From 1 to the figure in the middle half of the film."""
    return zoomed(lambda take: 1 + (figure - 1) * eased(2 * np.arange(len(take)) / len(take) - 0.5))


def sudden_zoom(figure: float) -> Effect:
    """From 1 to the figure between two frames in the middle of the film."""
    return zoomed(lambda take: np.where(np.arange(len(take)) < len(take) / 2, 1.0, figure))


def breathing(figure: float) -> Effect:
    """Focal lengths that lie within a share `figure` of the camera's, new ones as often as an autofocus moves.

    The picture is cropped so that no frame looks beyond its rim.
    """
    from scipy.ndimage import gaussian_filter1d

    def zoom(take: Take) -> Array:
        events = take.rng.uniform(0, figure, 2 + math.ceil(len(take) / take.fps / REFOCUS_S))
        held = events[(np.arange(len(take)) / take.fps / REFOCUS_S).astype(int)]
        return np.asarray(1 + gaussian_filter1d(held, FOCUS_MOVE_S * take.fps, mode="nearest"))

    return zoomed(zoom)


def cropped(figure: float) -> Effect:
    """A share of the width cut off on the right."""

    def begin(take: Take) -> tuple[Step, Take]:
        size = even((1 - figure) * take.size[0]), take.size[1]
        maps = np.tile(np.eye(3), (len(take), 1, 1))
        return (lambda number, luma: np.ascontiguousarray(luma[:, : size[0]])), moved(take, maps, size)

    return Effect(begin=begin)


def tiled(figure: float) -> Effect:
    """The picture as a tile at the top left of a recording that is so many times as wide and high."""

    def begin(take: Take) -> tuple[Step, Take]:
        (width, height), size = take.size, (even(figure * take.size[0]), even(figure * take.size[1]))
        x, y = round(TILE_MARGIN * size[0]), round(TILE_MARGIN * size[1])
        around = np.full(size[::-1], AROUND, np.uint8)
        # Another speaker, who does not move, below and to the right; as much of that tile as there is room.
        grain = take.rng.integers(30, 220, (9, 16)).astype(np.uint8)
        other = cv2.resize(grain, (width, height), interpolation=cv2.INTER_CUBIC)
        below = around[y + height + y :, x + width + x :]
        below[:] = other[: below.shape[0], : below.shape[1]]

        def step(number: int, luma: Luma) -> Luma:
            whole = around.copy()
            whole[y : y + height, x : x + width] = luma
            return whole

        maps = np.tile(np.array([[1.0, 0, x], [0, 1, y], [0, 0, 1]]), (len(take), 1, 1))
        return step, moved(take, maps, size)

    return Effect(begin=begin)


def wider(times: float, recipe: Callable[[Recipe], Recipe] | None = None) -> Effect:
    """Every picture so many times as wide."""

    def begin(take: Take) -> tuple[Step, Take]:
        size = even(times * take.size[0]), take.size[1]
        across = size[0] / take.size[0]
        stretch = np.array([[across, 0, (across - 1) / 2], [0, 1, 0], [0, 0, 1]])
        way = cv2.INTER_AREA if across < 1 else cv2.INTER_CUBIC
        maps = np.tile(stretch, (len(take), 1, 1))
        return (lambda number, luma: np.asarray(cv2.resize(luma, size, interpolation=way), np.uint8)), moved(
            take, maps, size
        )

    return Effect(begin=begin, recipe=recipe)


def anamorphic(figure: float) -> Effect:
    """Pixels so many times as wide as high, and a flag in the file that says so."""
    aspect = Fraction(figure).limit_denominator(64)

    def flagged(recipe: Recipe) -> Recipe:
        return replace(recipe, passes=(*recipe.passes[:-1], replace(recipe.passes[-1], aspect=aspect)))

    return wider(1 / figure, flagged)


def framed(share: Callable[[Take], Array]) -> Effect:
    """A window that follows the badge smoothly, scaled to what a call sends; share: its width by the picture's."""

    def begin(take: Take) -> tuple[Step, Take]:
        width, height = take.size
        size = (even(FRAMED_ROWS * width / height), FRAMED_ROWS)
        wide = share(take) * width
        half = np.column_stack([wide, wide * size[1] / size[0]]) / 2
        centres = followed(take.centres_px, FOLLOWING_S * take.fps)
        # The window stays within the picture.
        centres = np.clip(centres, half - 0.5, np.array([width, height]) - half - 0.5)
        return reframed(take, window(take, centres, wide, size), size)

    return Effect(begin=begin)


def followed(path: Array, frames: float) -> Array:
    """A path (T, 2) as something slow follows it: two low passes of one time constant, one after the other."""
    keep = math.exp(-1 / frames)
    ways = [path[0], path[0]]
    out = np.empty_like(path)
    for k, place in enumerate(path):
        for order, aim in enumerate((place, ways[0])):
            ways[order] = keep * ways[order] + (1 - keep) * aim
        out[k] = ways[1]
    return out


def framing(figure: float) -> Effect:
    """A window of a constant width."""
    return framed(lambda take: np.full(len(take), figure))


def framing_zoom(figure: float) -> Effect:
    """A window of 0.8 of the width that narrows by the figure and widens again, in the middle half of the film."""

    def share(take: Take) -> Array:
        way = 4 * np.arange(len(take)) / len(take) - 1
        there = eased(way) - eased(way - 1)
        return np.asarray(0.8 / (1 + (figure - 1) * there))

    return framed(share)


FRAMINGS = (
    Kind("zoom", (1.15, 1.3, 1.6), "digital zoom from 1 to this, slowly", "a pinch on a phone's screen", slow_zoom),
    Kind("zoom-step", (1.15, 1.3, 1.6), "digital zoom from 1 to this, at once", "a tap on a zoom button", sudden_zoom),
    Kind(
        "autoframe",
        (0.85, 0.667, 0.5),
        "width of the window that follows, by the picture's",
        "call programs send 854 of 1280 columns (0.667)",
        framing,
    ),
    Kind(
        "autoframe-zoom",
        (1.15, 1.3, 1.6),
        "zoom of the window that follows, there and back",
        "as a digital zoom's",
        framing_zoom,
    ),
    Kind(
        "breathing",
        (0.005, 0.015, 0.03),
        "share by which refocusing changes the focal length, at most",
        "thin lens of 5.5 mm: 0.5 % from afar to 1 m; phones move by 1 to 2 %",
        breathing,
    ),
    Kind("crop", (0.1, 0.22, 0.35), "share of the width cut off on the right", "1000 of 1280 columns kept", cropped),
    Kind(
        "tile",
        (1.25, 1.5, 2.0),
        "width of the recording by the tile's, which lies top left",
        "a 720p tile in recordings of 900, 1080 and 1440 rows",
        tiled,
    ),
    Kind(
        "stretch",
        (0.01, 0.03, 0.05),
        "share by which the picture is wider",
        "848 columns for 854 are 0.7 %, 3 % a careless editor's",
        lambda figure: wider(1 + figure),
    ),
    Kind(
        "anamorphic",
        (1.125, 4 / 3, 2.0),
        "width of a pixel by its height, given by a flag",
        "PAL and HDV (1440 for 1920 columns) pixels, and a 2x lens",
        anamorphic,
    ),
)


#: Size of a bite, mm on the page, and its life, s, since masks are smoothed over time.
BITE_MM, BITE_S = 8.0, 0.3
#: Fineness of the mask on the page, px to the mm; softness of its rim in the picture, px; the grey put behind.
FINE, RIM_PX, BEHIND = 1.0, 1.5, 150
#: Frames of bites that are drawn; they begin anew after the last without a jolt.
DRAWN = 64


def nibbled(figure: float) -> Effect:
    """All but the badge replaced by an even grey, and bites of up to so many mm out of its outline."""
    from scipy.ndimage import gaussian_filter

    def begin(take: Take) -> Step:
        x0, y0, x1, y1 = take.outline_mm
        size = round(FINE * (x1 - x0)), round(FINE * (y1 - y0))
        inside = np.pad(np.ones(size[::-1], np.uint8), 1)
        depth_mm = cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1] / FINE
        grain = take.rng.standard_normal((DRAWN, *size[::-1]))
        life = BITE_S * take.fps
        bites = gaussian_filter(grain, (life, BITE_MM * FINE / 2, BITE_MM * FINE / 2), mode="wrap")
        bites = np.clip(bites / (2 * bites.std()), 0, 1)
        to_page = np.array([[1 / FINE, 0, x0 + 0.5 / FINE], [0, 1 / FINE, y0 + 0.5 / FINE], [0, 0, 1]])

        def step(number: int, luma: Luma) -> Luma:
            mask = (depth_mm > figure * bites[number % DRAWN]).astype(np.float32)
            seen = cv2.warpPerspective(mask, take.pages[number] @ to_page, take.size)
            share = cv2.GaussianBlur(seen, (0, 0), RIM_PX)
            return np.asarray(np.rint(BEHIND + share * (luma - np.float32(BEHIND))), np.uint8)

        return step

    return alone(begin)


BACKDROPS = (
    Kind(
        "backdrop",
        (2.0, 5.0, 10.0),
        "depth of bites out of the badge's outline by a virtual background, mm at most",
        "masks of 256 x 144 px are 5 px coarse in 720p: 5 mm at 1 m",
        nibbled,
    ),
)
