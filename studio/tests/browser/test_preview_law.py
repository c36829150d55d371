"""The preview's script in a real browser, held against the library's own predictions.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page, Route, sync_playwright
from scipy.spatial.transform import Rotation

import moireid_studio
from kit.payloads import payload_for_name
from kit.programs import needs
from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.frames import own_rect
from moireid.lenticule import view_response
from moireid.simulate.scene import Scene
from moireid.simulate.truth import shown_phase_rad
from moireid.smooth_lines import LineField
from moireid.verifier.fringes.strip_law import strip_law
from moireid.verifier.tracking.brightness_profiles import ProfileReader
from moireid_studio.pages.preview_law import preview_law

STATIC = Path(moireid_studio.__file__).parent / "static"
#: What straight lines between the table's entries, and the verifier's own coarse look-ups, leave.
TOLERANCE_RAD = 0.005
#: The table is traced for a grating's nominal pitch, as the verifier's is: for other pitches it is 0.5 % off.
TRACED_RAD = 0.02
#: Cameras as tangents to the right and down and a distance, mm: all signs and both axes, none a mirror of another.
CAMERAS = [(0.0, 0.0, 1000.0), (0.21, -0.05, 900.0), (-0.33, 0.12, 600.0), (0.07, 0.38, 2400.0), (0.4, -0.4, 500.0)]


def _serve(route: Route) -> None:
    """The scripts by name, and an empty page for anything else."""
    script = STATIC / route.request.url.rsplit("/", 1)[-1]
    if script.name in ("fringes.js", "preview.js"):
        route.fulfill(body=script.read_text(encoding="utf-8"), content_type="text/javascript")
    else:
        route.fulfill(body="<!doctype html>", content_type="text/html")


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    """An empty page of a site that serves the scripts."""
    program = needs("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = browser.new_page()
        page.route("**/*", _serve)
        page.goto("http://studio.test/")
        yield page
        browser.close()


@pytest.fixture(scope="module", params=["x", "xy", "hex", "mask"])
def badge(request: pytest.FixtureRequest) -> Badge:
    """A badge of one axis, of two, of three at angles, and one under a line mask."""
    # Bent lines are drawn in rows of their own, and have a test of their own.
    wish = Request("Ada", axes=request.param, range_m=(0.8, 2.0), pattern="cells") if request.param != "mask" else None
    wish = wish or Request("Ada", front="mask", pattern="cells")
    return design_badge(wish, payload_for_name("Ada"))


def camera_mm(badge: Badge, right: float, down: float, distance_mm: float) -> np.ndarray:
    """Where the preview's camera is, page mm."""
    x0, y0, x1, y1 = badge.outline_mm
    return np.array([(x0 + x1) / 2 + right * distance_mm, (y0 + y1) / 2 + down * distance_mm, -distance_mm])


def asked(badge: Badge, count: int = 40) -> list[dict[str, Any]]:
    """Points spread over all cells, each seen by one of the cameras."""
    rng = np.random.default_rng(7)
    cells = [(g, c) for g, grating in enumerate(badge.gratings) for c in range(len(grating.cells))]
    points = []
    for k in range(count):
        g, c = cells[int(rng.integers(len(cells)))]
        grating = badge.gratings[g]
        low, top, high, bottom = own_rect(grating.axis, grating.cells[c].rect_mm)
        x, y = badge.frame_of(grating).on_page((rng.uniform(low, high), rng.uniform(top, bottom))).tolist()
        points.append({"g": g, "c": c, "x": x, "y": y, "camera": CAMERAS[k % 5]})
    return points


def turns(page: Page, badge: Badge, points: list[dict[str, Any]]) -> np.ndarray:
    """What the script says of the points."""
    code = """async ([law, points]) => {
        const { cameraAt, turnsAt } = await import("http://studio.test/fringes.js");
        return points.map(({ g, c, x, y, camera }) => turnsAt(law, g, c, x, y, cameraAt(law, ...camera)));
    }"""
    # By way of JSON's text, as the page has it.
    return np.array(page.evaluate(code, [json.loads(json.dumps(preview_law(badge))), points]))


def test_bent_lines_are_those_of_the_page(page: Page) -> None:
    """Catches: hard cells in the place of bent lines, rows upside down, an excess of the wrong sign or place."""
    badge = design_badge(Request("Ada", axes="xy", range_m=(0.8, 2.0), pattern="silk"), payload_for_name("Ada"))
    rng, points, expected = np.random.default_rng(3), [], []
    law = preview_law(badge)
    for k in range(60):
        g = k % 2
        grating, frame, (x0, y0, x1, y1) = badge.gratings[g], badge.frame_of(badge.gratings[g]), badge.outline_mm
        row = int(rng.integers(len(law["gratings"][g]["cells"])))
        low, top, high, bottom = law["gratings"][g]["cells"][row]["rect_mm"]
        place = np.array([rng.uniform(low + 2, high - 2), (top + bottom) / 2])
        x, y = frame.on_page(place).tolist()
        points.append(
            {"g": g, "c": row, "x": x, "y": y, "camera": ((x - (x0 + x1) / 2) / 900, (y - (y0 + y1) / 2) / 900, 900.0)}
        )
        # A camera straight ahead of a place sees the line on the lens's axis.
        middle = float(frame.places(((x0 + x1) / 2, (y0 + y1) / 2))[0])
        number = float(LineField(grating).numbers(place[0], place[1]))
        expected.append(number - (place[0] - middle) / badge.lens.pitch_mm)
    off = turns(page, badge, points) - expected
    assert np.abs(off - np.round(off)).max() < 0.05


@pytest.mark.slow
def test_the_script_sees_the_line_that_a_traced_ray_lands_on(page: Page, badge: Badge) -> None:
    """Catches: swapped axes, a wrong sign, cells whose edge is forgotten, one pitch for all cells, a coarse table."""
    points = asked(badge)
    expected = []
    for point in points:
        grating = badge.gratings[point["g"]]
        cell, frame, (x0, y0, x1, y1) = grating.cells[point["c"]], badge.frame_of(grating), badge.outline_mm
        eye, place = camera_mm(badge, *point["camera"]), np.array([point["x"], point["y"]])
        tangent = frame.directions(place - eye[:2]) / abs(eye[2])
        middle = float(frame.places(((x0 + x1) / 2, (y0 + y1) / 2))[0])
        lens = float(frame.places(place)[0]) - badge.lens.thickness_mm * tangent[0]
        # The fringe that lenses at whole pitches from the middle draw, taken between them as the eye does.
        beat = (lens - middle) * (1 / cell.pitch_mm - 1 / badge.lens.pitch_mm) + (middle - cell.edge_mm) / cell.pitch_mm
        seen = np.angle(view_response(badge.lens, cell.pitch_mm, tangent[0], tangent[1]))
        expected.append(2 * math.pi * beat + float(seen))
    off = np.angle(np.exp(1j * (2 * math.pi * turns(page, badge, points) - expected)))
    assert np.abs(off).max() < TRACED_RAD


def test_the_fringes_move_and_lie_as_the_verifier_predicts(page: Page, badge: Badge) -> None:
    """Catches: fringes that go the wrong way, that ignore the camera's distance, that move on the wrong plane."""
    strips = [strip for strip in ProfileReader(badge).strips if strip.uniform]
    eyes = np.array([camera_mm(badge, *camera) for camera in CAMERAS])
    for strip in strips[:: max(1, len(strips) // 3)]:
        cell = badge.gratings[strip.grating].cells[strip.cells[0]]
        where = strip.along_mm[:: max(1, len(strip.along_mm) // 6)]
        points = [
            {"g": strip.grating, "c": strip.cells[0], "camera": camera}
            | dict(zip("xy", strip.frame.on_page((float(place), strip.across_mm)).tolist(), strict=True))
            for camera in CAMERAS
            for place in where
        ]
        found = 2 * math.pi * turns(page, badge, points).reshape(len(CAMERAS), -1)
        frequency = 1 / cell.pitch_mm - 1 / badge.lens.pitch_mm
        law = strip_law(badge, strip, eyes).whole_phase_rad(frequency)[:, :: max(1, len(strip.along_mm) // 6)]
        off = (found - found[0, 0]) - (law - law[0, 0])
        assert np.abs(off).max() < TOLERANCE_RAD
        # Else the test could not fail: the fringes pass by many radians, and the distance alone by tenths.
        assert np.ptp(law) > 10 and np.abs(law[3] - law[0]).max() > 0.2


def test_the_middle_moves_as_the_simulator_s_truth(page: Page, badge: Badge) -> None:
    """Catches: a preview that agrees with the verifier and not with the films."""
    grating = badge.gratings[0]
    x0, y0, x1, y1 = badge.outline_mm
    cell = next(
        c for c, one in enumerate(grating.cells) if abs(one.pitch_mm - grating.pitch_mm) < 1e-9 or not grating.code
    )
    points = [{"g": 0, "c": cell, "x": (x0 + x1) / 2, "y": (y0 + y1) / 2, "camera": camera} for camera in CAMERAS]
    found = 2 * math.pi * turns(page, badge, points)
    truth = []
    for camera in CAMERAS:
        eye = camera_mm(badge, *camera) - np.array([(x0 + x1) / 2, (y0 + y1) / 2, 0])
        truth.append(shown_phase_rad(Scene(badge), grating, eye, eye, np.zeros(2)))
    assert np.abs((found - found[0]) - (np.array(truth) - truth[0])).max() < TOLERANCE_RAD
    assert np.ptp(truth) > 3


def test_a_picture_is_dark_where_the_ink_is_seen(page: Page, badge: Badge) -> None:
    """Catches: a picture that is the negative of the badge, or whose contrast the view does not lower."""
    code = """async ([law, camera]) => {
        const { brightness, cameraAt, turnsAt } = await import("http://studio.test/fringes.js");
        const at = cameraAt(law, ...camera), [x0, y0, x1, y1] = law.gratings[0].cells[0].rect_mm, count = 400;
        const places = Array.from({ length: count }, (_, k) => [x0 + (k + 0.5) / count * (x1 - x0), (y0 + y1) / 2]);
        return [[...brightness(law, 0, 0, at, count)], places.map(([x, y]) => turnsAt(law, 0, 0, x, y, at))];
    }"""
    law = preview_law(badge)
    depth = []
    for camera in (CAMERAS[0], CAMERAS[4]):
        light, at = map(np.array, page.evaluate(code, [law, camera]))
        waves = np.stack([np.ones_like(at), np.cos(2 * np.pi * at), np.sin(2 * np.pi * at)], axis=1)
        depth.append(np.linalg.lstsq(waves, light, rcond=None)[0][1:])
    # Dark lines are the first half of a period, so light is least a quarter of a turn from their edge.
    assert abs(depth[0][0]) < 0.02 and depth[0][1] < -0.15
    ratio = math.hypot(*depth[1]) / math.hypot(*depth[0])
    assert (0.99 < ratio < 1.01) if badge.lens.kind == "mask" else (0.7 < ratio < 0.95)


@pytest.mark.parametrize("turned", [0, 90, 270])
@pytest.mark.parametrize("first", [(10.0, 40.0, 5.0), (300.0, 88.0, -20.0)])
def test_a_tilted_phone_is_a_camera_that_went_the_other_way(page: Page, first: tuple[float, ...], turned: int) -> None:
    """Catches: a sign or an axis of tilt, a phone held upright (where its angles jump), a screen that is turned."""
    now = (first[0] + 6, first[1] - 9, first[2] + 11)
    code = """async ([first, now, turned]) => {
        const { tiltTangents } = await import("http://studio.test/preview.js");
        const named = ([alpha, beta, gamma]) => ({ alpha, beta, gamma });
        return tiltTangents(named(first), named(now), turned);
    }"""
    found = page.evaluate(code, [list(first), list(now), turned])
    # W3C: turned about the device's own axes, z, then x, then y.  The screen's axes lie in the device, turned back.
    before, after = (Rotation.from_euler("ZXY", angles, degrees=True) for angles in (first, now))
    screen = Rotation.from_euler("z", -turned, degrees=True)
    seen = (after * screen).inv().apply(before.apply([0, 0, 1]))
    assert found == pytest.approx([seen[0] / seen[2], -seen[1] / seen[2]], abs=1e-9)
    # Nothing turned is straight ahead; a right edge that goes away from the eye (gamma) shows the badge from the left.
    assert page.evaluate(code, [list(first), list(first), turned]) == pytest.approx([0, 0], abs=1e-12)
    assert page.evaluate(code, [[0, 0, 0], [0, 0, 10], 0])[0] == pytest.approx(-math.tan(math.radians(10)))
