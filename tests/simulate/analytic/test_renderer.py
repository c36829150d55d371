"""The fast renderer, held against the closed form of the optics.  Each test names what it would catch.

Frames are those of `kit.seen_gratings`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from kit.seen_gratings import (
    CAMERA,
    instant,
    law_phase,
    left_over,
    line_phase,
    middle,
    render,
    steepness,
    transposed,
    view,
)
from moireid import optics
from moireid.badge import Badge, load_badge
from moireid.lenticule import RAYS, view_law, view_response
from moireid.sheets import effective_gap_mm
from moireid.simulate.analytic.traced_sheet import land, sheet_as_built
from moireid.simulate.build import Build
from moireid.simulate.scene import Camera, Scene

# Against the closed form.


@pytest.mark.parametrize(("distance_mm", "limit_rad"), [(1001.0, 0.005), (2001.0, 0.02)])
@pytest.mark.parametrize("u", [0.0, 0.3, -0.3])
def test_fringe_phase_follows_the_view_law(prototype, distance_mm, limit_rad, u):
    """Catches: the sign of u; lenses on the page's plane; a shift of g/n; edges taken for middles; a dropped g/D.

    The limits are the picture's, not the law's: at 2 m a pixel covers 2.7 lenses, whose pitch aliases against it.
    """
    camera = (u * (distance_mm - 1), 40.0, -distance_mm)
    seen = view(prototype, camera)
    assert abs(left_over(seen, law_phase(prototype, seen, camera))) < limit_rad


def test_a_line_mask_in_air_follows_the_straight_ray(films):
    """Catches: a mask that is refracted; openings and bars exchanged (half a fringe); the lens's law used for it."""
    mask = load_badge(films / "badge_mask.json")
    assert mask.lens.refractive_index == 1.0
    for u in (0.0, 0.4, -0.25):
        camera = (u * 1400.0, 30.0, -1401.0)
        seen = view(mask, camera)
        tangent = (seen.x_mm - camera[0]) / 1400.0
        cell = mask.gratings[0].cells[0]
        beat = 2 * math.pi * seen.x_mm * (1 / cell.pitch_mm - 1 / mask.lens.pitch_mm)
        straight = beat + 2 * math.pi * mask.lens.thickness_mm * tangent / cell.pitch_mm + line_phase(mask)
        # At 1.4 m a pixel covers 1.9 openings; the beat of pixels against openings leaves some hundredths.
        assert abs(left_over(seen, np.broadcast_to(straight, seen.brightness.shape))) < 0.03


def test_a_mask_under_glass_follows_the_slab_law(films):
    """Catches: a slab without Snell; tan / n in place of the exact law (0.35 rad apart at this angle)."""
    mask = load_badge(films / "badge_mask.json")
    mask = replace(mask, lens=replace(mask.lens, refractive_index=1.5, thickness_mm=2.0))
    camera = (0.6 * 1000.0, 200.0, -1002.0)
    seen = view(mask, camera)
    tan_x, tan_y = (seen.x_mm[None, :] - camera[0]) / 1000.0, (seen.y_mm[:, None] - camera[1]) / 1000.0
    cell = mask.gratings[0].cells[0]
    shift = optics.slab_shift_mm(2.0, 1.5, tan_x, tan_y)
    beat = 2 * math.pi * seen.x_mm * (1 / cell.pitch_mm - 1 / mask.lens.pitch_mm)
    phase = beat[None, :] + 2 * math.pi * shift / cell.pitch_mm + line_phase(mask)
    assert abs(left_over(seen, phase)) < 0.03


def test_a_sheet_laid_over_by_a_tenth_turns_the_phase(prototype):
    """Catches: the offset's sign; an offset of the page; 2 pi d / p_r in place of 2 pi d / p_f (0.03 rad)."""
    camera = (100.0, 0.0, -1001.0)
    seen = view(prototype, camera, Build(lens_offset_mm=0.1))
    turned = left_over(seen, law_phase(prototype, seen, camera))
    assert turned == pytest.approx(2 * math.pi * 0.1 / prototype.lens.pitch_mm, abs=0.006)


def test_print_scale_changes_the_beat(prototype):
    """Catches: scale applied to the lens; 1/s for s; a scale that forgets the lines.  0.3 % is 12.7 % of this beat."""
    camera, scale = (0.0, 0.0, -1001.0), 1.003
    seen = view(prototype, camera, Build(print_scale=scale))
    pitch = prototype.gratings[0].cells[0].pitch_mm
    more = 2 * math.pi * (1 / (scale * pitch) - 1 / pitch)
    assert steepness(seen, law_phase(prototype, seen, camera), axis=1) == pytest.approx(more, rel=0.02)


@pytest.mark.parametrize("degrees", [0.25, -0.1])
def test_a_twisted_sheet_tilts_the_fringes(prototype, degrees):
    """Catches: the sense of the twist; degrees; a twist of the page.  2 pi a / p_f per mm, falling along y."""
    camera, twist = (0.0, 0.0, -1001.0), math.radians(degrees)
    seen = view(prototype, camera, Build(twist_rad=twist))
    tilt = steepness(seen, law_phase(prototype, seen, camera), axis=0)
    assert tilt == pytest.approx(-2 * math.pi * twist / prototype.lens.pitch_mm, rel=0.02)


def test_a_thin_sheet_moves_fringes_by_its_own_law(prototype):
    """Catches: a thickness that stays the design's, or lenses that do not come nearer to the page with it."""
    camera, build = (250.0, 0.0, -1001.0), Build(thickness_ratio=0.75)
    thin = replace(prototype, lens=Scene(prototype, build).lens)
    seen = view(prototype, camera, build)
    assert thin.lens.thickness_mm == pytest.approx(0.75 * prototype.lens.thickness_mm)
    assert abs(left_over(seen, law_phase(thin, seen, camera))) < 0.02
    assert abs(left_over(seen, law_phase(prototype, seen, camera))) > 0.3


def test_a_gap_moves_fringes_as_traced(prototype):
    """Catches: lenses that the gap does not lift; a gap thought of glass, which would add two thirds of it."""
    camera, gap, pitch = (150.0, 0.0, -1001.0), 0.05, prototype.gratings[0].cells[0].pitch_mm
    seen = view(prototype, camera, Build(air_gap_mm=gap))
    raised = (camera[0], camera[1], camera[2] + gap)
    tan_x = (seen.x_mm - camera[0]) / (1000.0 - gap)
    traced = [effective_gap_mm(prototype.lens, pitch, air) for air in (0.0, gap)]
    more = 2 * math.pi * (traced[1] - traced[0]) * tan_x / pitch
    assert abs(left_over(seen, law_phase(prototype, seen, raised) + more)) < 0.01
    assert abs(left_over(seen, law_phase(prototype, seen, raised))) > 0.08


@pytest.mark.parametrize("tan_x", [0.5, 0.9, -1.6])
def test_air_hides_the_part_of_each_lens_that_the_law_of_a_laid_sheet_says(prototype, tan_x):
    """Catches: rays beyond the critical angle that see the page."""
    sheet, pitch = sheet_as_built(Scene(prototype, Build(air_gap_mm=0.02))), prototype.gratings[0].cells[0].pitch_mm
    starts = ((np.arange(RAYS) + 0.5) / RAYS - 0.5) * sheet.pitch
    landed, _, sees = np.array([land(start, 0.0, tan_x, 0.3, sheet.air, sheet) for start in starts]).T
    light = np.where(sees, np.exp(2j * math.pi * landed / pitch), 0.0).mean()
    law = view_response(prototype.lens, pitch, tan_x, 0.3, air_mm=0.02, fresnel=False)
    assert light == pytest.approx(complex(law), abs=1e-6) and (sees == 0).any() == (abs(tan_x) > 0.8)


def test_a_bow_turns_the_lenses_at_the_edges_outwards(prototype):
    """Catches: the bow's sense; a page that bends and a sheet that does not.  g_eff / p_r turns for each x / R."""
    camera, radius_m = (0.0, 0.0, -1001.0), 1.5
    seen = view(prototype, camera, Build(bow_radius_m=radius_m))
    pitch = prototype.gratings[0].cells[0].pitch_mm
    gap_mm = view_law(prototype.lens, pitch).effective_gap_mm(pitch)
    more = 2 * math.pi * gap_mm / pitch / (1000 * radius_m)
    assert steepness(seen, law_phase(prototype, seen, camera), axis=1) == pytest.approx(more, rel=0.06)


def test_a_forged_place_moves_the_fringes_and_nothing_else(prototype):
    """Catches: the forgery's place used for the page too, which would make the film genuine again."""
    camera, false = (100.0, 20.0, -1001.0), (-150.0, 90.0, -1001.0)
    seen = view(prototype, camera, shown_mm=false)
    assert abs(left_over(seen, law_phase(prototype, seen, false))) < 0.01
    assert abs(left_over(seen, law_phase(prototype, seen, camera))) > 0.5
    true, forged = (render(prototype, instant(camera, shown_mm=place)) for place in (camera, false))
    assert np.array_equal(true.coverage, forged.coverage)
    corner = slice(0, 40)
    assert np.array_equal(true.radiance[corner, corner], forged.radiance[corner, corner])


# Symmetry.


def square_frame(badge: Badge, camera_mm, build: Build | None = None) -> np.ndarray:
    """Pixels of the grating near the middle of a square picture, where board and transposed board both have it."""
    camera = Camera(width=400, height=400, focal_px=1450.0)
    # The grid of rays is sheared and so not symmetric itself; this many make it as good as.
    shot = render(badge, instant(camera_mm), build, rays=(16, 16), camera=camera)
    picture = np.zeros((400, 400))
    picture[shot.top : shot.top + shot.radiance.shape[0], shot.left : shot.left + shot.radiance.shape[1]] = (
        shot.radiance
    )
    return picture[172:210, 172:210]


@pytest.mark.parametrize("build", [Build(), Build(lens_offset_mm=0.13, print_scale=1.002, lens_scale=0.999)])
def test_an_axis_of_y_is_that_of_x_transposed(prototype, build):
    """Catches: a y grating read along x; its offset left out; the camera's other coordinate used for its view."""
    upright = square_frame(prototype, (30.0, -20.0, -1001.0), build)
    lying = square_frame(transposed(prototype), (-20.0, 30.0, -1001.0), build)
    assert upright.std() > 0.1
    # Measured 0.006 to 0.02; a picture of other fringes is 0.4 away.
    assert np.sqrt(np.mean((upright - lying.T) ** 2)) < 0.04


# The page and the board's outline.


@pytest.mark.parametrize("build", [Build(), Build(print_scale=1.004, print_aspect=0.993, twist_rad=0.005)])
def test_markers_decode_where_the_pinhole_puts_them(prototype, build):
    """Catches: a mirrored or turned page; ids exchanged; markers on the lens plane (0.5 px off at this slant); a
    marker of the design's height, place or shape (0.7 px off); a print that turns with the sheet (0.5 px).
    """
    camera_mm = np.array([300.0, -25.0, -900.0])
    shot = render(prototype, instant(camera_mm), build, rays=(16, 16))
    frame = np.full((CAMERA.height, CAMERA.width), 0.4)
    rows, columns = (slice(a, a + n) for a, n in zip((shot.top, shot.left), shot.radiance.shape, strict=True))
    frame[rows, columns] += shot.coverage * (shot.radiance - 0.4)
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, prototype.markers.dictionary))
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary).detectMarkers((255 * frame).astype(np.uint8))
    assert sorted(ids.ravel()) == sorted(prototype.markers.ids)
    for quad, identity in zip(corners, ids.ravel(), strict=True):
        wanted = marker_px(prototype, prototype.markers.ids.index(identity), camera_mm, build)
        assert np.abs(quad[0] - wanted).max() < 2.0
        # An edge lies where the dark along a line across it ends: the black border's middle, outside to inside.
        (left, top), (right, bottom) = wanted[0], wanted[2]
        column, row = round(left + (right - left) / 12), round(top + (bottom - top) / 12)
        assert dark_from(frame[:, column], top) == pytest.approx(top, abs=0.06)
        assert dark_from(frame[::-1, column], CAMERA.height - 1 - bottom) == pytest.approx(
            CAMERA.height - 1 - bottom, abs=0.06
        )
        assert dark_from(frame[row], left) == pytest.approx(left, abs=0.06)
        assert dark_from(frame[row, ::-1], CAMERA.width - 1 - right) == pytest.approx(
            CAMERA.width - 1 - right, abs=0.06
        )


def marker_px(badge: Badge, index: int, camera_mm: np.ndarray, build: Build) -> np.ndarray:
    """Corners of a marker's black square in the picture of a camera that looks straight on; centres are integers."""
    half = badge.markers.size_mm / 2
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    width, height = build.print_scale, build.print_scale * build.print_aspect
    place = (badge.markers.centers_mm[index] - middle(badge) + square) * (width, height)
    seen = (place - camera_mm[:2]) / -camera_mm[2]
    return seen * CAMERA.focal_px + [(CAMERA.width - 1) / 2, (CAMERA.height - 1) / 2]


def dark_from(line: np.ndarray, near: float) -> float:
    """Where a line of pixels turns from paper to ink, within four pixels of `near`, to a fraction of a pixel."""
    first = round(near) - 4
    part = line[first : first + 8]
    dark = (part.max() - part) / np.ptp(part)
    return first + 8 - 0.5 - dark.sum()


def test_a_rolling_shutter_shears_the_board(prototype):
    """Catches: first and last row exchanged; the shutter counted over the badge's rows, not the picture's."""
    way_mm = 40.0
    rolled = render(prototype, instant((-way_mm / 2, 0.0, -1000.0), (way_mm / 2, 0.0, -1000.0)), rays=(16, 16))
    width_px = prototype.page_mm[0] * CAMERA.focal_px / 1000.0
    rows = np.arange(8, rolled.coverage.shape[0] - 8)
    share = rolled.coverage[rows]
    assert share.sum(axis=1) == pytest.approx(np.full(len(rows), width_px), abs=0.1)
    centre = (share @ np.arange(share.shape[1])) / share.sum(axis=1) + rolled.left
    fraction = (rows + rolled.top - (CAMERA.height - 1) / 2) / CAMERA.height
    wanted = (CAMERA.width - 1) / 2 - fraction * way_mm * CAMERA.focal_px / 1000.0
    assert centre == pytest.approx(wanted, abs=0.05)
