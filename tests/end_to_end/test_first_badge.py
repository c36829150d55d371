"""A first badge from the empty folder to its figures, with pictures as a builder would take them."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from moireid.badge import load_badge
from moireid.bringup.build_folder import OWN_FILES, STATE
from moireid.cli.main import moireid
from moireid.profiles import load_lens_profile, load_printer_profile
from moireid.simulate import Build, Scene, film, motion_named
from moireid_lab.bench.fabricate.calibration import STILL, PhotoCase
from moireid_lab.bench.fabricate.strip_photographs import photographed_chart

#: The sheet is finer than its label, twisted on the badge, with air under it; the printer widens lines.
LENS_SCALE, TWIST_RAD, AIR_MM, GROWTH_UM = 0.9981, 0.003, 0.08, 45.0


def call(folder: Path, *more: str, code: int = 0) -> dict:
    """What the program answers."""
    ran = CliRunner().invoke(moireid, ["first-badge", str(folder), *more, "--json"])
    assert ran.exit_code == code, ran.output
    return json.loads(ran.stdout)


@pytest.mark.claim("first-badge measures sheet, printer and camera")
@pytest.mark.slow
def test_a_builder_is_led_to_a_badge_whose_figures_are_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: a badge printed for the label in place of the sheet; figures that are off by more than their error
    bars; air that is put down to the sheet; a step that is asked for twice; a file that is written and not
    protected in a folder of others."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    folder = tmp_path / "first"
    assert call(folder, "--name", "Ada Lovelace", "--lens", "50lpi", "--printer", "mine")["next"]["name"] == "sheet"
    chart = load_badge(folder / "pitch-test.json")
    luma = photographed_chart(chart, PhotoCase("50lpi", LENS_SCALE, 0.4, 1.0, 4.0), GROWTH_UM)
    cv2.imwrite(str(folder / "sheet-photo.jpg"), luma, [cv2.IMWRITE_JPEG_QUALITY, 92])
    read = call(folder, "--thickness", "1.0", "--focal-px", str(STILL.focal_px))
    assert read["did"] == ["sheet", "badge"] and read["next"]["name"] == "films"
    badge, printer = load_badge(folder / "badge" / "badge.json"), load_printer_profile(folder / "printer.json")
    assert badge.name == "Ada Lovelace" and badge.lens == load_lens_profile(folder / "sheet.json").lens
    assert badge.lens.pitch_mm == pytest.approx(0.508 * LENS_SCALE, rel=2e-4)
    assert badge.print["ink_growth_um"] == printer.ink_growth_um == pytest.approx(GROWTH_UM, abs=8)
    assert load_printer_profile("mine") == msgspec.structs.replace(printer, name="mine")

    true = 0.508 * LENS_SCALE / badge.lens.pitch_mm
    scene = Scene(badge, Build(lens_scale=true, twist_rad=TWIST_RAD, air_gap_mm=AIR_MM, lens_offset_mm=0.1))
    for number in (1, 2):
        motion = motion_named("handheld", distance_mm=1000.0, seed=number)
        made = tmp_path / f"badge-film-{number}.mp4"
        film(scene, motion, made, frames=180, fps=30.0, seed=number)
        made.rename(folder / made.name)
    done = call(folder)
    assert done["did"] == ["films"] and done["done"] and done["refused"] is None
    assert call(folder)["did"] == []
    builders = {"sheet-photo.jpg", "badge-film-1.mp4", "badge-film-2.mp4"}
    assert {path.name for path in folder.iterdir()} == {*OWN_FILES, STATE, *builders}

    figures = {figure["name"]: figure for figure in done["figures"]}
    for name, value in {
        "Sheet pitch": 0.508 * LENS_SCALE,
        "Ink spread": GROWTH_UM,
        "Air under the sheet": AIR_MM,
        "Twist": -np.degrees(TWIST_RAD),
        "Pitch on the badge": 0.508 * LENS_SCALE,
    }.items():
        assert abs(figures[name]["value"] - value) < 3 * figures[name]["sd"], figures[name]
    assert figures["Air under the sheet"]["sd"] < 0.04
