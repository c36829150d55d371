"""Charts are read by a sealed process, and its answers are checked.  Each test names the fault that it catches."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest
from click.testing import CliRunner

from kit.film_taken_over import HostileOrder
from moireid.calibration.camera_fit import CameraFound
from moireid.calibration.film_orders import CameraOrder, SheetOrder, film_read
from moireid.calibration.ink_reading import InkGrowth
from moireid.calibration.lens_fit import lens_from_band
from moireid.calibration.sheet_reading import SheetReading
from moireid.calibration.thickness import Thickness
from moireid.cli.main import moireid
from moireid.designer import design_chart
from moireid.errors import MediaError

CAMERA = {
    "size_px": [1920, 1080],
    "matrix": [[1500.0, 0.0, 960.0], [0.0, 1500.0, 540.0], [0.0, 0.0, 1.0]],
    "distortion": [0.1, 0.0, 0.0, 0.0, 0.0],
    "focal_sd_px": 1.0,
    "error_px": 0.1,
    "views": 12,
    "cover": [0.9, 0.8],
}


class TakenOver:
    """A reader that answers what the attacker likes."""

    sealed = ()

    def __init__(self, said: Any) -> None:
        self.said = said

    def read(self, order: Any, progress: Any, answer: Any = None) -> dict[str, Any]:
        return {"result": self.said}


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such means")
@pytest.mark.parametrize("chart", ["sheet", "camera"])
def test_a_film_of_a_chart_reaches_no_other_file(chart: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a chart's film that is decoded in the process of the command, with the user's files open to it."""
    (tmp_path / "secret").write_text("a key")
    (tmp_path / "film.mp4").write_bytes(b"a film")
    monkeypatch.chdir(tmp_path)

    for name in ("SheetOrder", "CameraOrder"):
        order = HostileOrder("steal", str(tmp_path / "secret"))
        monkeypatch.setattr(f"moireid.calibration.film_orders.{name}", lambda *given, order=order: order)
    words = ["calibrate", "film.mp4", "--camera", "--out", "camera.yaml"]
    if chart == "sheet":
        assert CliRunner().invoke(moireid, ["pitch-test", "--out", "chart"]).exit_code == 0
        words = ["calibrate", "film.mp4", "--chart", "chart/pitch-test.json", "--out", "lens.json"]
    done = CliRunner().invoke(moireid, words)
    assert done.exit_code == 2 and "Permission denied" in done.stderr and "a key" not in done.stderr, done.output
    assert "--unsealed" in CliRunner().invoke(moireid, ["calibrate", "--help"]).output


def test_a_camera_comes_through_as_it_was_found() -> None:
    """Catches: a matrix of another shape, which ends in an internal error or is written as a calibration."""
    order = CameraOrder(Path("film.mp4"))
    found = film_read(order, CameraFound, TakenOver(CAMERA), lambda *_: None)
    assert msgspec.json.decode(msgspec.json.encode(found)) == CAMERA
    for key, value in (
        ("matrix", [[1.0]]),
        ("size_px", [-1, 3]),
        ("distortion", []),
        ("views", "x"),
        ("cover", [2, 2]),
    ):
        with pytest.raises(MediaError, match="answers what no film shows"):
            film_read(order, CameraFound, TakenOver(CAMERA | {key: value}), lambda *_: None)
    with pytest.raises(MediaError, match="answers what no film shows"):
        film_read(order, CameraFound, TakenOver(None), lambda *_: None)


def test_a_sheet_comes_through_as_it_was_read() -> None:
    """Catches: figures that are lost or changed on their way from one process to the other."""
    chart = design_chart()
    made = lens_from_band(chart, 10.5, distance_mm=1000)
    found = SheetReading(made, InkGrowth(12.0, 3.0, "", 0.01, 2), Thickness(0.5, 0.01), "--distance")
    order = SheetOrder(Path("film.mp4"), chart)
    said = msgspec.json.decode(msgspec.json.encode(msgspec.to_builtins(found)))
    assert film_read(order, SheetReading, TakenOver(said), lambda *_: None) == found
    for key, value in (("ink", None), ("profile", []), ("thickness", 3)):
        with pytest.raises(MediaError, match="answers what no film shows"):
            film_read(order, SheetReading, TakenOver(said | {key: value}), lambda *_: None)
