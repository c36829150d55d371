"""Steps before there is a badge, with readers that cost nothing.  Next to each test: the fault that it catches."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import pytest

from moireid.bringup import chart_steps
from moireid.bringup.build_folder import BuildFolder, Figure, open_folder
from moireid.calibration.ink_reading import InkGrowth
from moireid.calibration.sheet_reading import SheetReading
from moireid.designer.chart import design_chart
from moireid.fabrication.page.chart_page import print_chart
from moireid.profiles import LensProfile, lens_named, load_lens_profile

FOUND = {"unit": "printed page", "distance_from": "a tape measure", "bands": 21, "bands_used": 15}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a photo that the reader takes for a sheet of 0.507 mm on a printer that widens lines by 41 um."""
    open_folder(tmp_path).save()
    print_chart(design_chart(), tmp_path)
    (tmp_path / "sheet-photo.jpg").write_text("a photo")
    profile = LensProfile("mine", lens_named("50lpi"), 2e-5, FOUND)
    reading = SheetReading(profile, InkGrowth(41.0, 4.0, "", 0.002, 1))
    monkeypatch.setattr(chart_steps, "film_read", lambda *_, **__: reading)
    return tmp_path


def read(folder: BuildFolder) -> dict[str, Figure]:
    found = chart_steps.read_charts(folder, lambda done, of: None, nullcontext)
    return {figure.name: figure for figure in found.figures}


def test_a_calliper_counts_before_the_label(folder: Path):
    """Catches: the label's thickness that looks measured; a profile without the calliper's."""
    assert read(open_folder(folder))["Sheet thickness"].value is None
    assert read(open_folder(folder, {"thickness_mm": 0.97}))["Sheet thickness"].value == 0.97
    assert load_lens_profile(folder / "sheet.json").lens.thickness_mm == 0.97
