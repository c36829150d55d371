"""What a scene does not need is left out, changes the answer by less than stated, and is reported."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.simulate.analytic.accuracy import Difference, brightness, difference, estimate_error, strips_of
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer, BoardRadiance
from moireid.simulate.filming import FilmReport, film
from moireid.simulate.flaw_table import PARTS
from moireid.simulate.mitsuba import mitsuba_renderer as mitsuba_estimate
from moireid.simulate.mitsuba.mitsuba_renderer import cheapest_mitsuba
from moireid.simulate.motion import motion_named
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Camera, Instant, Need, Scene
from moireid_lab.bench.simulate.scenes import SceneSetting, eleven

SETTINGS = {setting.name: setting for setting in eleven()}
SMALL = Camera(width=480, height=272, focal_px=363.0, shutter_s=0.012, noise_counts=0.0)
NEAR = replace(SETTINGS["prototype, 1 m"], camera=replace(SMALL, shutter_s=0.0), distance_mm=400.0)


def apart(scene: Scene, instant: Instant, one: BoardRadiance | None, other: BoardRadiance | None) -> Difference:
    """How far two pictures are apart on the strips of the second one's box."""
    assert one is not None and other is not None
    rows, columns = other.radiance.shape
    strips = strips_of(scene, instant, (other.left, other.top, other.left + columns, other.top + rows))
    pairs = [(strip, brightness(one, strip), brightness(other, strip)) for strip in strips]
    return difference(pairs, scene.paper - scene.ink)


@pytest.mark.parametrize("name", ["prototype, 1 m", "as built: twist, offset, scale", "both axes"])
def test_badge_alone_has_the_same_phase_within_the_stated_error(name: str) -> None:
    """Catches: a box cut within the gratings, or at the page's depth; markers that are still drawn; a box of the whole
    board; pixels off the badge that change what is on it.
    """
    setting: SceneSetting = SETTINGS[name]
    scene, instant = setting.scene, setting.seen_at(0.3)
    alone = replace(scene, need=Need(page=False))
    usual = AnalyticRenderer(scene)
    whole = usual.render(instant, crop=(0, 0, scene.camera.width, scene.camera.height))
    board, cut = usual.render(instant), AnalyticRenderer(alone).render(instant)
    assert board is not None and cut is not None and whole is not None
    stated = estimate_error(scene, [instant])
    for more, less in ((whole, board), (board, cut)):
        found = apart(scene, instant, more, less)
        assert found.strips >= 4
        # Each pixel has the same rays whatever is left out, so that what changes is a rounding.
        assert found.phase_rad < 0.1 * stated.phase_rad and found.image < 0.1 * stated.image
    assert cut.radiance.size < 0.8 * board.radiance.size < 0.5 * whole.radiance.size
    # Every strip of the gratings is still there, and no marker's black.
    box = (board.left, board.top, board.left + board.radiance.shape[1], board.top + board.radiance.shape[0])
    smaller = (cut.left, cut.top, cut.left + cut.radiance.shape[1], cut.top + cut.radiance.shape[0])
    counts = [sum(len(strip.rows) for strip in strips_of(scene, instant, one)) for one in (box, smaller)]
    # A strip's rim is found by the mean footprint of a box's pixels.
    assert counts[0] == pytest.approx(counts[1], rel=0.01)
    page = AnalyticRenderer(alone).render(instant, crop=box)
    centre = np.array(scene.badge.markers.centers_mm[0]) - scene.board_centre_mm
    local = instant.first.rotation[0] @ (np.append(centre * scene.build.print_scales, 0) - instant.first.camera_mm[0])
    column, row = np.rint(scene.camera.project(local)).astype(int) - (page.left, page.top)
    patch = np.s_[row - 4 : row + 5, column - 4 : column + 5]
    assert np.all(page.radiance[patch] == np.float32(scene.paper)) and board.radiance[patch].min() < 0.3


def test_background_left_out_leaves_the_badge_as_it_is() -> None:
    """Catches: clouds that are still painted; another noise without them; a grey that shines into the badge."""
    scene, instant = NEAR.scene, NEAR.seen_at(0.1)
    board = AnalyticRenderer(scene).render(instant)
    assert board is not None
    camera = replace(scene.camera, noise_counts=3.0)
    exposed = {
        (shown, noisy): Sensor(camera if noisy else scene.camera, 5, need=Need(background=shown)).expose(
            board, instant.first.rotation[0], 0.2
        )
        for shown in (True, False)
        for noisy in (True, False)
    }
    solid = np.zeros((camera.height, camera.width), bool)
    rows, columns = board.radiance.shape
    solid[board.top : board.top + rows, board.left : board.left + columns] = board.coverage == 1
    # The lens's blur of half a pixel reaches three pixels in.
    inside = solid & np.all([np.roll(solid, step, axis) for step in (-4, 4) for axis in (0, 1)], axis=0)
    assert inside.sum() > 4000
    for noisy in (True, False):
        assert np.array_equal(exposed[True, noisy][inside], exposed[False, noisy][inside])
    assert exposed[False, False][:40].std() == 0 < exposed[True, False][:40].std()


@pytest.mark.slow
def test_the_command_leaves_out_and_tells_what(prototype, tmp_path: Path) -> None:
    """Catches: an option that is not passed on; a part left out in silence; names that the scene does not know."""
    assert set(PARTS) == set(Need.__dataclass_fields__)
    (tmp_path / "badge.json").write_text(prototype.to_json(), encoding="utf-8")
    asked = ["simulate", str(tmp_path / "badge.json"), "--out", str(tmp_path / "a.mp4"), "--frames", "2"]
    asked += ["--camera", "dim", "--light", "even", *(word for part in PARTS for word in ("--leave-out", part))]
    done = CliRunner().invoke(moireid, [*asked, "--json"])
    assert done.exit_code == 0, done.output
    unseen = {one["what"] for one in json.loads(done.stdout)["left_out"]}
    assert unseen >= {"colour", "background", "page and markers", "rolling shutter and exposure", "glare"}
    said = CliRunner().invoke(moireid, [*asked[:6], "--leave-out", "background", "--overwrite", "--explain"])
    assert said.exit_code == 0 and "background" in said.stdout and "estimated error" in said.stdout
    assert "page and markers" not in said.stdout


def shoot(badge, path: Path, *, camera: Camera = SMALL, need: Need | None = None, **options) -> FilmReport:
    scene = Scene(badge, Build(), camera, need=need or Need())
    course = motion_named("sway", distance_mm=600.0, seed=3)
    return film(scene, course, path, frames=3, fps=25.0, seed=3, crf=1, **options)


def test_mitsuba_refuses_an_error_that_it_cannot_meet(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: the dearest setting taken in silence."""
    monkeypatch.setattr(mitsuba_estimate, "LADDER", ((16, 4),))
    with pytest.raises(SpecError, match=r"estimated 0\.\d+ rad\); give a larger error_rad="):
        cheapest_mitsuba(NEAR.scene, NEAR.seen_at(0.3), 1e-9)


def test_a_film_by_mitsuba_tells_its_error(prototype, tmp_path: Path) -> None:
    """Catches: a reference without an error bar; an estimate of another setting than is filmed."""
    report = shoot(prototype, tmp_path / "a.mp4", backend="mitsuba", error_rad=0.1)
    assert 0 < report.estimate.phase_rad <= 0.1
    assert {"rolling shutter", "lens detail below a segment"} <= set(report.left_out)
