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
    middle,
    render,
    steepness,
    view,
)
from moireid.badge import Badge
from moireid.lenticule import RAYS, view_law, view_response
from moireid.sheets import effective_gap_mm
from moireid.simulate.analytic.traced_sheet import land, sheet_as_built
from moireid.simulate.build import Build
from moireid.simulate.scene import Scene

# Against the closed form.


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
