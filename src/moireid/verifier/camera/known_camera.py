"""A camera that was calibrated before: its focal length, axis and distortion, from a file.

With it the film-wide search has only the shutter and the print left, and the gain's error bar loses what the camera's
own unknowns add.  OpenCV's calibration files are read (YAML, XML or JSON, as `cv2.FileStorage` writes them:
`camera_matrix`, `distortion_coefficients`, `image_width`, `image_height`), and gyroflow's lens profiles (JSON, of
OpenCV's fisheye model).

Convention: lengths in long sides of the picture, so that a calibration holds for films of any size that show the whole
picture; axis from the picture's middle, x right, y down; distortion as k1 and k2 of Brown's model (OpenCV's), in units
of the focal length.  Other coefficients are fitted by these two over the picture; what is tangential is left out.
Source: OpenCV's camera models (`calib3d`): x (1 + k1 r^2 + k2 r^4 + k3 r^6) over (1 + k4 r^2 + k5 r^4 + k6 r^6), and
    for a fisheye theta (1 + k1 theta^2 + ... + k4 theta^8), theta the angle off the axis.
"""

from __future__ import annotations

import json
import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError, SpecError
from moireid.files import AnyPath, as_path, read_regular
from moireid.question import KnownCamera
from moireid.verifier.camera.distortion import FAR

Array = NDArray[np.float64]
#: Radii at which two terms are fitted to another model's distortion.
RADII = 50
#: A shorter focal length is none of a flat picture, whose ends would be 79 degrees aside; mostly it is one in mm.
LEAST_FOCAL_SHARE = 0.1
#: Distortion is taken off before pixels are made square, which is wrong by 0.1 % of the slope at this aspect.
MOST_ASPECT = 1.03


def load_camera(path: AnyPath) -> KnownCamera:
    """Read a calibration: a file of OpenCV, or a lens profile of gyroflow.

    Raises
    ------
    MediaError
        If the file cannot be read.
    SpecError
        If it holds no calibration, or one that no camera has.
    """
    path = as_path(path)
    try:
        text = read_regular(path).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no text"
        raise MediaError(f"camera file {path} cannot be read ({why}); give the path of a calibration") from error
    try:
        return _gyroflow(text) or _opencv(text)
    # OpenCV's parser has an error of its own for each way in which a file may be odd.
    except (cv2.error, ValueError, TypeError, KeyError, OverflowError, RecursionError, SystemError) as error:
        raise SpecError(
            f"camera file {path} holds no calibration that can be read; allowed are OpenCV's files (camera_matrix, "
            "distortion_coefficients, image_width and image_height) and lens profiles of gyroflow; moireid "
            "calibrate makes one from a film of the chart"
        ) from error


def _gyroflow(text: str) -> KnownCamera | None:
    """The camera of a lens profile; None for any other file.  Raises: many errors, for one that is damaged."""
    try:
        document = json.loads(text)
    except json.JSONDecodeError:
        return None
    if not isinstance(document, dict) or "fisheye_params" not in document:
        return None
    size, found = document["calib_dimension"], document["fisheye_params"]
    matrix = np.array(found["camera_matrix"], float).reshape(3, 3)
    return _known((int(size["w"]), int(size["h"])), matrix, _fisheye([float(k) for k in found["distortion_coeffs"]]))


def _opencv(text: str) -> KnownCamera:
    """The camera of a file of OpenCV.  Raises: many errors, for one that is damaged, or of something else."""
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    matrix, strengths = (storage.getNode(name).mat() for name in ("camera_matrix", "distortion_coefficients"))
    width, height = (int(storage.getNode(name).real()) for name in ("image_width", "image_height"))
    if matrix is None or matrix.shape != (3, 3) or strengths is None:
        raise ValueError("the camera matrix must be 3 x 3, and the distortion a row of numbers")
    return _known((width, height), matrix, _rational([float(k) for k in strengths.ravel()]))


def _known(size_px: tuple[int, int], matrix: Array, displaced: Any) -> KnownCamera:
    """From OpenCV's camera matrix; displaced: from radii (N,) to distorted radii, in focal lengths."""
    long_side = max(size_px)
    focal_x, focal_y = float(matrix[0, 0]), float(matrix[1, 1])
    if min(size_px) < 1 or not LEAST_FOCAL_SHARE * long_side <= focal_x < math.inf or not math.isfinite(focal_y):
        raise SpecError(
            f"the camera file states a focal length of {focal_x:g} x {focal_y:g} px for pictures of {size_px[0]} x "
            f"{size_px[1]} px; allowed is {LEAST_FOCAL_SHARE:g} of the long side or more, in pixels and not in mm"
        )
    if not 1 / MOST_ASPECT < focal_x / focal_y < MOST_ASPECT:
        raise SpecError(
            f"the camera file states pixels {focal_x / focal_y:.3f} times as long as wide, allowed is up to "
            f"{MOST_ASPECT:g}; calibrate with films whose pixels are square"
        )
    axis = (matrix[0, 2] - (size_px[0] - 1) / 2) / long_side, (matrix[1, 2] - (size_px[1] - 1) / 2) / long_side
    radii = np.linspace(0, min(math.hypot(*size_px) / 2 / focal_x, FAR), RADII + 1)[1:]
    table = np.column_stack([radii**3, radii**5])
    bent = displaced(radii) - radii
    if not (np.isfinite(bent).all() and np.isfinite(axis).all()):
        raise SpecError("the camera file holds a distortion or an axis that is no number; calibrate the camera again")
    (k1, k2), *_ = np.linalg.lstsq(table, bent, rcond=None)
    return KnownCamera(
        focal_y / long_side, size_px, (float(axis[0]), float(axis[1])), focal_x / focal_y, float(k1), float(k2)
    )


def _rational(strengths: list[float]) -> Any:
    """OpenCV's radial model, k1, k2, (p1, p2,) k3 to k6."""
    k1, k2, _, _, *more = (strengths + 8 * [0.0])[:8]
    terms, at = np.array([k1, k2, 0, 0, *more]), np.zeros(3)
    return lambda radii: cv2.projectPoints(_along(radii), at, at, np.eye(3), terms)[0][:, 0, 0]


def _fisheye(strengths: list[float]) -> Any:
    terms, at = np.array((strengths + 4 * [0.0])[:4]), np.zeros(3)
    return lambda radii: cv2.fisheye.projectPoints(_along(radii)[None], at, at, np.eye(3), terms)[0][0, :, 0]


def _along(radii: Array) -> Array:
    """Points at unit distance, to the right of the axis."""
    return np.column_stack([radii, np.zeros_like(radii), np.ones_like(radii)])
