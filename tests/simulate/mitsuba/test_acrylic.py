"""The mount's acrylic and a background in Mitsuba's scene.  Beside each test: what it would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kit.rendered_frames import Crop, beyond_law_rad, pixels_of, seen_from, turn_rad
from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_for_name
from moireid.errors import SpecError
from moireid.fabrication.acrylic.plates import plan_acrylic
from moireid.simulate.acrylic import ACRYLIC_INDEX, AIR_MM, Acrylic, Plate, plate_faces, plates_around
from moireid.simulate.analytic.estimate import Estimate
from moireid.simulate.left_out import left_out
from moireid.simulate.light import LIGHTS
from moireid.simulate.mitsuba.renderer import MitsubaRenderer
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant, Scene

RUNS = 3


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Request("Ada Lovelace"), payload_for_name("Ada Lovelace", family="pitch"))


def radiance(scene: Scene, instant: Instant, crop: Crop, samples: int = 64) -> np.ndarray:
    frame = MitsubaRenderer(scene, samples=samples, variant="scalar_rgb").render(instant, crop=crop)
    assert frame is not None
    return frame.radiance


def test_the_plates_are_those_of_the_planned_stack(badge: Badge) -> None:
    """Catches: a stack in front of the badge for one behind it, a cover that lies on the page, lips at other rows."""
    plan = plan_acrylic(badge)
    plates = plates_around(
        badge,
        base_mm=plan.base.thickness_mm,
        frame_mm=plan.frame.thickness_mm,
        cover_mm=plan.cover.thickness_mm,
        clearance_mm=plan.clearance_mm,
        card_mm=plan.card_mm,
    )
    for plate, planned in zip(plates, plan.plates, strict=False):
        assert plate.rect == pytest.approx(planned.outline.bounds)
        # The plan counts up from the base's upper face, the scene down from the page's.
        assert plate.far_mm == pytest.approx(plan.card_mm - planned.low_mm)
        assert plate.near_mm == pytest.approx(plan.card_mm - planned.low_mm - planned.thickness_mm)
    assert plates[1].window == pytest.approx(plan.frame.openings[0].bounds)
    lips = [(x, -y) for x0, y0, x1, y1 in (plate.rect for plate in plates[3:]) for x in (x0, x1) for y in (y0, y1)]
    planned_corners = np.array(plan.cover.openings[0].corners)
    assert len(plates) == 5
    for corner in lips:
        assert np.abs(planned_corners - corner).sum(axis=1).min() < 1e-9


@pytest.mark.parametrize("window", [None, (-3.0, -2.0, 4.0, 3.0)])
def test_a_plate_is_one_closed_solid(window: tuple[float, float, float, float] | None) -> None:
    """Catches: a wall that is missing, and a face that is turned over, through which light would bend the wrong way."""
    import trimesh

    plate = Plate((-6.0, -5.0, 7.0, 6.0), window, -1.0, 2.0)
    faces = plate_faces(plate)
    points, triangles = faces.reshape(-1, 3), np.arange(4 * len(faces)).reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]]
    solid = trimesh.Trimesh(points, triangles.reshape(-1, 3), process=True)
    assert solid.is_watertight and solid.is_winding_consistent
    hole = (7 + 2 * AIR_MM) * (5 + 2 * AIR_MM) if window else 0.0
    assert solid.volume == pytest.approx(((13 - 2 * AIR_MM) * (11 - 2 * AIR_MM) - hole) * (3 - 2 * AIR_MM))


def test_acrylic_outside_the_view_leaves_the_fringes_alone(badge: Badge) -> None:
    """Catches: a lens that mirrors the background into the phase, plates between camera and lenses, rays that the
    other integrator loses.  What is allowed is three times Mitsuba's own error, by seeds: 0.002 rad.
    """
    instant, cell = seen_from((300, 0, -1000)), badge.gratings[0].cells[5]
    behind = np.tile([0.0, 0.8], (8, 8))
    scenes = Scene(badge), Scene(badge, acrylic=Acrylic(plates_around(badge), behind))
    crop = pixels_of(scenes[0], instant, cell.rect_mm)
    phases, means = [], []
    for scene in scenes:
        renderer = MitsubaRenderer(scene, variant="scalar_rgb")
        frames = [frame for _ in range(RUNS) if (frame := renderer.render(instant, crop=crop)) is not None]
        phases.append([beyond_law_rad(frame, scene, instant, cell) for frame in frames])
        means.append(np.mean([frame.radiance for frame in frames]))
    apart = np.array([turn_rad(*pair) for pair in zip(*phases, strict=True)])
    error = math.sqrt(sum(np.var(found, ddof=1) for found in phases) / RUNS)
    assert error < 0.002
    assert abs(apart.mean()) < 0.002 + 3 * error, f"{apart} rad apart, error {error}"
    assert means[1] == pytest.approx(means[0], rel=0.003)


def test_the_rim_shifts_what_is_behind_it_as_slabs_do(badge: Badge) -> None:
    """A step from dark to bright on the plane behind, seen at an angle through the rim.

    Catches: a refractive index or a thickness that is off, plates with faces inside out, a background that is mirrored.
    """
    u, behind_mm = 0.5, 40.0
    acrylic = Acrylic(plates_around(badge), behind_mm=behind_mm, width_mm=240.0)
    x0, _, x1, _ = badge.outline_mm
    half = (x1 - x0) / 2
    # The line of sight to the middle of the right rim leans by u towards +x.
    rim = half + 5.1
    instant = seen_from((rim - 600 * u, 0, -600), (0, 0, 0))
    # Sideways of a ray that leaves the page's plane at x: the plates move it back by what glass bends it less.
    thick = sum(plate.far_mm - plate.near_mm - 2 * AIR_MM for plate in acrylic.plates[:3])
    sine = u / math.hypot(1, u)
    back = thick * (u - math.tan(math.asin(sine / ACRYLIC_INDEX)))
    dark_mm = {}
    for name, step in (("beside", 0.0), ("moved", back)):
        # Columns of 0.03 mm over the plane: bright beyond the place to which the rim's middle leads.
        place = (np.arange(8000) + 0.5) / 8000 * 240.0 - 120.0
        picture = np.where(place > rim + behind_mm * u - step, 0.8, 0.1)[None, :]
        scene = replace(Scene(badge), acrylic=replace(acrylic, behind=np.repeat(picture, 400, axis=0)))
        centre = scene.board_centre_mm
        box = (centre[0] + rim - 4, centre[1] - 2, centre[0] + rim + 4, centre[1] + 2)
        crop = pixels_of(scene, instant, box)
        seen = radiance(scene, instant, crop).mean(axis=0)
        per_mm = scene.camera.focal_px / 600
        # Beyond 2.5 mm from the middle the rim's own walls are seen; dark and bright lose and mirror alike.
        middle = len(seen) // 2
        low, high = seen[middle - 5 : middle - 2].mean(), seen[middle + 4 : middle + 6].mean()
        assert high - low > 0.5
        inner = seen[middle - 5 : middle + 6]
        dark_mm[name] = (((high - inner) / (high - low)).sum() + middle - 5) / per_mm
        # From the crop's left edge to the line of sight, at the rim's distance.
        middle_mm = u * 600 + (scene.camera.matrix[0, 2] - crop[0] + 0.5) / per_mm
    # In the second picture the step was moved so that it stands in the middle again; nearer by 640 / 600.
    assert dark_mm["moved"] == pytest.approx(middle_mm, abs=0.05)
    assert dark_mm["beside"] - dark_mm["moved"] == pytest.approx(back * 600 / 640, abs=0.05) and back > 0.9


def test_a_frame_shows_the_mount_s_outline(badge: Badge) -> None:
    """Catches: a picture cut off at the board, an even background that acrylic dims, a mount that no light passes."""
    scene, instant = Scene(badge, acrylic=Acrylic(plates_around(badge), 0.3)), seen_from((0, 0, -4000))
    frame = MitsubaRenderer(scene, samples=16, segments=4, variant="scalar_rgb").render(instant)
    bare = MitsubaRenderer(Scene(badge), samples=16, segments=4, variant="scalar_rgb").render(instant)
    assert frame is not None and bare is not None
    grown = np.array(frame.radiance.shape) - bare.radiance.shape
    assert np.all(np.abs(grown - 2 * 10.1 * scene.camera.focal_px / 4000) < 2.1)
    middle = frame.radiance.shape[0] // 2
    rim = frame.radiance[middle - 20 : middle + 20, 3:5]
    assert rim == pytest.approx(0.3, abs=0.01)


def test_under_a_light_the_rim_shows_what_is_behind_it(badge: Badge) -> None:
    """Catches: a path that ends within the plates, and the sky's brightness on the page's scale seen through them."""
    scene = Scene(badge, light=LIGHTS["softbox"], acrylic=Acrylic(plates_around(badge), 0.3))
    centre, half = scene.board_centre_mm, scene.board_half_mm
    instant = seen_from((0, 0, -1000))
    crop = pixels_of(scene, instant, (centre[0] + half[0] + 3, centre[1] - 4, centre[0] + half[0] + 7, centre[1] + 4))
    seen = radiance(scene, instant, crop, samples=256)
    # 4 % are lost at each of the six faces; what they mirror of the room comes on top.
    passed = (1 - ((ACRYLIC_INDEX - 1) / (ACRYLIC_INDEX + 1)) ** 2) ** 6
    assert 0.3 * passed - 0.01 < seen.mean() < 0.3 * passed + 0.25


def test_what_is_no_mount_is_refused(badge: Badge) -> None:
    """Catches: a background before the badge, a window larger than its plate, an empty mount."""
    plates = plates_around(badge)
    with pytest.raises(SpecError, match="one plate or more"):
        Acrylic(())
    with pytest.raises(SpecError, match="greater behind_mm"):
        Acrylic(plates, behind_mm=1.0)
    with pytest.raises(SpecError, match="0 or more"):
        Acrylic(plates, -0.1)
    with pytest.raises(SpecError, match="make it smaller"):
        plate_faces(Plate((-1, -1, 1, 1), (-2, -2, 2, 2), 0, 1))
    with pytest.raises(SpecError, match="make it larger"):
        plate_faces(Plate((-1, -1, 1, 1), None, 0, 0.01))


def test_a_film_says_whether_it_shows_the_mount(badge: Badge) -> None:
    """Catches: a mount told as left out where it is shown, and as shown by the renderer that knows none."""
    bare, with_mount = Scene(badge), Scene(badge, acrylic=Acrylic(plates_around(badge)))
    told = [(scene, backend) for scene in (bare, with_mount) for backend in ("analytic", "mitsuba")]
    estimate = Estimate((16, 1), 0.001, 0.01, 0.01, 0.04, 1000)
    at = Poses(np.array([[0.0, 0.0, -1000.0]]), np.eye(3)[None])
    instant = Instant(at, at, at.camera_mm[0])
    found = [left_out(scene, backend, estimate, instant, instants=1, sensor_s=0.01) for scene, backend in told]
    assert ["the mount" in [part.what for part in parts] for parts in found] == [True, True, True, False]
