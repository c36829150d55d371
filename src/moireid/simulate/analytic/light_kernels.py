"""The light's part in the compiled loop: how bright the page is where a ray lands, and what the lens mirrors.

Convention: as `light`; the sheet's own frame (`traced_sheet`), s across the lenses.
Source: the table of `light.light_table`; Fresnel's equations; the law of reflection.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Lens
from moireid.simulate.analytic.traced_sheet import TracedSheet, meet
from moireid.simulate.compiled import njit
from moireid.simulate.light import DiscLight, light_table, straight_share

Array = NDArray[np.float64]


def lamp_figures(lens: Lens, light: DiscLight, reach_mm: tuple[float, float], ray_rad: float) -> tuple[Array, Array]:
    """The light as `lit` reads it: ten figures, and the table.

    Parameters: as `light.light_table`; ray_rad: the angle across the lenses that one ray of a pixel covers.
    Convention: figures are place across, along, depth; radius; radiance; the sky's radiance; first place of the table
        and its spacing; share passed straight on; ray_rad.  The table's first row is the sky's.
    Source: `light`.
    """
    sky, places, disc = light_table(lens, light, reach_mm)
    figures = [
        *light.place_mm,
        light.radius_mm,
        light.radiance,
        1.0 - light.share,
        places[0],
        places[1] - places[0],
        straight_share(lens.refractive_index),
        ray_rad,
    ]
    return np.array(figures), np.vstack([sky, disc])


@njit()
def _passed(n: float, cosine: float) -> float:
    """The share of light that passes from air into glass (Fresnel), as `light.passed_share`."""
    inner = math.sqrt(1.0 - (1.0 - cosine * cosine) / (n * n))
    across, along = (cosine - n * inner) / (cosine + n * inner), (n * cosine - inner) / (n * cosine + inner)
    return 1.0 - (across * across + along * along) / 2


@njit()
def _sees_sky(hit: float, depth: float, tx: float, sheet: TracedSheet) -> bool:
    """Whether a ray mirrored there passes over the next lens; only its way across the lenses matters."""
    pitch, radius = sheet.pitch, sheet.radius
    nx, nz = hit / radius, (depth - radius) / radius
    turn = 2.0 * (tx * nx + nz)
    rx, rz = tx - turn * nx, 1.0 - turn * nz
    if rz >= 0.0:
        return False
    # How far the next circle's middle lies below the ray, times the ray's length.
    to_next = (pitch if rx >= 0.0 else -pitch) - hit
    below = (to_next * rz - (radius - depth) * rx) * (-1.0 if rx >= 0.0 else 1.0)
    above: bool = below >= radius * math.sqrt(rx * rx + rz * rz)
    return above


@njit()
def light_at(s: float, along: float, landed: float, lamp: Any, table: Any, pitch: float) -> float:
    """How bright the page is where a ray lands: the table between its neighbours, the disc's fall along the lenses."""
    row = min(max((s - lamp[6]) / lamp[7], 0.0), table.shape[0] - 2.0)
    first = min(int(row), table.shape[0] - 3)
    lower = row - first
    place = landed / pitch
    place = (place - math.floor(place)) * table.shape[1]
    left = int(place)
    part = place - left
    left, right = left % table.shape[1], (left + 1) % table.shape[1]
    sky = table[0, left] * (1 - part) + table[0, right] * part
    near = table[first + 1, left] * (1 - part) + table[first + 1, right] * part
    far = table[first + 2, left] * (1 - part) + table[first + 2, right] * part
    # A disc that faces the centre fades with the cube of its distance, and by the cosine on its own side.
    across2 = (lamp[0] - s) ** 2 + lamp[2] ** 2
    distance2 = (across2 + lamp[1] ** 2) / (across2 + (lamp[1] - along) ** 2)
    whole = lamp[0] * lamp[0] + lamp[1] * lamp[1] + lamp[2] * lamp[2] - lamp[0] * s
    light: float = sky + (near * (1 - lower) + far * lower) * distance2 * distance2 * (whole - lamp[1] * along) / whole
    return light


@njit()
def glare_at(s: float, along: float, tx: float, ty: float, step: float, sheet: TracedSheet, lamp: Any) -> float:
    """Radiance of the disc mirrored by the lenses, mean over `step` mm across about s.

    A cylinder keeps a ray's direction along its axis and turns the rest.  So one narrow strip of each lens shows the
    light.  Single rays may miss the strip, so its exact width is used, as a share of the step.
    """
    n, radius, pitch = sheet.refraction, sheet.radius, sheet.pitch
    length = math.sqrt(1.0 + tx * tx + ty * ty)
    lx, ly, lz = lamp[0] - s, lamp[1] - along, lamp[2] + sheet.gap
    far = math.sqrt(lx * lx + ly * ly + lz * lz)
    keep, kept = ty / length, ly / far
    flat, flat_light = math.sqrt(1.0 - keep * keep), math.sqrt(1.0 - kept * kept)
    cosine = (far / math.sqrt(far * far + lamp[3] * lamp[3]) - keep * kept) / (flat * flat_light)
    if cosine >= 1.0:
        return 0.0
    half = math.acos(max(cosine, -1.0))
    view, light = math.atan2(-tx, 1.0), math.atan2(lx, -lz)
    between = (1.0 + (-tx * lx - ty * ly - lz) / (length * far)) / 2
    mirrored = lamp[4] * (1.0 - _passed(n, math.sqrt(max(between, 0.0))))
    if radius == 0.0:
        return mirrored if abs(view + light) < half else 0.0
    # Normals that mirror the light's two edges, and where across the apex plane rays to them pass.
    edge = math.asin(min(pitch / 2 / radius, 1.0))
    low = min(max((view + light - half) / 2, -edge), edge)
    high = min(max((view + light + half) / 2, -edge), edge)
    begin = radius * (math.sin(low) - tx * (1.0 - math.cos(low)))
    width = radius * (math.sin(high) - tx * (1.0 - math.cos(high))) - begin
    if width <= 0.0:
        return 0.0
    width = min(width, pitch)
    covered = 0.0
    for sign in (1.0, -1.0):
        turns = (s + sign * step / 2 - begin) / pitch
        whole = math.floor(turns)
        covered += sign * (whole * width + min((turns - whole) * pitch, width))
    glare: float = mirrored * covered / step
    return glare


@njit()
def lit(
    value: float,
    s: float,
    along: float,
    tx: float,
    ty: float,
    landed: float,
    step: float,
    sheet: Any,
    lamp: Any,
    table: Any,
) -> float:
    """Radiance of a ray through the sheet, under a light.

    Parameters: value: of ink or paper where it lands; s, along: where it crosses the apex plane; tx, ty: its tangents;
        landed: its place on the page; step: the width that it covers, across; lamp, table: of `lamp_figures`.
    """
    cosine, open_sky = 1.0 / math.sqrt(1.0 + tx * tx + ty * ty), True
    if sheet.radius > 0.0:
        _, hit, depth, met = meet(s, tx, sheet)
        if not met:
            return value
        cosine *= (sheet.radius - depth - tx * hit) / sheet.radius
        open_sky = _sees_sky(hit, depth, tx, sheet)
    passed = _passed(sheet.refraction, cosine)
    radiance: float = value * light_at(s, along, landed, lamp, table, sheet.pitch) * passed / lamp[8]
    if open_sky:
        radiance += lamp[5] * (1.0 - passed)
    if lamp[4] > 0.0:
        radiance += glare_at(s, along, tx, ty, step, sheet, lamp)
    return radiance
