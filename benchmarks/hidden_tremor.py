"""What a hand's tremor costs that hides between the frames: run `.venv/bin/python benchmarks/hidden_tremor.py`.

A measured run of a hand, from several moments on, before a badge at 1.1 m, filmed at 15, 30 and 60 frames a second by a
rolling shutter of 12 ms; corners with 0.05 px of noise, without pictures.  Printed are root mean squares over films,
along x and y together: by how much the parallax spreads too widely or too narrowly, its error bar, the error of
single poses, and the estimate of that error; with the rows' slack, and without it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.designer import Request, design_badge
from moireid.simulate.motion import measured_run
from moireid.verifier.camera import self_calibration
from moireid.verifier.camera.fit import fit_camera
from moireid.verifier.tracking.patches import marker_corners_mm

Array = NDArray[np.float64]
DISTANCE_MM, FOCAL_PX, SIZE, SHUTTER_S, NOISE_PX = 1100.0, 1150.0, (1280, 720), 0.012, 0.05
STARTS_S, SECONDS, RATES = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0), 6.0, (15, 30, 60)
#: No share of what is left is a tremor then.
OFF = 2.0


def corners(page_mm: Array, times_s: Array, start_s: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Registered corners (T, N, 2) px, and the true parallax coordinates (T, 2)."""
    run, middle = measured_run(DISTANCE_MM), np.append(page_mm.mean(axis=0), 0.0)
    plane = np.column_stack([page_mm, np.zeros(len(page_mm))]) - middle

    def seen(at: Array, places: Array) -> Array:
        poses = run(at + start_s)
        local = Rotation.from_matrix(poses.rotation).as_matrix() @ (places - poses.camera_mm)[..., None]
        return np.asarray(FOCAL_PX * local[:, :2, 0] / local[:, 2:, 0] + (np.array(SIZE) - 1) / 2)

    points = np.stack([seen(times_s, place) for place in plane], axis=1)
    for _ in range(4):
        late = SHUTTER_S * (points[..., 1] / SIZE[1] - 0.5)
        points = np.stack([seen(times_s + late[:, k], plane[k]) for k in range(len(plane))], axis=1)
    noisy = points + NOISE_PX * rng.standard_normal(points.shape)
    maps = [cv2.findHomography(page_mm, frame)[0] for frame in noisy]
    camera = run(times_s + start_s).camera_mm
    return np.array([cv2.perspectiveTransform(page_mm[:, None], one)[:, 0] for one in maps]), (
        camera[:, :2] / np.abs(camera[:, 2:])
    )


def figures(page_mm: Array, fps: int, start_s: float) -> Array:
    """Error of the parallax's spread, its error bar, error of a pose, and the estimate of it; along x and y, (4, 2)."""
    times = np.arange(int(SECONDS * fps)) / fps
    points, true = corners(page_mm, times, start_s, np.random.default_rng(1))
    fit = fit_camera(points, page_mm, times, SIZE)
    found = (fit.camera_mm[:, :2] - page_mm.mean(axis=0)) / np.abs(fit.camera_mm[:, 2:])
    true = true - true.mean(axis=0)
    width = (true * found).sum(axis=0) / (true**2).sum(axis=0)
    return np.array([width - 1, fit.tangent_sd, np.std(found - true, axis=0), fit.tangent_error])


def main() -> None:
    """One line a frame rate, with slack and without."""
    page_mm = marker_corners_mm(design_badge(Request("Bench"), bytes(range(8))).markers).reshape(-1, 2)
    usual = self_calibration.LEAST_HIDDEN
    print(f"{'frames/s':>9}{'slack':>7}{'width off':>11}{'error bar':>11}{'pose off':>10}{'stated':>8}")
    for fps in RATES:
        for slack in (True, False):
            self_calibration.LEAST_HIDDEN = usual if slack else OFF
            films = np.array([figures(page_mm, fps, start_s) for start_s in STARTS_S])
            off, bar, pose, stated = np.sqrt((films**2).mean(axis=(0, 2)))
            print(
                f"{fps:>9}{'yes' if slack else 'no':>7}{off:>11.3f}{bar:>11.3f}{pose:>10.4f}{stated:>8.4f}", flush=True
            )


if __name__ == "__main__":
    main()
