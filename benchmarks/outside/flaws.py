"""What real printers, sheets and wearers do to a badge, each as a change of the page before it is traced.

A flaw belongs to one built badge, so its chance follows from a seed of the build and stays the same in all its films.
Magnitudes: a 1200 dpi laser was measured to widen lines by 42 to 64 um; sheets for pictures that flip have a radius up
to 1.47 times that which focuses on the back (US6726858); their pitch differs across the web, as they shrink when
they are extruded (US8192654); good lenses are elliptical (SPIE 5874-06).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from outside.bend import Bend
from outside.page import Page

Grey = NDArray[np.uint8]
#: Light that is scattered within a sheet spreads over about this far, mm; lenses wander, and air changes, over so much;
#: bands recur.
HAZE_MM, WANDER_MM, WAVES_MM, BAND_MM = 3.0, 25.0, 25.0, 12.7


@dataclass(frozen=True)
class Flaws:
    """Flaws of one built badge.

    ink_um: by which printed lines are wider, both edges together; bands: change of reflectance along the page, as a
    share; focus: the lenses' radius over that which was sold as; air_mm: between sheet and page; wander_mm: root mean
    square by which lenses are off their places, smooth across the sheet; haze: share of the light that is mixed from
    all around; waves_mm: root mean square of the air's change over the sheet, about air_mm and never below 0; ellipse:
    lenses of the profile that focuses; gradient: by how much the last lens of a sheet is wider than the first, as a
    share; bow_m: radius to which the badge is bent, positive where its edges recede, 0 for a flat one; bow_deg: that
    cylinder's axis in the page, from x to y, by chance where None; twist_per_m: z = twist x y.
    """

    ink_um: float = 0.0
    bands: float = 0.0
    focus: float = 1.0
    air_mm: float = 0.0
    wander_mm: float = 0.0
    haze: float = 0.0
    waves_mm: float = 0.0
    ellipse: bool = False
    gradient: float = 0.0
    bow_m: float = 0.0
    bow_deg: float | None = None
    twist_per_m: float = 0.0


def flawed(page: Page, flaws: Flaws, seed: int) -> Page:
    """The page with these flaws."""
    rng = np.random.default_rng([seed, 41])
    fine = page.fine
    if flaws.ink_um:
        fine = _wider(fine, flaws.ink_um / 2000 * page.px_per_mm[0])
    if flaws.wander_mm or flaws.gradient:
        fine = _displaced(page, fine, flaws, rng)
    if flaws.bands:
        rows = np.arange(fine.shape[0]) / page.px_per_mm[1]
        wave = 1 + flaws.bands * np.sin(2 * np.pi * rows / BAND_MM + rng.uniform(0, 6.28))
        fine = np.clip(np.rint(fine * wave[:, None]), 0, 255).astype(np.uint8)
    if flaws.haze:
        fine = _hazy(page, fine, flaws.haze)
    size = page.coarse.shape[::-1]
    coarse = cv2.resize(fine, size, interpolation=cv2.INTER_AREA)
    radius, conic = page.lens.radius_mm * flaws.focus, -1 / page.lens.index**2 if flaws.ellipse else 0.0
    lens = replace(page.lens, radius_mm=radius, air_mm=flaws.air_mm, conic=conic)
    page = replace(page, fine=fine, coarse=coarse, lens=lens, bend=_bend(flaws, seed))
    return _on_waves(page, flaws, rng) if flaws.waves_mm else page


def _bend(flaws: Flaws, seed: int) -> Bend:
    """The badge's shape."""
    by_chance = float(np.random.default_rng([seed, 43]).uniform(0, math.pi))
    axis = by_chance if flaws.bow_deg is None else math.radians(flaws.bow_deg)
    return Bend(1 / (1000 * flaws.bow_m) if flaws.bow_m else 0.0, axis, flaws.twist_per_m / 1000)


def _on_waves(page: Page, flaws: Flaws, rng: np.random.Generator) -> Page:
    """The page with a map of the air beneath its sheets, one figure a mm, and their mean as the lens's own figure.

    The map's correlation falls to 1 / e within `WAVES_MM`.
    """
    noise = rng.normal(size=[math.ceil(size) for size in page.size_mm[::-1]])
    waves = gaussian_filter(noise, WAVES_MM / 2, mode="wrap")
    air = np.maximum(flaws.air_mm + flaws.waves_mm * (waves - waves.mean()) / waves.std(), 0.0).astype(np.float32)
    beneath = [air[place[:2]].mean() for place in _places(replace(page, px_per_mm=(1.0, 1.0)))]
    return replace(page, air_mm=air, lens=replace(page.lens, air_mm=float(np.mean(beneath))))


def _wider(fine: Grey, by_px: float) -> Grey:
    """Dark edges moved outwards by a part of a pixel: the darkest of the page and of copies that are moved so far."""
    found = fine
    for dx, dy in ((by_px, 0), (-by_px, 0), (0, by_px), (0, -by_px)):
        moved = cv2.warpAffine(
            fine, np.array([[1.0, 0, dx], [0, 1.0, dy]]), fine.shape[::-1], borderMode=cv2.BORDER_REPLICATE
        )
        found = np.minimum(found, moved)
    return found


def _places(page: Page) -> list[tuple[slice, slice, bool]]:
    """Rows and columns of the raster under each sheet, and whether its lenses stand upright."""
    found = []
    for sheet in page.sheets:
        upright = abs(np.cos(sheet.angle_rad)) > 0.5
        half = sheet.half_mm if upright else sheet.half_mm[::-1]
        middle = np.array(page.size_mm) / 2 + sheet.center_mm
        low, high = (np.rint((middle + side * np.array(half)) * page.px_per_mm).astype(int) for side in (-1, 1))
        low = np.maximum(low, 0)
        found.append((slice(low[1], high[1]), slice(low[0], high[0]), upright))
    return found


def _displaced(page: Page, fine: Grey, flaws: Flaws, rng: np.random.Generator) -> Grey:
    """The lines under each sheet moved as its lenses are off their places, the other way."""
    fine = fine.copy()
    for rows, columns, upright in _places(page):
        part = fine[rows, columns] if upright else np.ascontiguousarray(fine[rows, columns].T)
        scale = page.px_per_mm[0 if upright else 1]
        width = part.shape[1]
        knots = max(4, round(width / scale / WANDER_MM) + 3)
        smooth = np.interp(np.arange(width), np.linspace(0, width, knots), rng.normal(size=knots))
        smooth -= np.polyval(np.polyfit(np.arange(width), smooth, 1), np.arange(width))
        wander = flaws.wander_mm * scale * smooth / max(smooth.std(), 1e-9)
        # A pitch that grows evenly puts lenses off by a parabola.
        parabola = flaws.gradient * width / 2 * (np.arange(width) / width - 0.5) ** 2
        off = (wander + parabola - parabola.mean()).astype(np.float32)
        x, y = np.meshgrid(np.arange(width, dtype=np.float32) + off, np.arange(part.shape[0], dtype=np.float32))
        moved = cv2.remap(part, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        fine[rows, columns] = moved if upright else moved.T
    return fine


def _hazy(page: Page, fine: Grey, share: float) -> Grey:
    """Under each sheet, a share of the light comes from all around."""
    fine = fine.copy()
    for rows, columns, _ in _places(page):
        part = fine[rows, columns]
        small = cv2.resize(part, None, fx=0.1, fy=0.1, interpolation=cv2.INTER_AREA)
        wide = cv2.GaussianBlur(small, (0, 0), HAZE_MM * page.px_per_mm[0] / 10)
        around = cv2.resize(wide, part.shape[::-1], interpolation=cv2.INTER_LINEAR)
        fine[rows, columns] = cv2.addWeighted(part, 1 - share, around, share, 0)
    return fine
