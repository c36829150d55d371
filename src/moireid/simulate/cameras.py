"""Cameras: lens, shutter, exposure and the maker's picture processing; some cameras have names.

Convention: pixel centres are whole numbers, and distortion is OpenCV's (Brown's radial k1, k2 and tangential p1, p2):
a ray of slopes (x, y) meets the picture where the distorted slopes say.
Source: Brown 1966; the names and order of OpenCV's `projectPoints`, whose first four coefficients these are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.arguments import Bounds, check_values
from moireid.errors import SpecError
from moireid.simulate.compiled import njit

Array = NDArray[np.float64]
#: Least and most of a camera's figures.
BOUNDS: dict[str, Bounds] = {
    "width": (2, 16384),
    "height": (2, 16384),
    "focal_px": (1.0, 1e6),
    "shutter_s": (-1.0, 1.0),
    "noise_counts": (0.0, 128.0),
    "exposure_s": (0.0, 1.0),
    "exposure": (0.0, 1e3),
    "exposure_drift": (0.0, 0.9),
    "focus_blur_px": (0.0, 50.0),
    "sharpen": (0.0, 5.0),
}


@dataclass(frozen=True)
class Camera:
    """A camera; by default a phone's in good light.

    Parameters
    ----------
    width, height : int
        Size of the picture, px, 2 to 16384.
    focal_px : float
        Focal length, px.
    shutter_s : float
        From the first row's exposure to the last one's, s, -1 to 1; 0 for a global shutter, negative where the last row
        comes first.
    noise_counts : float
        Standard deviation of the noise at mid grey, in 8-bit counts.
    distortion : (float, float, float, float)
        k1, k2, p1, p2.
    exposure_s : float
        How long each row is open, s, at most the time of a frame; 0 for an instant.
    exposure : float
        Light gathered; at 1 white paper is just not clipped.
    exposure_drift : float
        Share by which the exposure wanders over some seconds, 0 to 0.9.
    focus_blur_px : float
        Standard deviation of defocus, px.
    sharpen : float
        Strength of the unsharp mask, with its halo, 0 to 5.
    mirror : bool
        A self-view, turned left to right after all else.
    principal_px : (float, float), optional
        Where the view axis meets the picture, px; None for the picture's centre.

    Raises
    ------
    SpecError
        For a figure out of its range.

    Notes
    -----
    Convention: pixel centres are whole numbers.  All lengths are of the picture as it is before mirroring.
    Source: Brown 1966; the names and order of OpenCV's `projectPoints`, whose first four coefficients these are.
    """

    width: int = 1920
    height: int = 1080
    focal_px: float = 1450.0
    shutter_s: float = 0.012
    noise_counts: float = 2.0
    distortion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    exposure_s: float = 0.0
    exposure: float = 1.0
    exposure_drift: float = 0.06
    focus_blur_px: float = 0.0
    sharpen: float = 0.0
    mirror: bool = False
    principal_px: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check all figures.  Raises: SpecError where no camera can have them."""
        check_values(type(self), vars(self), BOUNDS)

    @property
    def matrix(self) -> Array:
        """Intrinsic matrix (3, 3) of the undistorted camera."""
        centre = self.principal_px or ((self.width - 1) / 2, (self.height - 1) / 2)
        return np.array([[self.focal_px, 0, centre[0]], [0, self.focal_px, centre[1]], [0, 0, 1.0]])

    def project(self, points: Array) -> Array:
        """Find where points are seen.

        Parameters
        ----------
        points : array (..., 3)
            In camera coordinates, mm, with positive depth.

        Returns
        -------
        array (..., 2)
            Pixels, distorted, not mirrored.
        """
        slopes = points[..., :2] / points[..., 2:]
        return np.asarray(self._distorted(slopes) * self.focal_px + self.matrix[:2, 2])

    def _distorted(self, slopes: Array) -> Array:
        k1, k2, p1, p2 = self.distortion
        x, y = slopes[..., 0], slopes[..., 1]
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + k2 * r2)
        return np.stack(
            [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y],
            axis=-1,
        )


@njit(cache=True)
def undistorted(x: float, y: float, distortion: Any) -> tuple[float, float]:
    """Slopes of the ray that meets the picture at distorted slopes (x, y).

    Source: OpenCV's fixed-point iteration for `undistortPoints`, run until it no longer changes.
    """
    k1, k2, p1, p2 = distortion[0], distortion[1], distortion[2], distortion[3]
    u, v = x, y
    for _ in range(40):
        r2 = u * u + v * v
        radial = 1.0 + r2 * (k1 + k2 * r2)
        nu = (x - 2.0 * p1 * u * v - p2 * (r2 + 2.0 * u * u)) / radial
        nv = (y - p1 * (r2 + 2.0 * v * v) - 2.0 * p2 * u * v) / radial
        step = abs(nu - u) + abs(nv - v)
        u, v = nu, nv
        if step < 1e-9:
            break
    return u, v


#: Cameras by name.  The figures are typical of their kind, not measured of one device.
CAMERAS: dict[str, Camera] = {
    # A phone's main camera in good light, its distortion corrected by the maker.
    "phone": Camera(),
    # The same with a phone's picture processing: a slower shutter, denoised, then sharpened with a halo.
    "sharpened": Camera(exposure_s=1 / 120, noise_counts=1.5, sharpen=1.0),
    # A laptop's camera: 720p, wide, slow, a little soft, distortion not corrected.
    "webcam": Camera(
        1280,
        720,
        900.0,
        shutter_s=0.016,
        noise_counts=3.0,
        distortion=(-0.06, 0.015, 0.0004, -0.0003),
        exposure_s=1 / 100,
        focus_blur_px=0.6,
        exposure_drift=0.1,
    ),
    # A phone's second, very wide lens, uncorrected.
    "wide": Camera(focal_px=900.0, distortion=(-0.12, 0.02, 0.0005, -0.0003)),
    # A room in the evening: exposed as long as 30 frames a second allow, and still dark and noisy.
    "dim": Camera(exposure_s=1 / 30, exposure=0.35, noise_counts=9.0, exposure_drift=0.15),
    # A window behind the camera: paper clips to white.
    "bright": Camera(exposure=1.8, noise_counts=1.5),
    # No camera's faults at all, as path tracers render.
    "ideal": Camera(shutter_s=0.0, noise_counts=0.0, exposure_drift=0.0),
}


def camera_named(name: str) -> Camera:
    """Give a camera by name.

    Parameters
    ----------
    name : str
        One of `moireid.simulate.cameras.CAMERAS`, such as "phone" or "webcam".

    Returns
    -------
    Camera
        The camera.

    Raises
    ------
    SpecError
        For a name that is none.
    """
    if name not in CAMERAS:
        raise SpecError(f"camera {name!r} is not known; choose one of {', '.join(CAMERAS)}")
    return CAMERAS[name]
