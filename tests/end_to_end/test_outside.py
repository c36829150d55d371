"""The outside tracer of `benchmarks/outside` obeys published optics, and shares nothing with the simulator."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from moireid.badge import Lens
from moireid.lenticule import critical_tangent, view_law, view_response

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
PITCH, THICKNESS, INDEX, LINES = 0.508, 1.0, 1.56, 0.52
RADIUS = THICKNESS * (INDEX - 1) / INDEX


@pytest.fixture(autouse=True)
def _found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


@pytest.mark.claim("The outside tracer shares no line with moireid")
def test_it_imports_nothing_of_ours() -> None:
    """Catches: a tracer that borrows the law, the lens or the renderer that it is to test."""
    for path in (BENCHMARKS / "outside").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith("moireid")], path.name


def _phase_rad(tangent: float, slope_along: float = 0.0, air_mm: float = 0.0) -> float:
    """Fringe phase of a pixel that covers whole lenses, from a ray of that slope through each part of a lens."""
    from outside.lens import through_cylinders

    count = 4000
    landed, along, share = (np.arange(count) + 0.5) / count * PITCH, np.zeros(count), np.empty(count)
    slopes = np.full(count, tangent), np.full(count, slope_along)
    through_cylinders(count, landed, along, *slopes, share, 0.0, PITCH, RADIUS, THICKNESS, INDEX, air_mm)
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


@pytest.mark.claim("Of a sheet laid on, rays beyond the critical angle are lost, as an outside tracer has it")
@pytest.mark.parametrize("tangent", [0.5, 0.7, 0.8, 0.95])
def test_air_hides_a_part_of_each_lens_as_an_independent_tracer_found(tangent: float) -> None:
    """Catches: rays that see the page beyond the critical angle; a law that leaves the glued one too early or late."""
    lens = Lens("lenticular", PITCH, THICKNESS, INDEX)
    for air_mm in (1e-6, 0.02):
        seen = complex(view_response(lens, LINES, tangent, 0.1, air_mm=air_mm, rays=4000))
        assert np.angle(seen * np.exp(-1j * _phase_rad(tangent, 0.1, air_mm))) == pytest.approx(0.0, abs=0.004)
    glued, laid = (float(view_law(lens, LINES, laid=laid).phase_rad(tangent, 0.1)) for laid in (False, True))
    assert (abs(laid - glued) < 1e-3) == (tangent < critical_tangent(lens))


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
    lens = Lens(PITCH, THICKNESS, INDEX, RADIUS)
    return from_raster(grey, (px_per_mm, px_per_mm), (120.0, 60.0), lens, (Sheet((0.0, 0.0), (50.0, 20.0), 0.0),))


def _tracer(tangent: float, forge: str | None = None, lamps=None, **changed):  # type: ignore[no-untyped-def]
    """A still camera at 1 m, at that tangent of view and looking straight ahead; changed: of the page."""
    from outside.build import built
    from outside.camera import Camera
    from outside.film import Shoot, Tracer
    from outside.motion import Course

    def still(place: tuple[float, ...]):  # type: ignore[no-untyped-def]
        return lambda t: np.tile(np.array([0.0, 0.0, 0.0, *place]), (len(t), 1))

    page = replace(_striped_page(), **changed)
    camera = Camera((1280, 720), 1440.0, (640.0, 360.0))
    course = Course("still", still((0.0, 0.0, 0.0)), still((1000 * tangent, 0.0, -1000.0)))
    return Tracer(page, built(page), camera, course, Shoot(30, 30, seed=3, forge=forge, lamps=lamps))


@pytest.mark.claim("The outside tracer's fringes lie where the law says")
@pytest.mark.slow
@pytest.mark.parametrize("tangent", [0.0, 0.08, 0.16])
def test_fringes_of_a_frame_lie_where_the_law_says(tangent: float) -> None:
    """Phase 2 pi x (1/p_r - 1/p_f) + that of one lens at the slope (x - Cx) / Cz, on the plane of the crowns.

    Catches: a camera, a pose, a place of the sheet or a raster that is off, mirrored or of another scale.
    """
    light = _tracer(tangent).frame(0)
    depth = 1000 - THICKNESS
    x = (np.arange(1280) + 0.5 - 640) / 1440 * depth + 1000 * tangent
    _check_law(light, x, (x - 1000 * tangent) / depth)


def _check_law(light, x, slopes):  # type: ignore[no-untyped-def]
    """The phase of the fringes in the middle rows of a frame; x: place on the crowns of each column, mm."""
    inside = np.abs(x) < 44
    x, seen = x[inside], light[340:380].mean(axis=0)[inside]
    bent = np.interp(slopes[inside], grid := np.linspace(-0.5, 0.5, 201), [_phase_rad(s) for s in grid])
    # Lines are bright in the second half of a period from x = 0, where two lenses meet.
    law = 2 * math.pi * x * (1 / LINES - 1 / PITCH) + bent + math.pi + math.pi / 2
    window = np.hanning(len(x)) * np.exp(-1j * law)
    found = np.sum(window * (seen - seen.mean()))
    assert np.angle(found) == pytest.approx(0.0, abs=0.03)
    assert 2 * abs(found) / np.sum(np.hanning(len(x))) > 0.3


@pytest.mark.slow
@pytest.mark.parametrize("radius_mm", [350.0, -350.0])
def test_fringes_of_a_bent_badge_lie_where_the_law_says(radius_mm: float) -> None:
    """Rays met with a circle in closed form; a place is its arc, and the slope is against the circle's normal there.

    Catches: a badge that is bent the other way, chords for arcs, and lenses that are seen as on a flat badge.
    """
    from outside.bend import Bend

    light = _tracer(0.0, bend=Bend(1 / radius_mm)).frame(0)
    m = (np.arange(1280) + 0.5 - 640) / 1440
    # x = m (z + 1000) and x^2 + (z - R)^2 = R^2.
    b, c = 1000 * m * m - radius_mm, (1000 * m) ** 2
    z = c / (-b + np.sign(radius_mm) * np.sqrt(np.maximum(b * b - (1 + m * m) * c, 0)))
    theta = np.arcsin(np.clip(m * (z + 1000) / radius_mm, -1, 1))
    slopes = np.tan(np.arctan(m) + theta)
    _check_law(light, radius_mm * theta - THICKNESS * slopes, slopes)


def test_an_ellipse_brings_parallel_light_to_one_point() -> None:
    """At radius g (n - 1) / n and conic constant -1 / n^2, all rays land in the middle (Descartes); a circle's do not.

    Catches: a constant of the wrong sign or place, and the normal of a circle on an ellipse.
    """
    from outside.lens import through_cylinder

    entries = np.linspace(0.02, PITCH - 0.02, 9)
    conic = -1 / INDEX**2
    landed = [through_cylinder(s, 0.0, 0.0, 0.0, PITCH, RADIUS, THICKNESS, INDEX, 0.0, conic)[0] for s in entries]
    assert landed == pytest.approx([PITCH / 2] * 9, abs=1e-9)
    assert abs(through_cylinder(0.02, 0.0, 0.0, 0.0, PITCH, RADIUS, THICKNESS, INDEX)[0] - PITCH / 2) > 0.02


@pytest.mark.slow
def test_light_and_air_of_a_frame_are_those_of_the_closed_forms() -> None:
    """Catches: a lamp or a map of air that is placed elsewhere, mirrored, or over the wall too."""
    from outside.lamps import Lamps

    plain = _tracer(0.0).frame(0).copy()
    lit = _tracer(0.0, lamps=Lamps(1.0, (300.0, 0.0, -400.0), 0.0, (0.0, 0.0, -1.0))).frame(0)
    # White paper 55 mm to either side, and the wall beyond.
    left, right, wall = ((360, 640 + round(1.44 * x)) for x in (-55, 55, -100))
    for place, x in ((left, -55), (right, 55)):
        expected = 500**3 / ((300 - x) ** 2 + 400**2) ** 1.5
        assert lit[place] / plain[place] == pytest.approx(expected, rel=0.01)
    assert lit[wall] == plain[wall]
    lens = replace(_striped_page().lens, air_mm=0.05)
    mapped = _tracer(0.1, air_mm=np.full((60, 120), 0.05, np.float32)).frame(0).copy()
    assert mapped == pytest.approx(_tracer(0.1, lens=lens).frame(0), abs=1e-6)
    half = np.where(np.arange(120) < 60, 0.0, 0.05).astype(np.float32) * np.ones((60, 1), np.float32)
    differs = np.abs(_tracer(0.1, air_mm=half).frame(0) - _tracer(0.1).frame(0)).max(axis=0) > 0.05
    middle = 640 - 144
    assert differs[middle + 10 : middle + 60].any()
    assert not differs[: middle - 10].any()


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
