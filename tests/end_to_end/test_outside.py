"""The outside tracer of `benchmarks/outside` obeys published optics, and shares nothing with the simulator."""

from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
PITCH, THICKNESS, INDEX, LINES = 0.508, 1.0, 1.56, 0.52
RADIUS = THICKNESS * (INDEX - 1) / INDEX


@pytest.fixture(autouse=True)
def _found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def test_it_imports_nothing_of_ours() -> None:
    """Catches: a tracer that borrows the law, the lens or the renderer that it is to test."""
    for path in (BENCHMARKS / "outside").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith("moireid")], path.name


def _phase_rad(tangent: float, slope_along: float = 0.0) -> float:
    """Fringe phase of a pixel that covers whole lenses, from a ray of that slope through each part of a lens."""
    from outside.lens import through_cylinders

    count = 4000
    landed, along, share = (np.arange(count) + 0.5) / count * PITCH, np.zeros(count), np.empty(count)
    slopes = np.full(count, tangent), np.full(count, slope_along)
    through_cylinders(count, landed, along, *slopes, share, 0.0, PITCH, RADIUS, THICKNESS, INDEX)
    return float(np.angle(np.sum(share * np.exp(2j * math.pi * (landed - PITCH / 2) / LINES))))


def test_a_lens_bends_as_an_independent_tracer_found() -> None:
    """The law (2 pi g / p)(0.9405 t + 0.4316 t^3), t the refracted tangent, fitted elsewhere for g = 1, n = 1.56; its
    slope is 0.60 mm.  Catches: a wrong normal, index, radius or sign, and a thin lens or a slab in place of a lens."""
    for tangent in (-0.3, -0.15, 0.05, 0.15, 0.3):
        t = math.tan(math.asin(math.sin(math.atan(tangent)) / INDEX))
        expected = 2 * math.pi * THICKNESS / LINES * (0.9405 * t + 0.4316 * t**3)
        assert _phase_rad(tangent) == pytest.approx(expected, abs=0.003)
    assert _phase_rad(0.01) * LINES / (2 * math.pi * 0.01) == pytest.approx(0.60, abs=0.005)
    # Slopes along the lenses make the path longer and the fringes slower: 1.8 % at 0.3.
    assert _phase_rad(0.05, 0.3) / _phase_rad(0.05) == pytest.approx(1 - 0.018, abs=0.004)


def test_many_rays_at_once_land_where_each_does() -> None:
    """Catches: a fast way that loses rays which pass over the top of a lens into the next."""
    from outside.lens import through_cylinder, through_cylinders

    rng = np.random.default_rng(5)
    s, t, ds, dt = rng.uniform(-9, 9, 500), np.zeros(500), rng.uniform(-0.8, 0.8, 500), rng.uniform(-0.5, 0.5, 500)
    # Half circles stand highest, so that most rays pass over to a neighbour.
    figures = 0.1, 0.3387, 0.17018, 0.4572, 1.575
    each = np.array([through_cylinder(*ray, *figures) for ray in zip(s, ds, dt, strict=True)])
    share = np.empty(500)
    through_cylinders(500, s, t, ds, dt, share, *figures)
    assert np.stack([s, t, share], axis=1) == pytest.approx(each, abs=1e-9)


def test_a_round_lens_is_the_cylinder_along_its_axis() -> None:
    """Catches: a sphere with another radius or grid, and a ray that is lost between cells."""
    from outside.lens import through_cylinder, through_sphere

    for entry, tangent in ((0.1, 0.0), (0.3, 0.2), (0.5, 0.3), (0.02, -0.3)):
        flat = through_cylinder(entry, tangent, 0.0, 0.0, PITCH, 0.4, THICKNESS, INDEX)
        middle = PITCH / 2
        across = through_sphere(entry, middle, tangent, 0.0, 0.0, PITCH, 0.4, THICKNESS, INDEX)
        along = through_sphere(middle, entry, 0.0, tangent, 0.0, PITCH, 0.4, THICKNESS, INDEX)
        assert across == pytest.approx((flat[0], middle, flat[2]), abs=1e-9)
        assert along == pytest.approx((middle, flat[0], flat[2]), abs=1e-9)


def _striped_page():  # type: ignore[no-untyped-def]
    """A board of 120 x 60 mm with plain lines under a sheet of 100 x 40 mm."""
    from outside.page import Lens, Sheet, from_raster

    px_per_mm = 1200 / 25.4
    x = (np.arange(round(120 * px_per_mm)) + 0.5) / px_per_mm - 60
    lines = 255 * ((x / LINES) % 1 > 0.5)
    grey = np.full((round(60 * px_per_mm), len(x)), 255, np.uint8)
    rows = slice(round(10 * px_per_mm), round(50 * px_per_mm))
    grey[rows] = lines.astype(np.uint8)
    grey[rows, np.abs(x) > 50] = 255
    lens = Lens(PITCH, THICKNESS, INDEX, RADIUS, round=False)
    return from_raster(grey, (px_per_mm, px_per_mm), (120.0, 60.0), lens, (Sheet((0.0, 0.0), (50.0, 20.0), 0.0),))


def _tracer(tangent: float, forge: str | None = None):  # type: ignore[no-untyped-def]
    """A still camera at 1 m, at that tangent of view and looking straight ahead."""
    from outside.build import built
    from outside.camera import Camera
    from outside.film import Shoot, Tracer
    from outside.motion import Course

    def still(place: tuple[float, ...]):  # type: ignore[no-untyped-def]
        return lambda t: np.tile(np.array([0.0, 0.0, 0.0, *place]), (len(t), 1))

    page = _striped_page()
    camera = Camera((1280, 720), 1440.0, (640.0, 360.0))
    course = Course("still", still((0.0, 0.0, 0.0)), still((1000 * tangent, 0.0, -1000.0)))
    return Tracer(page, built(page), camera, course, Shoot(30, 30, seed=3, forge=forge))


@pytest.mark.slow
@pytest.mark.parametrize("tangent", [0.0, 0.08, 0.16])
def test_fringes_of_a_frame_lie_where_the_law_says(tangent: float) -> None:
    """Phase 2 pi x (1/p_r - 1/p_f) + that of one lens at the slope (x - Cx) / Cz, on the plane of the crowns.

    Catches: a camera, a pose, a place of the sheet or a raster that is off, mirrored or of another scale.
    """
    light = _tracer(tangent).frame(0)
    depth = 1000 - THICKNESS
    x = (np.arange(1280) + 0.5 - 640) / 1440 * depth + 1000 * tangent
    inside = np.abs(x) < 44
    x, seen = x[inside], light[340:380].mean(axis=0)[inside]
    slopes = (x - 1000 * tangent) / depth
    bent = np.polyval(np.polyfit(grid := np.linspace(-0.25, 0.25, 11), [_phase_rad(s) for s in grid], 3), slopes)
    # Lines are bright in the second half of a period from x = 0, where two lenses meet.
    law = 2 * math.pi * x * (1 / LINES - 1 / PITCH) + bent + math.pi + math.pi / 2
    window = np.hanning(len(x)) * np.exp(-1j * law)
    found = np.sum(window * (seen - seen.mean()))
    assert np.angle(found) == pytest.approx(0.0, abs=0.03)
    assert 2 * abs(found) / np.sum(np.hanning(len(x))) > 0.3


@pytest.mark.slow
@pytest.mark.parametrize("forge", ["reversed", "gain_low", "gain_high", "late"])
def test_a_lie_is_told_by_the_lenses_alone(forge: str) -> None:
    """Catches: a forgery that moves the markers too, or none at all.  A still camera's `late` is the truth."""
    true, lied = _tracer(0.2).frame(1).copy(), _tracer(0.2, forge).frame(1)
    differs = np.abs(true - lied) > 0.02
    assert differs.any() == (forge != "late")
    px_per_mm = 1440 / (1000 - THICKNESS)
    rows, columns = np.nonzero(differs)
    assert np.all(np.abs(rows + 0.5 - 360) < 20 * px_per_mm + 2)
    assert np.all(np.abs(columns + 0.5 - 640 + 200 * px_per_mm) < 50 * px_per_mm + 2)
