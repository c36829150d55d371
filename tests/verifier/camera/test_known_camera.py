"""Cameras that were calibrated before.  After each test: what it would catch."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from kit.made_corners import FPS, PAGE_MM, SIZE, Course, project, registered
from moireid.errors import MediaError, SpecError
from moireid.verifier.camera.fit import fit_camera
from moireid.verifier.camera.known_camera import load_camera

MATRIX = np.array([[1450.0, 0, 979.5], [0, 1450.0, 519.5], [0, 0, 1.0]])


def opencv_file(path: Path, matrix: np.ndarray = MATRIX, strengths: tuple[float, ...] = (-0.2, 0.06, 0, 0)) -> Path:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("camera_matrix", matrix)
    storage.write("distortion_coefficients", np.array([strengths]))
    storage.write("image_width", SIZE[0])
    storage.write("image_height", SIZE[1])
    storage.release()
    return path


@pytest.mark.parametrize("name", ["camera.yaml", "camera.xml", "camera.json"])
def test_opencv_s_files_are_read(tmp_path: Path, name: str):
    """Catches: pixels for long sides; an axis from the corner; pixel centres half a pixel off."""
    found = load_camera(opencv_file(tmp_path / name))
    assert found.size_px == SIZE and found.aspect == 1.0
    assert found.focal == pytest.approx(1450 / 1920) and found.axis == pytest.approx((20 / 1920, -20 / 1920))
    assert (found.k1, found.k2) == pytest.approx((-0.2, 0.06), abs=1e-9)


def test_other_models_are_fitted_over_the_picture(tmp_path: Path):
    """Catches: coefficients of a fisheye or of k3 taken for those of two terms."""
    profile = {
        "calib_dimension": {"w": 3840, "h": 2160},
        "fisheye_params": {
            "camera_matrix": [[2700.0, 0, 1919.5], [0, 2700.0, 1079.5], [0, 0, 1]],
            "distortion_coeffs": [0.2, 0.1, -0.3, 0.2],
        },
    }
    (tmp_path / "phone.json").write_text(json.dumps(profile))
    phone = load_camera(tmp_path / "phone.json")
    radii = np.linspace(0.01, 0.8, 40)
    places = np.column_stack([radii, np.zeros(40), np.ones(40)])[None]
    seen = cv2.fisheye.projectPoints(places, np.zeros(3), np.zeros(3), np.eye(3), np.array([0.2, 0.1, -0.3, 0.2]))[0]
    two = radii * (1 + phone.k1 * radii**2 + phone.k2 * radii**4)
    assert phone.focal == pytest.approx(2700 / 3840) and np.abs(two - seen[0, :, 0]).max() * 2700 < 2.0
    third = load_camera(opencv_file(tmp_path / "third.yaml", strengths=(0.1, -0.2, 0, 0, 0.08)))
    assert third.k2 > -0.2 and third.k1 < 0.1


def test_a_known_camera_gives_exact_poses(rng: np.random.Generator, tmp_path: Path):
    """Catches: the axis or the distortion of the wrong sign; a search that changes what is known."""
    times = np.arange(40) / FPS
    camera, turn = Course(rng, 900.0).pose(times)
    seen = (project(camera, turn, 1450.0) - MIDDLE) / 1450.0
    square = (seen**2).sum(axis=-1, keepdims=True)
    points = seen * (1 - 0.2 * square + 0.06 * square**2) * 1450.0 + MATRIX[:2, 2]
    known = load_camera(opencv_file(tmp_path / "camera.yaml"))
    fit = fit_camera(registered(points, rng, 0.03), PAGE_MM, times, SIZE, camera=known)
    assert fit.focal_given and fit.focal_px == pytest.approx(1450.0) and fit.bend_k1 == pytest.approx(-0.2)
    assert fit.axis_px == pytest.approx((20.0, -20.0)) and max(fit.tangent_sd) < 0.003
    assert np.abs(fit.camera_mm - camera).max() < 12.0
    free = fit_camera(registered(points, rng, 0.03), PAGE_MM, times, SIZE)
    assert max(free.tangent_sd) > 1.5 * max(fit.tangent_sd)


MIDDLE = np.array([SIZE[0] - 1, SIZE[1] - 1]) / 2


def test_what_is_no_calibration_is_refused(tmp_path: Path):
    """Catches: a traceback of OpenCV's parser; a focal length in mm; a film of another part of the picture."""
    (tmp_path / "notes.txt").write_text("a camera")
    (tmp_path / "other.json").write_text('{"focal": 3}')
    (tmp_path / "profile.json").write_text('{"fisheye_params": {}}')
    (tmp_path / "list.json").write_text("[]")
    (tmp_path / "deep.json").write_text("[" * 100_000)
    (tmp_path / "words.yaml").write_text("%YAML:1.0\n---\ncamera_matrix: x\nimage_width: .Nan\n")
    ros = "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [1, 0, 0]}\n"
    (tmp_path / "ros.yaml").write_text(ros + "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0]}\n")
    for name in ("notes.txt", "other.json", "profile.json", "list.json", "deep.json", "words.yaml", "ros.yaml"):
        with pytest.raises(SpecError, match="holds no calibration that can be read"):
            load_camera(tmp_path / name)
    with pytest.raises(SpecError, match=r"pixels 1\.100 times as long as wide, allowed is up to 1\.03"):
        load_camera(opencv_file(tmp_path / "wide.yaml", np.diag([1595.0, 1450.0, 1.0])))
    with pytest.raises(MediaError, match="cannot be read"):
        load_camera(tmp_path / "none.yaml")
    assert load_camera(opencv_file(tmp_path / "tele.yaml", np.diag([15360.0, 15360.0, 1.0]))).focal == 8.0
    with pytest.raises(SpecError, match=r"allowed is 0\.1 of the long side or more, in pixels and not in mm"):
        load_camera(opencv_file(tmp_path / "mm.yaml", np.diag([4.2, 4.2, 1.0])))
    with pytest.raises(SpecError, match="that is no number"):
        load_camera(opencv_file(tmp_path / "nan.yaml", strengths=(float("nan"), 0, 0, 0)))
    with pytest.raises(SpecError, match="1920x1080 px, and the film has 1080x1920 px"):
        load_camera(opencv_file(tmp_path / "camera.yaml")).check_size((1080, 1920))
