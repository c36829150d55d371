"""A sheet's thickness from the fringes' motion.  Each test names the fault that it catches."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from moireid.calibration.thickness import Thickness, thickness_of_gain, with_fringes, with_thickness
from moireid.cli.main import moireid
from moireid.designer.chart import design_chart
from moireid.fabrication.page.chart_page import JSON, print_chart
from moireid.profiles import LensProfile, lens_named, load_lens_profile, save_profile
from moireid.sheets import effective_gap_mm, sheet_lens
from moireid.simulate import Build, Scene, film, motion_named


def test_gain_and_thickness_are_each_other_s_inverse():
    """Catches: thickness in proportion to the gain, 5 % off for thin sheets; a thickness from an impossible gain."""
    chart = design_chart("75lpi")
    pitch = chart.gratings[0].pitch_mm
    own = effective_gap_mm(chart.lens, pitch)
    for thickness in (0.457, 0.6, 0.67, 1.0):
        sheet = sheet_lens(chart.lens.pitch_mm, thickness, chart.lens.refractive_index)
        assert thickness_of_gain(chart, effective_gap_mm(sheet, pitch) / own) == pytest.approx(thickness, rel=0.01)
    assert thickness_of_gain(chart, 0.2) is None and thickness_of_gain(chart, 5.0) is None


def test_bands_without_a_whole_fringe_say_nothing_of_the_thickness():
    """Catches: a sheet that is just as its label says, whose own band is taken for rows that move apart."""
    chart = design_chart("62lpi-27mil")
    (grating,) = chart.gratings
    own = {cell.rect_mm for cell in grating.cells} - {
        cell.rect_mm for cell in with_fringes(chart, 11.0).gratings[0].cells
    }
    # 0.1 lines per inch apart on 137 mm, neighbouring bands differ by half a fringe.
    assert own == {cell.rect_mm for cell in grating.cells[9:12]}


def test_a_profile_of_a_thin_sheet_is_read_back(tmp_path):
    """Catches: a thin sheet whose cylinders do not meet as it is read; a film without a result changing the label."""
    profile = LensProfile("mine", lens_named("75lpi"), 1e-4, {"how": "a test"})
    assert with_thickness(profile, Thickness(why="still")) is profile
    thin = with_thickness(profile, Thickness(0.457, 0.012))
    save_profile(thin, tmp_path / "thin.json")
    read = load_lens_profile(tmp_path / "thin.json")
    assert read.lens.thickness_mm == 0.457 and read.found["thickness_sd_mm"] == 0.012


@pytest.mark.slow
def test_a_film_of_the_chart_gives_the_sheet_s_thickness(tmp_path: Path):
    """Catches: the label's thickness kept; the design's gain expected of a sheet that is to be measured."""
    chart = design_chart("75lpi")
    print_chart(chart, tmp_path)
    scene = Scene(chart, Build(thickness_ratio=0.457 / 0.67))
    film(scene, motion_named("handheld", distance_mm=1000.0, seed=1), tmp_path / "a.mp4", frames=120, fps=30.0, seed=1)
    wish = [tmp_path / "a.mp4", "--chart", tmp_path / JSON, "--out", tmp_path / "my.json", "--distance", "1", "--json"]
    ran = CliRunner().invoke(moireid, ["calibrate", *map(str, wish)])
    assert ran.exit_code == 0, ran.output
    printed = json.loads(ran.stdout)
    assert abs(printed["thickness_mm"] - 0.457) < 3 * printed["from"]["thickness_sd_mm"] < 0.1
