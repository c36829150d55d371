"""The light's bands on the page, and the lenses' glare, without Mitsuba.  Each test names what it would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from moireid.badge import Badge, Lens
from moireid.errors import SpecError
from moireid.lenticule import trace_mm
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.light import DiscLight, light_named, light_table, passed_share, straight_share
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant, Scene

SHEET = Lens("lenticular", 0.508, 1.0, 1.56)
#: A round box of eight degrees, 40 degrees to the right and a little up; all the light there is.
BOX = DiscLight((964.0, -300.0, -1149.0), 211.5, 1.0)


def straight_at(distance_mm: float = 1000.0) -> Instant:
    pose = Poses(np.array([[0.0, 0.0, -distance_mm]]), np.eye(3)[None])
    return Instant(pose, pose, pose.camera_mm[0])


def traced_back(lens: Lens, light: DiscLight, bins: int, rays: int, seed: int) -> np.ndarray:
    """The same light on the page by rays that start there and look for the disc: nothing of `lenticule` in it."""
    rng = np.random.default_rng(seed)
    pitch, g, n, radius = lens.pitch_mm, lens.thickness_mm, lens.refractive_index, float(lens.radius_mm or 0)
    toward = np.array(light.place_mm) / np.linalg.norm(light.place_mm)
    start = (rng.random(rays) - 0.5) * pitch
    half = 1.05 * math.sin(light.half_angle_rad) / n
    dx, dy = rng.uniform(-0.98, 0.98, rays), toward[1] / n + rng.uniform(-half, half, rays)
    sound = dx**2 + dy**2 < 0.999
    dz = -np.sqrt(np.where(sound, 1 - dx**2 - dy**2, 1.0))
    way, hit = np.full(rays, np.inf), np.zeros(rays)
    for lenticule in range(-12, 13):
        x, z = start - lenticule * pitch, g - radius
        a, b, c = dx**2 + dz**2, x * dx + z * dz, x**2 + z**2 - radius**2
        length = (-b + np.sqrt(np.maximum(b**2 - a * c, 0))) / a
        leaves = (b**2 > a * c) & (np.abs(x + length * dx) <= pitch / 2) & (z + length * dz < 0) & (length < way)
        way, hit = np.where(leaves, length, way), np.where(leaves, x + length * dx, hit)
    nx, nz = hit / radius, -np.sqrt(1 - (hit / radius) ** 2)
    inner = dx * nx + dz * nz
    sound &= np.isfinite(way) & (n**2 * (1 - inner**2) < 1) & (inner > 0)
    outer = np.sqrt(np.where(sound, 1 - n**2 * (1 - inner**2), 1.0))
    out = np.stack([n * dx + (outer - n * inner) * nx, n * dy, n * dz + (outer - n * inner) * nz])
    sound &= toward @ out > math.cos(light.half_angle_rad)
    share = np.where(sound, passed_share(n, outer), 0.0) * n**2 * 1.96 * 2 * half
    whole = math.pi * math.sin(light.half_angle_rad) ** 2 * -toward[2] * straight_share(n)
    return np.bincount((start / pitch % 1 * bins).astype(int), share, bins) / (rays / bins) / whole


def test_the_bands_agree_with_rays_traced_back_from_the_page():
    """Catches: a light from the other side, a lost Fresnel share, a wrong scale, bins that are shifted.

    The rays' own noise is 2 % of the mean; the light on the page runs from 0.1 to 2.2 of it.
    """
    _, places, disc = light_table(SHEET, BOX, (-14.0, 14.0))
    middle = (disc[(len(places) - 1) // 2] + disc[len(places) // 2]) / 2
    # Bins of the table are centred on whole numbers, those of the rays on halves.
    of_table = ((middle + np.roll(middle, -1)) / 2).reshape(16, -1).mean(axis=1)
    back = [traced_back(SHEET, BOX, 16, 400_000, seed) for seed in (1, 2)]
    noise = np.std(back[0] - back[1]) / math.sqrt(2)
    assert noise < 0.04
    assert of_table.max() > 15 * of_table.min()
    np.testing.assert_allclose(of_table, np.mean(back, axis=0), atol=4 * noise)


@pytest.mark.parametrize(
    ("name", "near", "within_45", "most"), [("window", 0.03, 0.25, 0.72), ("lamp", 0.04, 0.59, 1.76)]
)
def test_a_light_moves_the_phase_most_from_its_far_side(name: str, near: float, within_45: float, most: float):
    """Catches: bands that weigh rays of the wrong place; the figures are those of docs/explanation/physics.md."""
    sky, places, disc = light_table(SHEET, light_named(name), (-70.0, 70.0))
    on_page = sky + disc[len(places) // 2]
    degrees = np.arange(-60.0, 60.5, 0.5)
    start = ((np.arange(4096) + 0.5) / 4096 - 0.5) * SHEET.pitch_mm
    landed, cosine = trace_mm(SHEET, start, np.tan(np.radians(degrees))[:, None], np.zeros((len(degrees), 1)))
    bins = np.arange(len(on_page) + 1) / len(on_page) * SHEET.pitch_mm
    light = np.interp(landed % SHEET.pitch_mm, bins, np.append(on_page, on_page[0]))
    even = passed_share(SHEET.refractive_index, cosine) * np.exp(2j * math.pi * landed / 0.52)
    moved = np.abs(np.angle((light * even).sum(axis=1) / even.sum(axis=1)))
    assert moved[np.abs(degrees) <= 15].max() == pytest.approx(near, abs=0.005)
    assert moved[np.abs(degrees) <= 45].max() == pytest.approx(within_45, abs=0.01)
    assert moved.max() == pytest.approx(most, abs=0.01) and degrees[moved.argmax()] > 50


@pytest.mark.slow
def test_glare_is_a_streak_across_the_lenses_where_a_mirror_would_show_the_light(prototype: Badge):
    """Catches: glare that is spread along the lenses, at the light's own height, or brighter than the light."""
    # A lamp 1 m away and 60 mm up, seen from 1 m: mirrored half way, 30 mm above the middle.
    lamp = DiscLight((500.0, -60.0, -1000.0), 12.0, 0.5)
    plain, shining = (
        AnalyticRenderer(Scene(prototype, light=light), rays=(16, 4)).render(straight_at())
        for light in (replace(lamp, share=0.0), lamp)
    )
    assert plain is not None and shining is not None
    rows = shining.radiance.max(axis=1) - plain.radiance.max(axis=1)
    place_mm = (np.arange(len(rows)) + shining.top - 539.5) / 1.45
    assert place_mm[rows.argmax()] == pytest.approx(-30.0, abs=8.0)
    assert np.ptp(place_mm[rows > 0.2 * rows.max()]) < 30.0
    streak = shining.radiance[rows.argmax()]
    assert np.mean(streak > 1.0) > 0.3
    assert streak.max() < lamp.radiance


def test_an_unknown_light_lists_those_there_are():
    """Catches: a traceback for a name that is none."""
    with pytest.raises(SpecError, match="softbox"):
        light_named("moon")
