"""A camera, calibrated by a film of the camera chart.

1. Find the chart's corners in frames all over the film.
2. Keep views in which the chart rests: a rolling shutter bends it where it moves.
3. Of these, take the views that differ most.
4. Solve, and say how well the corners fit and how much of the picture they cover.

Source: OpenCV's `calibrateCameraExtended` (Zhang, A flexible new technique for camera calibration, 2000), with the two
radial terms k1 and k2 that the verifier has; further ones would take up a part of the axis and of these.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

import cv2
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from moireid.camera_chart import chart_board
from moireid.errors import MediaError
from moireid.files import AnyPath, whole_file
from moireid.verifier.video import Film, Progress

Array = NDArray[np.float64]
Size = Annotated[int, Meta(ge=1, le=1 << 20)]
Share = Annotated[float, Meta(ge=0, le=1)]
Row = tuple[float, float, float]
#: Frames looked at, at most; corners that a view must show; views that are solved, at most and at least.
MOST_LOOKS, LEAST_CORNERS, VIEWS = 400, 20, (12, 60)
#: A corner at rest moves by less, in pictures a second: with a shutter of 20 ms, a third of a pixel of 1920.
REST_PER_S = 0.01
#: Corners must reach over this share of the picture's width and height, and fit within so many thousandths of it.
LEAST_COVER_SHARE, MOST_ERROR_PER_MILLE = 0.7, 0.8
#: Views from the front do not show the focal length: the chart's normal must scatter by so much across the direction in
#: which it scatters most, and the focal length be known to this share.  Set by hand: half of what +-15 degrees are.
LEAST_TILT_RAD, MOST_FOCAL_SD_SHARE = math.radians(5.0), 0.01
MODEL = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3


@dataclass(frozen=True)
class CameraFound:
    """A calibrated camera.

    size_px: width and height; matrix and distortion: as OpenCV has them; focal_sd_px: standard deviation
    of the focal length; error_px: root mean square over corners; views: how many were solved; cover (2,): share of the
    picture's width and height that corners reach over.
    """

    size_px: tuple[Size, Size]
    matrix: tuple[Row, Row, Row]
    distortion: tuple[float, float, float, float, float]
    focal_sd_px: Annotated[float, Meta(gt=0)]
    error_px: Annotated[float, Meta(ge=0)]
    views: Size
    cover: tuple[Share, Share]

    @property
    def focal_px(self) -> float:
        """Focal length, px."""
        return self.matrix[0][0]


@dataclass(frozen=True)
class _View:
    """One frame's corners: their numbers (N,), places (N, 2) px, and the frame's time, s."""

    numbers: NDArray[np.int64]
    places_px: Array
    time_s: float


def camera_from_film(path: AnyPath, *, progress: Progress | None = None) -> CameraFound:
    """Calibrate the camera that filmed the chart.

    Parameters
    ----------
    path : str or Path
        The film; at its full size.
    progress : callable, optional
        As for `verify`.

    Raises
    ------
    MediaError
        If the film cannot be read, shows the chart too rarely or too small, or does not fit one camera.
    """
    film = Film(path)
    size_px = film.width, film.height
    views = _distinct(_resting(_views(film, progress), size_px), size_px)
    if len(views) < VIEWS[0]:
        raise MediaError(
            f"{path} shows the camera chart at rest in {len(views)} distinct views, needed are {VIEWS[0]}; film it "
            "anew from all sides, and hold still for a moment each time"
        )
    every = np.concatenate([view.places_px for view in views])
    cover = float(np.ptp(every[:, 0]) / size_px[0]), float(np.ptp(every[:, 1]) / size_px[1])
    if min(cover) < LEAST_COVER_SHARE:
        raise MediaError(
            f"in {path} the chart reaches over {100 * cover[0]:.0f} % of the picture's width and {100 * cover[1]:.0f} "
            f"% of its height, needed are {100 * LEAST_COVER_SHARE:.0f} %; film it in every corner of the picture"
        )
    solid = np.asarray(chart_board().getChessboardCorners())
    places = [view.places_px.astype(np.float32).reshape(-1, 1, 2) for view in views]
    flat = [solid[view.numbers].astype(np.float32) for view in views]
    error_px, matrix, strengths, turns, _, sd, _, _ = cv2.calibrateCameraExtended(
        flat, places, size_px, None, None, flags=MODEL
    )
    most_px = MOST_ERROR_PER_MILLE * max(size_px) / 1000
    if not error_px <= most_px:
        raise MediaError(
            f"the chart's corners in {path} are {error_px:.2f} px off one camera, allowed are {most_px:.2f} px; film a "
            "chart that is flat, without zoom or stabilisation, and hold still"
        )
    focal_sd, tilt = float(sd.ravel()[0]), _least_tilt_rad(turns)
    if tilt < LEAST_TILT_RAD or focal_sd > MOST_FOCAL_SD_SHARE * matrix[0, 0]:
        raise MediaError(
            f"{path} shows the chart tilted by {math.degrees(tilt):.1f} degrees (standard deviation), needed are "
            f"{math.degrees(LEAST_TILT_RAD):.0f} both ways; tilt it to all four sides by 30 degrees while you film it"
        )
    rows: Any = tuple(map(tuple, matrix.tolist()))
    terms: Any = tuple(strengths.ravel().tolist())
    return CameraFound(size_px, rows, terms, focal_sd, float(error_px), len(views), cover)


def write_camera(camera: CameraFound, path: AnyPath) -> None:
    """Write a calibration as OpenCV's YAML, which `--camera` and other programs read."""
    storage = cv2.FileStorage(".yaml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    storage.write("image_width", camera.size_px[0])
    storage.write("image_height", camera.size_px[1])
    storage.write("camera_matrix", np.array(camera.matrix))
    storage.write("distortion_coefficients", np.array([camera.distortion]))
    storage.write("avg_reprojection_error", camera.error_px)
    storage.write("nframes", camera.views)
    with whole_file(path) as new:
        new.write_text(storage.releaseAndGetString(), encoding="utf-8")


def _least_tilt_rad(turns: Sequence[Any]) -> float:
    """How far the chart's normal scatters in the direction in which it does so least; turns: rotation vectors."""
    normals = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    aside = normals[:, :2] / normals[:, 2:]
    return float(np.linalg.svd(aside - aside.mean(axis=0), compute_uv=False)[-1] / math.sqrt(len(aside)))


def _views(film: Film, progress: Progress | None) -> list[_View]:
    """The chart in frames all over the film; neighbours too, as their distance says whether it rests."""
    detector, found = cv2.aruco.CharucoDetector(chart_board()), []
    count = film.frames_expected or MOST_LOOKS
    # Pairs of neighbours, evenly over the film.
    stride = max(2, 2 * math.ceil(count / MOST_LOOKS))
    for frame in film.frames():
        if progress is not None:
            progress(frame.index + 1, film.frames_expected)
        if frame.index % stride > 1:
            continue
        corners, numbers, _, _ = detector.detectBoard(frame.luma)
        if numbers is not None and len(numbers) >= LEAST_CORNERS:
            found.append(_View(numbers.ravel().astype(np.int64), corners.reshape(-1, 2).astype(float), frame.time_s))
    return found


def _resting(views: list[_View], size_px: tuple[int, int]) -> list[_View]:
    """Views that hardly differ from the one before."""
    kept = []
    for before, view in pairwise(views):
        shared, one, other = np.intersect1d(before.numbers, view.numbers, return_indices=True)
        between_s = view.time_s - before.time_s
        if len(shared) < LEAST_CORNERS or not 0 < between_s < 0.2:
            continue
        moved = np.linalg.norm(view.places_px[other] - before.places_px[one], axis=1)
        if np.median(moved) <= REST_PER_S * max(size_px) * between_s + 0.1:
            kept.append(view)
    return kept


def _distinct(views: list[_View], size_px: tuple[int, int]) -> list[_View]:
    """The views that differ most, one after the other: each the farthest from all that were taken.

    Source: farthest-point sampling (Gonzalez 1985) of the chart's four corners, by a homography of each view.
    """
    if not views:
        return []
    solid = np.asarray(chart_board().getChessboardCorners())[:, :2]
    corners = np.array([solid.min(axis=0), solid.max(axis=0)])
    square = np.array([[corners[i, 0], corners[j, 1]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    outlines = []
    for view in views:
        homography, _ = cv2.findHomography(solid[view.numbers], view.places_px)
        outlines.append(cv2.perspectiveTransform(square[None], homography)[0].ravel() / max(size_px))
    table, taken = np.array(outlines), [int(np.argmax([len(view.numbers) for view in views]))]
    apart = np.linalg.norm(table - table[taken[0]], axis=1)
    while len(taken) < min(VIEWS[1], len(views)) and apart.max() > 0.02:
        taken.append(int(apart.argmax()))
        apart = np.minimum(apart, np.linalg.norm(table - table[taken[-1]], axis=1))
    return [views[k] for k in taken]
