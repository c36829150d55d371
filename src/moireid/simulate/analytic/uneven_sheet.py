"""What changes smoothly from place to place of a built sheet: where its lenses are, and the air beneath it.

Convention: tables (gratings, rows, columns) over the sheet's own frame (`traced_sheet`), a place every `STEP_MM` along
the lenses (rows) and across (columns), their middle at the board's centre; of one entry where nothing changes.
Source: white noise from the build's seed, smoothed to a Gaussian correlation exp(-d^2 / SMOOTH_MM^2), scaled to its
root mean square over the sheet.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.build import SMOOTH_MM
from moireid.simulate.compiled import njit
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
#: From one entry of a table to the next, mm.  Between entries a field is interpolated, off by 0.3 % of its size.
STEP_MM = 2.5
#: Numbers that keep the chances of one badge apart.
ASIDE, WAVE, WIDTH = 0x51DE, 0xA13, 0x4A17
NOTHING = np.zeros((1, 1, 1))


def lens_asides(scene: Scene) -> Array:
    """How far lenses are from their even places, mm, across: they wander, and the pitch changes across the sheet.

    Source: with a pitch of p (1 + G x / W) over the sheet's width W, the lens that should be at x is at
        x + G x^2 / (2 W); the wander is free of an even shift and an even stretch, which are `Build.lens_offset_mm` and
        `Build.lens_scale`.
    """
    build = scene.build
    if not build.wander_mm and not build.pitch_gradient:
        return NOTHING
    found = []
    for number, (low, _, high, _) in enumerate(_rects(scene)):
        across = _places(scene)
        aside = build.pitch_gradient * (across - (low + high) / 2) ** 2 / (2 * (high - low))
        field = _smooth(scene, number, ASIDE, even=True) if build.wander_mm else 0.0
        found.append(build.wander_mm * field + np.broadcast_to(aside, (len(across), len(across))))
    return np.stack(found)


def air_waves(scene: Scene) -> Array:
    """How much more air there is than `Build.air_gap_mm`, mm."""
    build = scene.build
    if not build.air_wave_mm:
        return NOTHING
    count = len(scene.badge.gratings)
    return np.stack([build.air_wave_mm * _smooth(scene, number, WAVE) for number in range(count)])


def lens_walk(scene: Scene) -> Array:
    """How far each lens lies from its even place, mm; the middle one at the board's centre, one entry where none does.

    Source: independent widths add up to a random walk, here about the board's centre.
    """
    share = scene.build.pitch_jitter
    if share == 0:
        return np.zeros(1)
    half = math.ceil(2 * max(scene.board_half_mm) / scene.lens.pitch_mm)
    rng = np.random.default_rng(np.random.SeedSequence([WIDTH, 2 * half + 1, scene.build.seed]))
    walk = share * scene.lens.pitch_mm * np.cumsum(rng.standard_normal(2 * half + 1))
    return np.asarray(walk - walk[half])


def _rects(scene: Scene) -> list[tuple[float, float, float, float]]:
    """Own rectangle of each grating, from the board's centre, mm."""
    return [scene.own_rect_mm(grating, grating.rect_mm) for grating in scene.badge.gratings]


def _places(scene: Scene) -> Array:
    """Places of a table's entries along one side, mm."""
    half = math.ceil(1.1 * math.hypot(*scene.board_half_mm) / STEP_MM)
    return np.asarray(STEP_MM * np.arange(-half, half + 1), np.float64)


def _smooth(scene: Scene, grating: int, kind: int, *, even: bool = False) -> Array:
    """A smooth field of root mean square 1 over a grating's sheet, its mean 0; even: without slopes as well."""
    places = _places(scene)
    rng = np.random.default_rng([kind, grating, scene.build.seed])
    noise = rng.standard_normal((len(places), len(places)))
    # Smoothing by a Gaussian of deviation s gives a correlation exp(-d^2 / (4 s^2)).
    field: Array = np.asarray(cv2.GaussianBlur(noise, (0, 0), SMOOTH_MM / 2 / STEP_MM, borderType=cv2.BORDER_REFLECT))
    low, begin, high, end = _rects(scene)[grating]
    inside = np.ix_((places >= begin) & (places <= end), (places >= low) & (places <= high))
    x, y = np.meshgrid(places, places)
    shapes = np.stack([np.ones_like(x), x, y] if even else [np.ones_like(x)], axis=-1)
    flat = shapes[inside].reshape(-1, shapes.shape[-1])
    field = field - shapes @ np.linalg.lstsq(flat, field[inside].ravel(), rcond=None)[0]
    found: Array = field / float(field[inside].std())
    return found


@njit(inline="always")
def smooth_at(table: Any, across: float, along: float) -> float:
    """A table's value at a place, between its four neighbours; beyond its edge, that of the edge."""
    last = table.shape[0] - 1
    row = min(max(along / STEP_MM + 0.5 * last, 0.0), last - 1e-9)
    column = min(max(across / STEP_MM + 0.5 * last, 0.0), last - 1e-9)
    i, j = int(row), int(column)
    b, a = row - i, column - j
    above = table[i, j] + a * (table[i, j + 1] - table[i, j])
    below = table[i + 1, j] + a * (table[i + 1, j + 1] - table[i + 1, j])
    value: float = above + b * (below - above)
    return value
