"""Gratings at an angle: their frame, the file, the optics and the pictures.  Each test names what it would catch."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from kit.numeric_films import Building, filmed
from moireid.badge import Badge, Cell, Grating, badge_from_json
from moireid.designer import Order, design_badge
from moireid.errors import DesignError, SpecError
from moireid.frames import own_frame, own_rect
from moireid.lenticule import view_law
from moireid.question import KnownCamera
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Camera, Instant, Scene
from moireid.verifier.decision.judge import judge
from moireid.verifier.fringes.signals import measure
from moireid.verifier.fringes.strip_law import strip_law
from moireid.verifier.identity.decode import judge_identity
from moireid.verifier.tracking.brightness_profiles import ProfileReader
from moireid_lab.bench.simulate.reference import Setup, trace_pixels

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
A4 = (210.0, 297.0)
RANGE_M = (0.8, 2.0)


@pytest.fixture(scope="module")
def hexagonal() -> Badge:
    return design_badge(Order("Ada", lens="50lpi", axes="hex", range_m=RANGE_M), PAYLOAD)


def one_grating(axis: str | float) -> Badge:
    """A badge of one grating whose rectangle is off the page's centre, of that axis and nothing else changed."""
    badge = design_badge(Order("Ada", lens="50lpi", form="vector"), PAYLOAD)
    rect = (92.0, 131.0, 131.0, 155.0)
    cells = tuple(
        Cell((92.0, low, 131.0, low + 8.0), 0.52 + 0.003 * k, 92.1 + 0.07 * k, 0.45)
        for k, low in enumerate((131.0, 139.0, 147.0))
    )
    grating = Grating(rect, axis, 0.52, "uniform", cells)  # type: ignore[arg-type]
    return replace(badge, gratings=(grating,), id=None, payload_bits=None)


def test_an_angle_turns_from_x_towards_y_about_the_page_s_centre() -> None:
    """Catches: a turn the other way, about the page's corner or the board's, own coordinates in the other order."""
    frame = own_frame(60.0, A4)
    assert frame.places((105.0, 148.5)) == pytest.approx((105.0, 148.5))
    along = (105.0 + 10 * 0.5, 148.5 + 10 * math.sqrt(0.75))
    assert frame.places(along) == pytest.approx((115.0, 148.5))
    # From the axis a quarter turn on, along the lines: to the left and down.
    assert frame.on_page((105.0, 149.5)) == pytest.approx((105.0 - math.sqrt(0.75), 149.0))
    assert frame.handed == 1.0 and own_frame("y", A4).handed == -1.0


def test_the_file_keeps_an_angle_and_refuses_what_is_none(hexagonal: Badge) -> None:
    """Catches: an angle lost or rounded, a half turn twice, a grating that reaches over the page's edge when turned."""
    assert badge_from_json(hexagonal.to_json()) == hexagonal
    document = json.loads(one_grating(37.5).to_json())
    assert badge_from_json(json.dumps(document)).gratings[0].axis == 37.5
    for wrong in (180, -1, "60", "xy", "x\n", True, None, [60]):
        document["gratings"][0]["axis"] = wrong
        with pytest.raises(SpecError, match=r"gratings\.0\.axis"):
            badge_from_json(json.dumps(document))
    document = json.loads(one_grating("x").to_json())
    # In its own frame a grating may begin left of the page.
    document["gratings"][0] |= {"rect_mm": [-45, 131, 205, 155], "axis": 60}
    assert badge_from_json(json.dumps(document)).gratings[0].axis == 60.0
    document["gratings"][0]["rect_mm"] = [-80, 131, 205, 155]
    with pytest.raises(SpecError, match="on the page"):
        badge_from_json(json.dumps(document))


@pytest.mark.parametrize("size_mm", [(146.0, 160.0), (120.0, 130.0), (160.0, 120.0), (148.0, 210.0), (186.0, 140.0)])
def test_three_fields_lie_on_the_board_apart_from_each_other_and_the_markers(size_mm: tuple[float, float]) -> None:
    """Catches: fields over a marker's white, over name or id, over the board's margin, or without paper between."""
    badge = design_badge(Order("Ada", lens="50lpi", axes="hex", range_m=(0.8, 1.2), size_mm=size_mm), PAYLOAD)
    x0, y0, x1, y1 = badge.outline_mm
    quiet = badge.markers.size_mm * (0.5 + 1.05 / 6)
    blocked = [((x - quiet, y - quiet), (x + quiet, y + quiet)) for x, y in badge.markers.centers_mm]
    (left, top), (right, _), (_, bottom), _ = badge.markers.centers_mm
    half = badge.markers.size_mm / 2
    blocked += [((left, top - half), (right, top + half)), ((left, bottom - 3.0), (right, bottom + 3.0))]
    fields = [_points(badge, grating) for grating in badge.gratings]
    for field in fields:
        assert (field >= (x0 + 4.99, y0 + 4.99)).all() and (field <= (x1 - 4.99, y1 - 4.99)).all()
        for low, high in blocked:
            assert not ((field > np.add(low, 0.01)) & (field < np.subtract(high, 0.01))).all(axis=1).any()
    for k, field in enumerate(fields):
        for other in fields[:k]:
            assert np.linalg.norm(field[:, None] - other[None], axis=-1).min() > 3.9
    assert [grating.axis for grating in badge.gratings] == ["x", 60.0, 120.0]


def _points(badge: Badge, grating: Grating) -> np.ndarray:
    """Places all round a grating's border, on the page."""
    corners = badge.corners_of(grating)
    assert badge.bounds_of(grating) == pytest.approx([*corners.min(axis=0), *corners.max(axis=0)])
    way = np.linspace(0, 1, 80)[:, None]
    return np.concatenate([a + way * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])


def test_the_predicted_phase_is_that_of_the_closed_form() -> None:
    """Catches: a camera that is not turned with the grating, or turned about another point; tangents exchanged."""
    badge = one_grating(60.0)
    camera = np.array([[170.0, 40.0, -1100.0], [20.0, 260.0, -900.0]])
    u, v = np.array([0.5, math.sqrt(0.75)]), np.array([-math.sqrt(0.75), 0.5])
    centre, lens, pitch = np.array(A4) / 2, badge.lens, badge.gratings[0].pitch_mm
    for strip in ProfileReader(badge).strips:
        own = np.column_stack([strip.along_mm, np.full(len(strip.along_mm), strip.across_mm)]) - centre
        page = centre + own[:, :1] * u + own[:, 1:] * v
        sight = (page[None] - camera[:, None, :2]) / np.abs(camera[:, None, 2:])
        shift = view_law(lens, pitch).phase_rad(sight @ u, sight @ v) * pitch / (2 * math.pi)
        place = own[:, 0] - ((92.0 + 131.0) / 2 - centre[0]) - lens.thickness_mm * (sight @ u)
        frequency = -0.05
        expected = 2 * math.pi * (shift / lens.pitch_mm + frequency * (place + shift))
        assert strip_law(badge, strip, camera).whole_phase_rad(frequency) == pytest.approx(expected, abs=2e-4)


def _radiance(badge: Badge, angle_deg: float, build: Build) -> np.ndarray:
    """The grating's pixels as a camera sees it that is turned with it about the view axis of the page's centre."""
    cosine, sine = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    camera = np.array([[150.0, -90.0, -700.0]]) @ turn.T
    poses = Poses(camera, turn.T[None])
    camera_of_film = Camera(1200, 900, 700.0, shutter_s=0.0, principal_px=(850.0, 300.0))
    renderer = AnalyticRenderer(Scene(badge, build, camera_of_film), rays=(48, 8), precision="float64")
    seen = renderer.render(Instant(poses, poses, camera[0]), crop=(685, 375, 710, 395))
    assert seen is not None
    return seen.radiance


def test_a_scene_turned_as_a_whole_looks_the_same() -> None:
    """Catches: a twist, an offset or a cell's edge that is not turned with the grating; the wrong sign of one."""
    build = Build(lens_offset_mm=0.13, twist_rad=math.radians(0.3), print_scale=1.002, lens_scale=0.999)
    upright = _radiance(one_grating("x"), 0.0, build)
    assert np.ptp(upright) > 0.3
    for angle in (0.0, 60.0, 131.0):
        # A pixel's rays are numbered from the board's corner, so they are others.
        assert np.abs(_radiance(one_grating(angle), angle, build) - upright).max() < 0.04, angle


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_the_pictures_of_turned_gratings_are_the_independent_tracer_s(hexagonal: Badge, precision: str) -> None:
    """Catches: a print of two scales whose shear is left out, a twist whose sign is another grating's."""
    build = Build(
        lens_offset_mm=0.05,
        twist_rad=math.radians(0.1),
        print_scale=1.003,
        print_aspect=0.994,
        lens_scale=1.001,
    )
    camera = Camera(1920, 1080, 1450.0, shutter_s=0.0)
    place = np.array([[140.0, -80.0, -1000.0]])
    poses = Poses(place, np.eye(3)[None])
    centred = replace(camera, principal_px=(959.5 + 203.0, 539.5 - 116.0))
    scene = Scene(hexagonal, build, centred)
    seen = AnalyticRenderer(scene, rays=(16, 4), precision=precision).render(Instant(poses, poses, place[0]))  # type: ignore[arg-type]
    assert seen is not None
    rng = np.random.default_rng(4)
    for grating in hexagonal.gratings:
        own = own_rect(grating.axis, grating.rect_mm)
        chosen = rng.uniform((own[0] + 4, own[1] + 4), (own[2] - 4, own[3] - 4), (60, 2))
        board = hexagonal.frame_of(grating).on_page(chosen) - scene.board_centre_mm
        pixels = np.rint((board - place[0, :2]) / 1000.0 * 1450.0 + centred.matrix[:2, 2]).astype(int)
        setup = Setup(
            hexagonal,
            build.lens_offset_mm,
            build.twist_rad,
            build.print_scales,
            build.lens_scale,
            scene.ink,
            scene.paper,
        )
        true = trace_pixels(setup, centred.matrix, place[0], np.eye(3), pixels[:, 0], pixels[:, 1]).radiance
        found = seen.radiance[pixels[:, 1] - seen.top, pixels[:, 0] - seen.left]
        assert np.sqrt(np.mean((found - true) ** 2)) < 0.04, grating.axis
        assert np.std(true) > 0.2


def test_a_film_of_three_gratings_is_measured_and_read(hexagonal: Badge) -> None:
    """Catches: strips read across the lines, a camera of another frame, cells in another order than written."""
    track = filmed(hexagonal, Building(scale=1.001, offset_rad=1.0, twist_rad_per_mm=0.02))
    measurement = measure(track, camera=KnownCamera(1450.0))
    found = judge(measurement.gratings)
    assert found.verdict == "accept"
    assert [figures["gain_ratio"] for figures in found.gratings] == pytest.approx([1.0] * 3, abs=0.03)
    identity = judge_identity(track, measurement, claimed_id=hexagonal.id)
    assert (identity.verdict, identity.decoded_id) == ("match", PAYLOAD.hex())


def test_a_board_too_small_for_three_fields_says_so() -> None:
    """Catches: fields of no height, or an error that names no way out."""
    with pytest.raises(DesignError, match="larger board"):
        design_badge(Order("Ada", lens="50lpi", axes="hex", size_mm=(60.0, 66.0), range_m=(0.3, 0.5)), PAYLOAD)
