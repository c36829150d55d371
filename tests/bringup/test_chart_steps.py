"""Steps before there is a badge, with readers that cost nothing.  Next to each test: the fault that it catches."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from moireid.bringup import chart_steps
from moireid.bringup.bring_up import STEPS, Advance
from moireid.bringup.build_folder import BuildFolder, Figure, Reading, open_folder
from moireid.bringup.progress_page import render_progress
from moireid.calibration.camera_fit import CameraFound
from moireid.calibration.ink_reading import InkGrowth
from moireid.calibration.sheet_reading import SheetReading
from moireid.calibration.thickness import Thickness
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
    reading = SheetReading(profile, InkGrowth(41.0, 4.0, "", 0.002, 1), None, "a tape measure")
    monkeypatch.setattr(chart_steps, "read_sheet", lambda *_, **__: reading)
    return tmp_path


def read(folder: BuildFolder) -> dict[str, Figure]:
    return {figure.name: figure for figure in chart_steps.read_charts(folder, None).figures}


def test_a_calliper_counts_before_a_film_and_a_film_before_the_label(folder: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: the label's thickness that looks measured; a film that overrules the calliper; profiles without both."""
    assert read(open_folder(folder))["Sheet thickness"].state == "unknown"
    (folder / "sheet-film.mp4").write_text("a film")
    monkeypatch.setattr(chart_steps, "thickness_from_film", lambda *_, **__: Thickness(0.93, 0.02))
    assert read(open_folder(folder))["Sheet thickness"].value == 0.93
    assert load_lens_profile(folder / "sheet.json").lens.thickness_mm == 0.93
    assert read(open_folder(folder, {"thickness_mm": 0.97}))["Sheet thickness"].value == 0.97
    assert load_lens_profile(folder / "sheet.json").lens.thickness_mm == 0.97
    monkeypatch.setattr(chart_steps, "thickness_from_film", lambda *_, **__: Thickness(why="It hardly moves."))
    assert "hardly moves" in read(open_folder(folder))["Sheet thickness"].words


def test_films_that_may_be_left_out_cannot_spoil_the_rest(folder: Path):
    """Catches: a good photo refused for a film beyond it; the path of a file among the figures, which are shared."""
    for name in ("sheet-film.mp4", "camera-film.mp4"):
        (folder / name).write_text("no film")
    opened = open_folder(folder)
    for reading in (chart_steps.read_charts(opened, None), chart_steps.calibrate(opened, None)):
        assert str(folder) in reading.notes[0]
        assert not any(str(folder) in figure.words + figure.advice for figure in reading.figures)
    assert load_lens_profile(folder / "sheet.json").name == "mine"
    assert reading.refused and reading.figures[0].state == "unknown" and not (folder / "camera.yaml").exists()


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


def test_a_picture_is_whole_or_absent(folder: Path):
    """Catches: a picture that an interrupt leaves half written; one that keeps the page from being made."""
    opened = open_folder(folder)
    opened.save_picture("fringes-1.jpg", np.full((20, 30), 90, np.uint8))
    assert cv2.imread(str(folder / "fringes-1.jpg"), cv2.IMREAD_UNCHANGED).shape == (20, 30)
    with pytest.raises(cv2.error):
        opened.save_picture("empty.jpg", np.empty((0, 0), np.uint8))
    assert not list(folder.glob("*empty*"))
    shown = opened.with_reading("sheet", Reading(pictures={"fringes-1.jpg": "strip", "gone.jpg": "gone"}))
    page = render_progress(Advance(shown, STEPS, (), STEPS[-1]))
    assert page.count("data:image") == 1
