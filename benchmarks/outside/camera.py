"""A phone's or a laptop's camera: the rays of its pixels, its shutter, its noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PHONE, LAPTOP = (1920, 1080), (1280, 720)
#: Focal length over the long side; median of measured phone profiles (gyroflow).
FOCAL_SHARE = 0.75


@dataclass(frozen=True)
class Camera:
    """One camera.

    center_px: where its axis meets the picture; k1: radial distortion, picture = true (1 + k1 r^2) as tangents;
    readout_s: from the first row to the last; exposure_s: of a row; blur_px: standard deviation of the optics' blur;
    vignetting: light lost at one focal length from the axis; white_electrons: shot noise; read_share: noise of black.
    """

    size_px: tuple[int, int]
    focal_px: float
    center_px: tuple[float, float]
    k1: float = 0.0
    readout_s: float = 0.0
    exposure_s: float = 0.0
    blur_px: float = 0.4
    vignetting: float = 0.0
    white_electrons: float = 1e9
    read_share: float = 0.0

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places in the picture, (..., 2), px, of points (..., 3) of the camera's frame."""
        flat = points[..., :2] / points[..., 2:]
        bent = flat * (1 + self.k1 * np.sum(flat * flat, axis=-1, keepdims=True))
        return bent * self.focal_px + np.asarray(self.center_px)

    def rays(self) -> NDArray[np.float32]:
        """Tangents (x/z, y/z) of the ray of each pixel's centre, (height, width, 2)."""
        x = (np.arange(self.size_px[0]) + 0.5 - self.center_px[0]) / self.focal_px
        y = (np.arange(self.size_px[1]) + 0.5 - self.center_px[1]) / self.focal_px
        bent = np.stack(np.meshgrid(x, y), axis=-1)
        true = bent
        for _ in range(5):
            true = bent / (1 + self.k1 * np.sum(true * true, axis=-1, keepdims=True))
        return true.astype(np.float32)


def drawn(rng: np.random.Generator, size_px: tuple[int, int]) -> Camera:
    """A camera as people have them; one in four exposes a row for long enough to smear."""
    focal = FOCAL_SHARE * size_px[0] * (1 + rng.uniform(-0.01, 0.01))
    center = (size_px[0] / 2 + rng.uniform(-8, 8), size_px[1] / 2 + rng.uniform(-8, 8))
    exposure = rng.uniform(8e-3, 16e-3) if rng.random() < 0.25 else rng.uniform(0.5e-3, 4e-3)
    return Camera(
        size_px,
        focal,
        center,
        k1=rng.uniform(-0.02, 0.02),
        readout_s=rng.uniform(5e-3, 25e-3),
        exposure_s=exposure,
        blur_px=rng.uniform(0.35, 0.6),
        vignetting=rng.uniform(0.1, 0.5),
        white_electrons=float(np.exp(rng.uniform(np.log(2500), np.log(20000)))),
        read_share=rng.uniform(1e-3, 4e-3),
    )
