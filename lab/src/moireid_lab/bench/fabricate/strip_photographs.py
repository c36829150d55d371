"""The ink strip of a pitch test as a printer that widens lines makes it, and photographs of it by an odd camera.

None of the reader's code is used: lines are drawn edge by edge, and the camera is one of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.calibration.chart_reading import view_chart
from moireid.ink_strip import ink_patches, strip_rect_mm
from moireid.verifier.picture import CODING_POWER
from moireid_lab.bench.fabricate.calibration import STILL, PhotoCase, photograph

#: Dots of the drawn strip to a millimetre, across and down its lines; white around it, mm.
FINE, COARSE, AROUND_MM = 100, 20, 4.0
Array = NDArray[np.float64]


@dataclass(frozen=True)
class OddCamera:
    """A camera that codes light in its own way.

    px_per_mm: scale; coding: power of its tone curve, and shape: an S-shaped term of it; blur_px, noise: of the
    picture, px and counts; unevenness: of the light, as a share; exposure: light of paper, 1 being the most;
    sharpening: share of detail that is added to the picture.
    """

    px_per_mm: float = 4.0
    coding: float = 2.2
    shape: float = 0.0
    blur_px: float = 0.8
    noise: float = 2.0
    unevenness: float = 0.15
    exposure: float = 0.75
    sharpening: float = 0.0


def any_camera(seed: int) -> OddCamera:
    """A camera drawn over what phones do, from about 1 m."""
    rng = np.random.default_rng(seed)
    return OddCamera(
        px_per_mm=float(rng.uniform(2.2, 8.0)),
        coding=float(rng.uniform(1.7, 2.7)),
        shape=float(rng.uniform(-0.3, 0.5)),
        blur_px=float(rng.uniform(0.6, 1.6)),
        noise=float(rng.uniform(1.0, 5.0)),
        unevenness=float(rng.uniform(-0.4, 0.4)),
        exposure=float(rng.uniform(0.5, 0.9)),
        sharpening=float(rng.choice([0.0, 0.0, 0.3])),
    )


def printed_strip(chart: Badge, growth_um: float, ink: float = 0.08) -> NDArray[np.float32]:
    """Light of the strip with `AROUND_MM` of white around it, paper 1; lines wider by that growth."""
    x0, y0, x1, y1 = strip_rect_mm(chart)
    x0, y0, x1, y1 = x0 - AROUND_MM, y0 - AROUND_MM, x1 + AROUND_MM, y1 + AROUND_MM
    page = np.ones((round((y1 - y0) * COARSE), round((x1 - x0) * FINE)), np.float32)
    column = np.arange(page.shape[1])
    for patch in ink_patches(chart):
        half = growth_um / 2000 if patch.pitch_mm else 0.0
        dark = np.zeros(len(column))
        for low, _, high, _ in patch.lines_mm:
            begin, end = (low - half - x0) * FINE, (high + half - x0) * FINE
            dark += np.clip(np.minimum(column + 1, end) - np.maximum(column, begin), 0, 1)
        top, bottom = (round((y - y0) * COARSE) for y in patch.rect_mm[1::2])
        page[top:bottom] -= (1 - ink) * np.clip(dark, 0, 1)
    return page


def filmed(light: NDArray[np.float32], page: Array, size: tuple[int, int], chart: Badge, blur_px: float) -> Array:
    """The printed strip as it falls on a sensor of that size (width, height); page: homography, page mm -> px."""
    x0, y0, *_ = strip_rect_mm(chart)
    place = np.array(
        [
            [1 / FINE, 0, x0 - AROUND_MM + 0.5 / FINE],
            [0, 1 / COARSE, y0 - AROUND_MM + 0.5 / COARSE],
            [0, 0, 1],
        ]
    )
    times = 4
    finer = np.array([[times, 0, (times - 1) / 2], [0, times, (times - 1) / 2], [0, 0, 1.0]])
    scale = abs(np.linalg.det(page)) ** 0.5
    soft = cv2.blur(light, (max(1, round(FINE / scale / times)), 1))
    big = cv2.warpPerspective(soft, finer @ page @ place, (size[0] * times, size[1] * times), borderValue=1.0)
    small = cv2.resize(big, size, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(small, (0, 0), blur_px), float)


def photographed_strip(
    chart: Badge, growth_um: float, camera: OddCamera, seed: int = 0
) -> tuple[NDArray[np.uint8], Array]:
    """A picture of the strip alone, at a slight angle, and its homography, page mm -> px."""
    x0, y0, x1, y1 = strip_rect_mm(chart)
    scale, turn = camera.px_per_mm, 0.02
    size = round((x1 - x0) * scale) + 60, round((y1 - y0) * scale) + 90
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    page = np.array([[c, -s, 30], [s, c, 30], [2e-4, 0, 1]]) @ np.array([[1, 0, -x0], [0, 1, -y0], [0, 0, 1.0]])
    across = np.linspace(-0.5, 0.5, size[0])
    light = filmed(printed_strip(chart, growth_um), page, size, chart, camera.blur_px)
    light *= camera.exposure * (1 + camera.unevenness * (across - across**2))
    coded = np.clip(light, 0, 1) ** (1 / camera.coding)
    coded = coded + camera.shape * coded * (1 - coded) * (2 * coded - 1)
    if camera.sharpening:
        coded = coded + camera.sharpening * (coded - cv2.GaussianBlur(coded, (0, 0), 1.5))
    counts = 255 * coded + camera.noise * np.random.default_rng(seed).standard_normal(coded.shape)
    return np.clip(np.rint(counts), 0, 255).astype(np.uint8), page


def photographed_chart(chart: Badge, case: PhotoCase, growth_um: float, seed: int = 5) -> NDArray[np.uint8]:
    """A photograph of the whole chart under a sheet, with the strip at its foot, which the simulator does not draw."""
    luma = photograph(chart, case, seed)
    page = view_chart(luma, chart, focal_px=STILL.focal_px).page
    assert page is not None
    light = filmed(printed_strip(chart, growth_um), page, (luma.shape[1], luma.shape[0]), chart, 0.7)
    coded = 255 * ((luma / 255.0) ** CODING_POWER * light) ** (1 / CODING_POWER)
    return np.rint(coded).astype(np.uint8)
