"""Steps before there is a badge, with readers that cost nothing.  Next to each test: the fault that it catches."""

from __future__ import annotations

from pathlib import Path

import pytest

from moireid.bringup import chart_steps
from moireid.bringup.build_folder import BuildFolder, Figure, open_folder
from moireid.calibration.camera_fit import CameraFound
from moireid.calibration.ink_reading import InkGrowth
from moireid.calibration.sheet_reading import SheetReading
from moireid.designer.chart import design_chart
from moireid.fabrication.page.chart_page import print_chart
from moireid.profiles import LensProfile, lens_named, load_lens_profile
from moireid.verifier.camera.known_camera import load_camera

FOUND = {"unit": "printed page", "bands": 21, "bands_used": 15, "matching_band": 11.0}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a photo that the reader takes for a sheet of 0.507 mm on a printer that widens lines by 41 um."""
    open_folder(tmp_path).save()
    print_chart(design_chart(), tmp_path)
    (tmp_path / "sheet-photo.jpg").write_text("a photo")
    profile = LensProfile("mine", lens_named("50lpi"), 2e-5, FOUND)
    reading = SheetReading(profile, InkGrowth(41.0, 4.0, "", 0.002, 1), "a tape measure")
    monkeypatch.setattr(chart_steps, "read_sheet", lambda *_, **__: reading)
    return tmp_path


def read(folder: BuildFolder) -> dict[str, Figure]:
    return {figure.name: figure for figure in chart_steps.read_charts(folder, None).figures}


def test_a_calliper_counts_before_the_label(folder: Path):
    """Catches: the label's thickness that looks measured; a profile without the calliper's."""
    assert read(open_folder(folder))["Sheet thickness"].value is None
    assert read(open_folder(folder, {"thickness_mm": 0.97}))["Sheet thickness"].value == 0.97
    assert load_lens_profile(folder / "sheet.json").lens.thickness_mm == 0.97


def test_a_film_that_may_be_left_out_cannot_spoil_the_rest(folder: Path):
    """Catches: a film that ends the round; the path of a file among the figures, which are shared."""
    (folder / "camera-film.mp4").write_text("no film")
    reading = chart_steps.calibrate(open_folder(folder), None)
    (figure,) = reading.figures
    assert str(folder) in reading.notes[0] and str(folder) not in figure.words + figure.advice
    assert reading.refused and figure.value is None and not (folder / "camera.yaml").exists()


def test_a_camera_that_was_calibrated_is_kept_with_its_figure(folder: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: figures that the state cannot hold, so that a whole calibration is lost; a file that is not read."""
    rows = ((1400.0, 0.0, 960.0), (0.0, 1400.0, 540.0), (0.0, 0.0, 1.0))
    found = CameraFound((1920, 1080), rows, (0.0, 0.0, 0.0, 0.0, 0.0), 3.0, 0.2, 20, (1, 1))
    monkeypatch.setattr(chart_steps, "camera_from_film", lambda *_, **__: found)
    (folder / "camera-film.mp4").write_text("a film")
    opened = open_folder(folder)
    reading = chart_steps.calibrate(opened, None)
    opened.with_reading("camera", reading).save()
    assert open_folder(folder).figures()[0].value == pytest.approx(1400 / 1920)
    assert load_camera(folder / "camera.yaml").focal == pytest.approx(1400 / 1920)
