"""A camera calibrated by a film of the chart.  After each test: what it would catch."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

from kit.coded_films import written
from moireid.calibration.camera_fit import camera_from_film
from moireid.camera_chart import COLUMNS, ROWS, SQUARE_MM, chart_board
from moireid.cli.main import moireid
from moireid.errors import MediaError
from moireid.verifier.camera.known_camera import load_camera

WIDTH, HEIGHT = 960, 540
MATRIX = np.array([[760.0, 0, 490.0], [0, 760.0, 262.0], [0, 0, 1]])
DISTORTION = np.array([-0.18, 0.05, 0.0, 0.0, 0.0])
PER_MM = 4


def seen(turn: Rotation, place_mm: np.ndarray) -> np.ndarray:
    """A picture of the chart through the camera above; place_mm: of the chart's middle, in the camera's frame."""
    printed = cv2.copyMakeBorder(
        chart_board().generateImage((round(COLUMNS * SQUARE_MM * PER_MM), round(ROWS * SQUARE_MM * PER_MM))),
        *(4 * [10 * PER_MM]),
        cv2.BORDER_CONSTANT,
        value=255,
    )
    grid = np.stack(np.meshgrid(np.arange(WIDTH, dtype=float), np.arange(HEIGHT, dtype=float)), axis=-1)
    rays = cv2.undistortPoints(grid.reshape(-1, 1, 2), MATRIX, DISTORTION)[:, 0]
    plane = np.column_stack([turn.as_matrix()[:, :2], place_mm])
    found = np.linalg.solve(plane, np.column_stack([rays, np.ones(len(rays))]).T)
    on_chart = (found[:2] / found[2]).T + np.array([COLUMNS, ROWS]) * SQUARE_MM / 2 + 10
    places = (on_chart * PER_MM - 0.5).astype(np.float32).reshape(HEIGHT, WIDTH, 2)
    picture = cv2.remap(printed, places[..., 0], places[..., 1], cv2.INTER_AREA, borderValue=150)
    return cv2.GaussianBlur(picture, (0, 0), 0.7)


def film(
    path: Path, rng: np.random.Generator, *, views: int = 26, reach: float = 1.0, tilt: float = 35, near: float = 290
) -> Path:
    """The chart at rest for two frames, from each of some sides."""
    pictures = []
    for _ in range(views):
        turn = Rotation.from_euler("xyz", rng.uniform([-tilt, -tilt, 80], [tilt, tilt, 100]), degrees=True)
        far = rng.uniform(near, near + 130)
        aside = rng.uniform(-1, 1, 2) * reach * np.array([130.0, 70.0]) * far / 400
        pictures += 2 * [seen(turn, np.array([*aside, far]))]
    return written(path, pictures, "libx264", "yuv420p")


@pytest.mark.slow
def test_a_camera_is_found_by_a_film_of_its_chart(tmp_path: Path, rng: np.random.Generator):
    """Catches: corners of the wrong numbers; width and height exchanged; a file that --camera does not read."""
    made = film(tmp_path / "chart.mp4", rng)
    answer = CliRunner().invoke(
        moireid, ["calibrate", str(made), "--camera", "--out", str(tmp_path / "camera.yaml"), "--json"]
    )
    assert answer.exit_code == 0, answer.output
    found = json.loads(answer.output)
    assert found["focal_px"] == pytest.approx(760, abs=4) and found["focal_sd_px"] < 3
    assert abs(found["focal_px"] - 760) < 4 * found["focal_sd_px"] + 1
    assert found["error_px"] < 0.3 and found["views"] >= 15
    camera = load_camera(tmp_path / "camera.yaml")
    assert camera.focal == pytest.approx(760 / WIDTH, rel=0.005)
    assert camera.axis == pytest.approx((10.5 / WIDTH, -7.5 / WIDTH), abs=4 / WIDTH)
    radii = np.linspace(0.1, 0.6, 6)
    true, two = (radii * (1 + a * radii**2 + b * radii**4) for a, b in ((-0.18, 0.05), (camera.k1, camera.k2)))
    assert np.abs(two / camera.focal * 760 / WIDTH - true).max() * 760 < 3


@pytest.mark.slow
def test_a_film_that_shows_too_little_is_refused(tmp_path: Path, rng: np.random.Generator):
    """Catches: a calibration from one corner of the picture, or from views that are alike, with a small error bar."""
    with pytest.raises(MediaError, match=r"at rest in \d+ distinct views, needed are 12"):
        camera_from_film(film(tmp_path / "few.mp4", rng, views=5))
    blank = written(tmp_path / "blank.mp4", 20 * [np.full((HEIGHT, WIDTH), 128, np.uint8)], "libx264", "yuv420p")
    with pytest.raises(MediaError, match="at rest in 0 distinct views"):
        camera_from_film(blank)
    with pytest.raises(MediaError, match=r"% of the picture's width"):
        camera_from_film(film(tmp_path / "middle.mp4", rng, reach=0.0, near=480))
    with pytest.raises(MediaError, match=r"tilted by .* needed are 5 both ways"):
        camera_from_film(film(tmp_path / "front.mp4", rng, tilt=1.0))


def test_the_chart_is_printed_at_true_size(tmp_path: Path):
    """Catches: squares of another size than the board's, a chart that runs off the paper, options that conflict."""
    chart = tmp_path / "chart.pdf"
    for paper in ("a4", "letter"):
        answer = CliRunner().invoke(
            moireid, ["calibrate", "--camera", "--out", str(chart), "--paper", paper, "--overwrite"]
        )
        assert answer.exit_code == 0 and chart.read_bytes().startswith(b"%PDF")
    for wrong in (["--out", str(chart)], ["film.mp4"], ["film.mp4", "--out", "new.pdf"], ["--out", "a.yaml"]):
        answer = CliRunner().invoke(moireid, ["calibrate", "--camera", *wrong])
        assert answer.exit_code == 2
