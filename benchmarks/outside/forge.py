"""Thirteen lies: page and markers move truly, and the lens region's picture is taken from a wrong view.

The kinds are those of `moireid simulate --forge`, made here from their one-line descriptions.  `frozen`: as in the
first frame.  `late`: as 15 frames ago.  `gain_low`, `gain_high`: parallax times 0.6 and 1.5.  `reversed`: mirrored.
`drift`: a view that moves steadily.  `randomwalk`: one that walks at random.  `splice`: two true stretches exchanged.
`wobble`: true, and a slow warp on it.  `patchy`: true in half of the fields of a chessboard.  `generative`: a smooth
random view and warp, as wide as the true one.  `photo`, `screen`: a flat picture of the whole badge, markers too, on
card, and on a display with its grid of pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from outside.bend import Bend
from outside.build import Build
from outside.motion import Course
from outside.page import INK, PAPER, Page
from outside.trace import _lookup, _sheet_at, seen_through

Array = NDArray[np.float64]
KINDS = (
    "frozen", "drift", "randomwalk", "late", "gain_low", "gain_high", "reversed", "splice", "wobble", "patchy",
    "generative", "photo", "screen",
)  # fmt: skip
FLAT = ("photo", "screen")
LATE_FRAMES, LOW, HIGH = 15, 0.6, 1.5
#: The widest view of a drift, tangent; amplitude of a warp, tangent.
WIDEST, WARP = 0.3, 0.12
PHOTO_DPI, SCREEN_PITCH_MM, SCREEN_GAP = 300, 0.233, 0.18


@dataclass(frozen=True)
class Lie:
    """A forgery: from where the lens region is pictured over time, rows of its warp, and where it is true.

    warp: time -> (n, 4) rows of amplitude, k_x, k_y per mm, phase, as `trace.trace` reads.
    """

    eye: Callable[[Array], Array]
    warp: Callable[[float], Array]
    true_at: NDArray[np.bool_]


def lie_about(kind: str, course: Course, seconds: float, fps: float, rng: np.random.Generator) -> Lie:
    """The lie of that kind about a course; the flat kinds are made by `flat_page`."""
    everywhere, none = np.zeros((1, 1), bool), np.zeros((0, 4))
    start = course.views(np.zeros(1))[0]
    true = lambda t: course.views(t)[0]  # noqa: E731
    plain = lambda eye: Lie(eye, lambda t: none, everywhere)  # noqa: E731
    if kind == "frozen":
        return plain(lambda t: np.repeat(start, len(t), axis=0))
    if kind == "late":
        return plain(lambda t: true(np.maximum(t - LATE_FRAMES / fps, 0.0)))
    if kind in ("gain_low", "gain_high", "reversed"):
        times = {"gain_low": LOW, "gain_high": HIGH, "reversed": -1.0}[kind]
        return plain(lambda t: true(t) * np.array([times, times, 1.0]))
    if kind == "splice":
        return plain(lambda t: true(_exchanged(t, seconds)))
    if kind == "drift":
        way = rng.choice([-1.0, 1.0])
        return plain(lambda t: _at_tangent(true(t), way * WIDEST * (2 * t / seconds - 1)))
    if kind == "patchy":
        # Chess fields of about a ninth of the board; in half of them the first frame stays.
        return Lie(lambda t: np.repeat(start, len(t), axis=0), lambda t: none, np.indices((9, 9)).sum(axis=0) % 2 == 0)
    if kind == "randomwalk":
        walk = _random_view(course, seconds, fps, rng, memory_s=None)
        return plain(lambda t: _at_tangent(true(t), walk(t)))
    if kind == "generative":
        view = _random_view(course, seconds, fps, rng, memory_s=1.0)
        return Lie(lambda t: _at_tangent(true(t), view(t)), _warps(rng, 3, WARP / 1.5), everywhere)
    if kind == "wobble":
        return Lie(true, _warps(rng, 1, WARP), everywhere)
    raise ValueError(f"forgery {kind!r} is not known; choose one of {', '.join(KINDS)}")


def _at_tangent(place: Array, tangent: Array) -> Array:
    """The place moved sideways to that tangent of view."""
    moved = place.copy()
    moved[:, 0] = -place[:, 2] * tangent
    return moved


def _exchanged(t: Array, seconds: float) -> Array:
    """Times with the second and the fourth fifth of the film exchanged."""
    fifth = seconds / 5
    return t + np.where(
        (t >= fifth) & (t < 2 * fifth), 2 * fifth, np.where((t >= 3 * fifth) & (t < 4 * fifth), -2 * fifth, 0.0)
    )


def _random_view(
    course: Course, seconds: float, fps: float, rng: np.random.Generator, memory_s: float | None
) -> Callable[[Array], Array]:
    """A random tangent with mean and spread of the true one: a walk, or smooth noise of that memory."""
    t = np.arange(-0.5, seconds + 0.5, 1 / fps)
    place = course.views(np.maximum(t, 0.0))[0]
    true = -place[:, 0] / place[:, 2]
    steps = rng.normal(size=len(t))
    if memory_s is None:
        made = np.cumsum(steps)
    else:
        lags = np.arange(-3 * memory_s, 3 * memory_s, 1 / fps)
        made = np.convolve(rng.normal(size=len(t) + len(lags) - 1), np.exp(-((2 * lags / memory_s) ** 2)), "valid")
    made = (made - made.mean()) / made.std() * true.std() + true.mean()
    return CubicSpline(t, made)  # type: ignore[no-any-return]


def _warps(rng: np.random.Generator, number: int, size: float) -> Callable[[float], Array]:
    """Slow waves over the badge: a wave of 60 to 200 mm, a turn in 2 to 5 s."""
    way, length = rng.uniform(0, 2 * math.pi, number), rng.uniform(60, 200, number)
    hz, phase = rng.choice([-1, 1], number) * rng.uniform(0.2, 0.5, number), rng.uniform(0, 2 * math.pi, number)
    k = 2 * math.pi / length

    def rows(t: float) -> Array:
        return np.stack([np.full(number, size), k * np.cos(way), k * np.sin(way), phase + 2 * math.pi * hz * t], axis=1)

    return rows


def flat_page(kind: str, page: Page, build: Build, distance_mm: float, footprint_mm: float) -> tuple[Page, Build]:
    """The badge's own picture from the front at that distance, as a page without lenses; footprint_mm: of a pixel."""
    pitch = SCREEN_PITCH_MM if kind == "screen" else 25.4 / PHOTO_DPI
    shape = round(page.size_mm[1] / pitch), round(page.size_mm[0] / pitch)
    half = page.size_mm[0] * build.scale[0] / 2, page.size_mm[1] * build.scale[1] / 2
    scale = page.px_per_mm[0] / build.scale[0], page.px_per_mm[1] / build.scale[1]
    lens = page.lens
    picture = _picture(shape, distance_mm, build.sheets, lens.figures, page.fine.T, (*scale, *half))
    # The paper's or the display's own black and white.
    grey = np.clip(255 * (picture - INK) / (PAPER - INK), 0, 255).astype(np.uint8)
    dots = 8 if kind == "screen" else 4
    fine = np.kron(grey, np.ones((dots, dots), np.uint8))
    if kind == "screen":
        dark = (np.arange(max(fine.shape)) % dots) < SCREEN_GAP * dots
        fine[dark[: fine.shape[0]]] = 0
        fine[:, dark[: fine.shape[1]]] = 0
    table = np.rint(255 * (INK + (PAPER - INK) * np.arange(256) / 255)).astype(np.uint8)
    fine = table[fine]
    # A camera whose pixels are larger than a display's sees the mean of its grid.
    fine = fine if footprint_mm < pitch else cv2.resize(fine, grey.shape[::-1], interpolation=cv2.INTER_AREA)
    px_per_mm = fine.shape[1] / page.size_mm[0], fine.shape[0] / page.size_mm[1]
    flat = replace(page, fine=fine, coarse=fine, px_per_mm=px_per_mm, sheets=(), bend=Bend())
    return flat, replace(build, sheets=np.zeros((0, 8)))


@njit(cache=True)
def _picture(shape, distance, sheets, lens, fine, size):
    """What a camera straight before the badge sees in each small square of it, 16 samples each."""
    px, py, half_x, half_y = size
    out = np.zeros(shape)
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(16):
                x = ((j + (k + 0.5) / 16) / shape[1] * 2 - 1) * half_x
                y = ((i + (k * 7 % 16 + 0.5) / 16) / shape[0] * 2 - 1) * half_y
                found = _sheet_at(x, y, sheets, 0.0)
                if found >= 0:
                    out[i, j] += seen_through(x, y, x / distance, y / distance, sheets, found, lens, fine, size)
                else:
                    out[i, j] += _lookup(fine, (y + half_y) * py, (x + half_x) * px) / 255.0
    return out / 16
