"""The trace through one lenticule: against closed forms, against an independent scalar tracer, and as a table."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from moireid import optics
from moireid.badge import Badge, Lens
from moireid.lenticule import MAX_TANGENT, trace_mm, view_law, view_response
from moireid.sheets import PRODUCTS
from moireid_lab.bench.simulate.reference import Setup, _through_sheet

REAR = 0.52
SHEET = Lens("lenticular", 0.508, 1.0, 1.56)
#: Rays for tests of the physics rather than of the default: the error falls as one over their number.
MANY = 8192


def phase_along(lens: Lens, tangents: np.ndarray, tan_y: float = 0.0, rays: int = 4096) -> np.ndarray:
    """Unwrapped phase over rising tangents, less that of the first; all rays alike."""
    phase = np.unwrap(np.angle(view_response(lens, REAR, tangents, tan_y, rays=rays, fresnel=False)))
    return phase - phase[0]


def slope_near_axis(lens: Lens, tan_y: float = 0.0) -> float:
    """Slope of the phase against tan_x, from a chord over +-0.05."""
    return float(phase_along(lens, np.array([-0.05, 0.05]), tan_y, MANY)[1]) / 0.1


# An independent tracer, one ray at a time.


def trace(lens: Lens, start: float, tan_x: float, tan_y: float) -> float:
    """Where one ray lands, by bisection for the surface and by turning the ray in its plane of incidence.

    Shares nothing with the code under test: no quadratic, no vector form of Snell's law, no neighbour by counting.
    """
    pitch, radius = lens.pitch_mm, lens.radius_mm
    assert radius is not None

    def height_over_surface(depth: float) -> float:
        across = math.remainder(start + tan_x * depth, pitch)
        return radius - math.sqrt(radius**2 - across**2) - depth

    depths = np.linspace(0.0, radius, 20001)
    heights = [height_over_surface(float(d)) for d in depths]
    first = next(k for k in range(len(depths)) if heights[k] <= 0)
    if first == 0:
        depth = 0.0
    else:
        low, high = float(depths[first - 1]), float(depths[first])
        for _ in range(80):
            middle = (low + high) / 2
            low, high = (middle, high) if height_over_surface(middle) > 0 else (low, middle)
        depth = (low + high) / 2
    x = start + tan_x * depth
    outward = np.array([math.remainder(x, pitch), 0.0, -math.sqrt(radius**2 - math.remainder(x, pitch) ** 2)]) / radius
    ray = np.array([tan_x, tan_y, 1.0]) / math.sqrt(1 + tan_x**2 + tan_y**2)
    across = ray - (ray @ outward) * outward
    sine = float(np.linalg.norm(across))
    if sine < 1e-15:
        bent = -outward
    else:
        angle = math.asin(sine / lens.refractive_index)
        bent = math.sin(angle) * across / sine - math.cos(angle) * outward
    return x + bent[0] / bent[2] * (lens.thickness_mm - depth)


@pytest.mark.claim("Rays through a lenticule land where an independent tracer says")
@pytest.mark.parametrize(
    ("start", "tan_x", "tan_y"),
    [
        (0.0, 0.0, 0.0),
        (0.17, 0.0, 0.0),
        (-0.21, 0.3, 0.0),
        (0.11, -0.45, 0.6),
        (0.23, 0.9, -0.35),
        (-0.05, 1.2, 1.1),
        (0.508 * 7 + 0.02, 0.25, -0.8),
        (0.2, 1.7, 0.2),  # passes over its own lenticule and meets the next
        (-0.24, -1.7, -0.4),
    ],
)
def test_rays_land_where_an_independent_tracer_says(start: float, tan_x: float, tan_y: float) -> None:
    """Catches: a wrong root, normal or sign of Snell's law, a neighbour missed, x and y mixed up."""
    sheet = Lens("lenticular", 0.508, 1.0, 1.56, radius_mm=0.31)
    for lens in (SHEET, sheet):
        landed, _ = trace_mm(lens, np.array(start), np.array(tan_x), np.array(tan_y))
        assert float(landed) == pytest.approx(trace(lens, start, tan_x, tan_y), abs=1e-9)


# Closed forms that the trace must meet.


def test_a_lens_of_tiny_pitch_follows_the_paraxial_law() -> None:
    """Catches: g or the slab's law at steep angles in place of g / n where there is no aberration."""
    fine = Lens("lenticular", 0.02, 1.0, 1.56)
    response = view_response(fine, 0.02, np.array([-0.002, 0.002]))
    slope = float(np.angle(response[1] / response[0])) / 0.004
    assert slope == pytest.approx(optics.parallax_slope_rad(1.0 / 1.56, 0.02), rel=1e-3)
    assert abs(response[0]) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(("radius", "thickness", "index"), [(1.0, 1.0, 1.5), (0.8, 0.3, 1.6), (0.5, 2.0, 1.5)])
def test_a_lens_out_of_focus_washes_the_lines_out_by_its_spot(radius: float, thickness: float, index: float) -> None:
    """Catches: the default radius used whatever the badge says.  A pitch p refracted by a surface of power (n-1)/(nR)
    leaves a spot p (1 - g (n-1) / (n R)) wide, whose sinc is the contrast, and whose sign turns the phase by pi."""
    pitch = 0.05
    spot = pitch * (1 - thickness * (index - 1) / (index * radius))
    response = complex(view_response(Lens("lenticular", pitch, thickness, index, radius_mm=radius), pitch, 0.0))
    assert response.real == pytest.approx(float(np.sinc(spot / pitch)), abs=0.003)
    assert response.imag == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("open_fraction", [0.3, 0.5])
def test_a_mask_is_the_slab_law_and_the_sinc_of_its_openings(open_fraction: float) -> None:
    """Catches: the dark part in place of the open one, a mask traced as a lens, tan_y left out."""
    mask = Lens("mask", 0.508, 1.2, 1.49, open_fraction=open_fraction)
    tan_x, tan_y = np.array([-0.9, 0.05, 0.6]), np.array([0.4, 0.0, -1.1])
    response = view_response(mask, REAR, tan_x, tan_y)
    shift = optics.slab_shift_mm(1.2, 1.49, tan_x, tan_y)
    contrast = math.sin(math.pi * open_fraction) / (math.pi * open_fraction)
    assert response == pytest.approx(contrast * np.exp(2j * np.pi * shift / REAR), abs=1e-12)


def test_response_of_a_symmetric_lens_mirrors_in_both_tangents() -> None:
    """Catches: rays that do not stand symmetrically in the pitch, a sign of tan_y that matters."""
    tan_x, tan_y = np.array([0.07, 0.4, 1.1]), np.array([0.9, 0.2, 0.5])
    response = view_response(SHEET, REAR, tan_x, tan_y)
    assert view_response(SHEET, REAR, -tan_x, tan_y) == pytest.approx(np.conj(response), abs=1e-12)
    assert view_response(SHEET, REAR, tan_x, -tan_y) == pytest.approx(response, abs=1e-12)
    assert np.angle(response[0]) > 0  # and the phase rises with tan_x


# What was traced and measured elsewhere (docs/explanation/physics.md).


def test_effective_gap_of_the_prototype() -> None:
    """Catches: g, g / n, or a lens without aberration.  docs/explanation/physics.md: 0.60 mm, 0.941 of g / n."""
    law = view_law(SHEET, REAR)
    assert law.effective_gap_mm(REAR) == pytest.approx(0.60, abs=0.005)
    assert law.effective_gap_mm(REAR) / optics.paraxial_effective_gap_mm(SHEET) == pytest.approx(0.941, abs=0.0005)


@pytest.mark.parametrize(("thickness_mm", "share"), [(1.5, 0.972), (3.0, 0.992)])
def test_spherical_aberration_fades_in_thicker_sheets(thickness_mm: float, share: float) -> None:
    """Catches: the prototype's share of g / n taken for that of every sheet."""
    sheet = Lens("lenticular", 0.508, thickness_mm, 1.56)
    found = view_law(sheet, REAR).effective_gap_mm(REAR) / optics.paraxial_effective_gap_mm(sheet)
    assert found == pytest.approx(share, abs=0.0006)


@pytest.mark.parametrize(("tan_y", "low"), [(0.3, 0.017), (0.6, 0.058), (1.0, 0.114)])
def test_fringes_seen_from_above_move_less(tan_y: float, low: float) -> None:
    """Catches: a law of tan_x alone; the shares are those of docs/explanation/physics.md."""
    turned, front = (np.angle(view_response(SHEET, REAR, 0.05, at, rays=MANY)) for at in (tan_y, 0.0))
    assert 1 - turned / front == pytest.approx(low, abs=0.0005)


def test_cubic_fit_of_the_published_trace() -> None:
    """Catches: a law off by a percent anywhere within 17 degrees; the fit is in docs/explanation/physics.md."""
    tangent = np.linspace(-0.3, 0.3, 61)
    refracted = tangent / np.sqrt(1.56**2 * (1 + tangent**2) - tangent**2)
    fit = 2 * math.pi / REAR * (0.9405 * refracted + 0.4316 * refracted**3)
    assert np.abs(np.angle(view_response(SHEET, REAR, tangent, rays=MANY) * np.exp(-1j * fit))).max() < 0.006
    assert np.abs(view_law(SHEET, REAR).phase_rad(tangent) - fit).max() < 0.002
    far = np.tan(np.radians([30.0, 40.0, 60.0]))
    refracted = far / np.sqrt(1.56**2 * (1 + far**2) - far**2)
    off = view_law(SHEET, REAR).phase_rad(far) - 2 * math.pi / REAR * (0.9405 * refracted + 0.4316 * refracted**3)
    assert off == pytest.approx([0.022, 0.153, 1.31], abs=0.004)


@pytest.mark.parametrize(
    ("degrees", "phase_low", "slope_low"), [(30, 0.033, 0.079), (45, 0.074, 0.188), (60, 0.173, 0.425)]
)
def test_law_bends_with_angle_between_the_straight_line_and_the_slab(
    degrees: int, phase_low: float, slope_low: float
) -> None:
    """Catches: the law of the tangent, and that of the slab; the shares are those of docs/explanation/physics.md."""
    steep = math.tan(math.radians(degrees))
    tangents = np.linspace(0.0, steep, 500)
    phase, around = (
        np.unwrap(np.angle(view_response(SHEET, REAR, some, rays=4096))) for some in (tangents, np.array([-0.05, 0.05]))
    )
    phase, line = phase - phase[0], (around[1] - around[0]) / 0.1
    assert 1 - phase[-1] / (line * steep) == pytest.approx(phase_low, abs=0.001)
    # A chord over a hundredth.
    chord = (phase[-1] - phase[-6]) / (tangents[-1] - tangents[-6])
    assert 1 - chord / line == pytest.approx(slope_low, abs=0.005)
    slab = float(optics.slab_shift_mm(1.0, 1.56, steep)) / (steep / 1.56)
    assert slab < phase[-1] / (line * steep) < 1


def test_contrast_at_60_degrees_is_a_good_third_of_that_on_the_axis() -> None:
    """Catches: a response that is normalised to 1 and so loses the contrast."""
    tangents = np.array([0.0, math.tan(math.radians(60))])
    axis, steep = np.abs(view_response(SHEET, REAR, tangents, rays=4096))
    assert steep / axis == pytest.approx(0.37, abs=0.004)


@pytest.mark.parametrize(("tan_x", "turn"), [(0.3, 0.003), (0.75, 0.018), (1.2, 0.0)])
def test_rays_count_by_what_passes_the_lens(tan_x: float, turn: float) -> None:
    """Catches: Fresnel's share left out, taken at the page's normal instead of the lens's, or of one polarisation."""
    start = ((np.arange(MANY) + 0.5) / MANY - 0.5) * SHEET.pitch_mm
    landed, cosine = trace_mm(SHEET, start, np.array(tan_x), np.array(0.4))
    outer = np.arccos(cosine)
    inner = np.arcsin(np.sin(outer) / SHEET.refractive_index)
    # Fresnel's own form, of angles.
    across = np.sin(outer - inner) ** 2 / np.sin(outer + inner) ** 2
    along = np.tan(outer - inner) ** 2 / np.tan(outer + inner) ** 2
    seen = np.average(np.exp(2j * math.pi * landed / REAR), weights=1 - (across + along) / 2)
    found = complex(view_response(SHEET, REAR, tan_x, 0.4, rays=MANY))
    assert found == pytest.approx(seen, abs=1e-9)
    alike = complex(view_response(SHEET, REAR, tan_x, 0.4, rays=MANY, fresnel=False))
    assert np.angle(found / alike) == pytest.approx(turn, abs=0.006)


def test_the_share_that_passes_changes_the_phase_little_within_45_degrees() -> None:
    """Catches: another figure than docs/decisions/optics.md has for what the fast renderer leaves out."""
    tan_x, tan_y = (one.ravel() for one in np.meshgrid(np.linspace(0, 1, 26), np.linspace(0, 1, 11)))
    tan_x, tan_y = tan_x[(near := np.hypot(tan_x, tan_y) <= 1)], tan_y[near]
    most = []
    for sheet in (SHEET, *PRODUCTS.values()):
        seen, alike = (
            view_response(sheet, 1.024 * sheet.pitch_mm, tan_x, tan_y, rays=1024, fresnel=fresnel)
            for fresnel in (True, False)
        )
        most.append(np.abs(np.angle(seen / alike)).max())
    assert max(most) == pytest.approx(0.027, abs=0.0005)


# The number of rays, and the table.


def test_table_agrees_with_the_trace(rng: np.random.Generator) -> None:
    """Catches: axes swapped, a table that is not even in tan_y, or unwrapped to another branch.

    Both are cut off by the same 512 rays, each at its own places: 0.004 rad at worst within 45 degrees.
    """
    law = view_law(SHEET, REAR)
    tan_x, tan_y = rng.uniform(-1, 1, 400), rng.uniform(-1, 1, 400)
    direct = view_response(SHEET, REAR, tan_x, tan_y)
    assert np.abs(np.angle(np.exp(1j * law.phase_rad(tan_x, tan_y)) / direct)).max() < 0.007


@pytest.mark.parametrize("thickness_mm", [0.75, 1.0, 1.5, 2.0])
def test_the_table_s_last_degrees_are_as_an_outside_tracer_has_them(prototype: Badge, thickness_mm: float) -> None:
    """Catches: a table that reaches beyond what one lens explains, or that holds its edge within its own range.

    The tracer intersects all lenses near a ray, in space, and says which rays leave the sheet by a neighbour: none may.
    """
    lens = Lens("lenticular", 0.508, thickness_mm, 1.56)
    setup, count = Setup(replace(prototype, lens=lens)), 4096
    start = ((np.arange(count) + 0.5) / count - 0.5) * lens.pitch_mm
    top = np.stack([start, np.zeros(count), np.full(count, -thickness_mm)], axis=1)
    for tan_x in (1.2, 1.5, 1.75, MAX_TANGENT):
        for tan_y in (0.0, 0.5, 1.5):
            way = np.array([tan_x, tan_y, 1.0]) / math.sqrt(1 + tan_x**2 + tan_y**2)
            landed, escapes = _through_sheet(setup, prototype.gratings[0], top, np.tile(way, (count, 1)))
            assert not escapes.any() and np.isfinite(landed).all()
            passed = optics.passed_share(1.56, trace_mm(lens, start, np.array(tan_x), np.array(tan_y))[1])
            seen = np.average(np.exp(2j * math.pi * landed[:, 0] / REAR), weights=passed)
            apart = np.angle(seen * np.exp(-1j * view_law(lens, REAR).phase_rad(tan_x, tan_y)))
            assert abs(apart) < 0.015, (tan_x, tan_y)


def test_table_is_unwrapped_odd_and_zero_on_the_axis() -> None:
    """Catches: a phase between -pi and pi, which jumps where the law has long passed it (34 degrees)."""
    law = view_law(SHEET, REAR)
    tangent = np.linspace(-1.4, 1.4, 401)
    phase = law.phase_rad(tangent, 0.2)
    assert np.all(np.diff(phase) > 0)
    assert phase == pytest.approx(-phase[::-1], abs=1e-9)
    assert phase[-1] > 2 * math.pi
    assert float(law.phase_rad(0.0, 0.7)) == pytest.approx(0.0, abs=1e-9)


def test_table_of_a_lens_beyond_its_focus_stays_on_one_branch() -> None:
    """Catches: on the axis such a lens shows the lines turned by pi, which the angle's two ends share: a column of the
    table at +pi next to one at -pi, with nonsense in between."""
    lens = Lens("lenticular", 0.508, 3.0, 1.56, radius_mm=0.5)
    tan_x, tan_y = np.array([-0.05, 0.0, 0.05])[:, None], np.linspace(0.0, 0.5, 41)
    direct = view_response(lens, REAR, tan_x, tan_y)
    assert direct[1].real.max() < -0.1
    law = view_law(lens, REAR)
    # Cubic interpolation over columns 0.125 apart costs 0.1 rad here, where the contrast is a tenth.
    assert np.abs(np.angle(np.exp(1j * law.phase_rad(tan_x, tan_y)) / direct)).max() < 0.3
