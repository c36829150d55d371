"""The pitch test sheet read back from a photograph by the program, end to end."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from moireid.cli.main import moireid
from moireid.designer.chart import design_chart
from moireid.fabrication.page.chart_page import JSON, print_chart
from moireid.profiles import lens_named
from moireid_lab.bench.fabricate.calibration import STILL, PhotoCase, calibration_figures, photograph

CASE = PhotoCase("50lpi", lens_scale=1.0023, twist_deg=0.7, distance_m=0.9, aside_deg=9.0)


@pytest.fixture(scope="module")
def chart_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A chart as printed, and a photograph of it as a phone writes one."""
    folder = tmp_path_factory.mktemp("chart")
    chart = design_chart(lens=CASE.lens)
    print_chart(chart, folder)
    picture = Image.fromarray(photograph(chart, CASE, 5))
    exif = Image.Exif()
    # 35 mm film has a diagonal of 43.27 mm, this picture one of 5000 px.
    exif.get_ifd(0x8769)[0xA405] = round(STILL.focal_px * 43.2666 / np.hypot(STILL.width, STILL.height))
    picture.save(folder / "photo.jpg", quality=90, exif=exif)
    return folder


def calibrate(*arguments: str | Path) -> dict:
    """What the program answers."""
    ran = CliRunner().invoke(moireid, ["calibrate", *map(str, arguments), "--json"])
    assert ran.exit_code == 0, ran.output
    return json.loads(ran.stdout)


@pytest.mark.claim("A photograph of the pitch test measures the sheet's pitch")
@pytest.mark.slow
def test_a_photograph_tells_the_pitch_and_the_twist(chart_folder, tmp_path):
    """Catches: counts taken for light, a pitch of the wrong sense, a twist left out, an EXIF note unread."""
    out = tmp_path / "mine.json"
    document = calibrate(chart_folder / "photo.jpg", "--chart", chart_folder / JSON, "--out", out)
    assert document["pitch_mm"] == pytest.approx(0.508 * CASE.lens_scale, rel=1e-4)
    assert abs(document["pitch_mm"] - 0.508 * CASE.lens_scale) < 3 * document["pitch_sd_mm"] < 3e-4 * 0.508
    assert abs(document["from"]["twist_deg"]) == pytest.approx(CASE.twist_deg, abs=0.02)
    assert document["from"]["distance_from"] == "the camera's note"
    assert lens_named(str(out)).pitch_mm == document["pitch_mm"]


@pytest.mark.parametrize("metres", ["90", "0.15"])
def test_a_distance_that_the_picture_contradicts_is_refused(chart_folder, tmp_path, metres):
    """Catches: centimetres taken for metres, which moved the pitch beyond its error bar in silence."""
    wish = ["--chart", chart_folder / JSON, "--out", tmp_path / "no.json", "--distance", metres]
    ran = CliRunner().invoke(moireid, ["calibrate", str(chart_folder / "photo.jpg"), *map(str, wish)])
    assert ran.exit_code == 2 and "in metres" in ran.stderr and not (tmp_path / "no.json").exists()


@pytest.mark.slow
def test_a_ruler_turns_page_units_into_millimetres(chart_folder, tmp_path):
    """Catches: the measured scale divided by, or left out of the profile that badges are made with."""
    photo, chart = chart_folder / "photo.jpg", chart_folder / JSON
    plain = calibrate(photo, "--chart", chart, "--out", tmp_path / "page.json")
    ruled = calibrate(photo, "--chart", chart, "--out", tmp_path / "true.json", "--measured-scale", "0.998")
    assert ruled["pitch_mm"] == pytest.approx(0.998 * plain["pitch_mm"], rel=1e-12)
    assert (plain["from"]["unit"], ruled["from"]["unit"]) == ("printed page", "true mm")


@pytest.mark.slow
def test_the_bench_photographs_are_read_within_a_fiftieth_of_a_percent():
    """Catches: errors that grow with distance, place or label; error bars that are empty words."""
    found = calibration_figures(count=2, seed=3)
    assert found["read"] == 2 and found["worst_error_percent"] < 0.02
    assert max(abs(row["in_sd"]) for row in found["rows"]) < 3
