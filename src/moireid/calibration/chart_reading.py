"""A pitch test sheet in a picture: where the camera was, and the brightness of every band.

1. Find the chart's markers, shrink a large picture, register the page.
2. Find where the camera was.
3. Read the brightness profiles of each band in parts; blur removes lens ribs and printed lines.

Convention: page millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.dots import realised
from moireid.errors import MediaError, SpecError
from moireid.profiles import CHART_FAMILY, drawn_dot_mm
from moireid.verifier.camera.plane_pose import start_poses
from moireid.verifier.picture import LINEAR_COUNTS, counts_of
from moireid.verifier.tracking.brightness_profiles import ProfileReader
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import PageRegistrar, scale_px_per_mm

Array = NDArray[np.float64]
#: Finer pictures are shrunk to this: the fringes of a chart need no more, and registration expects sharp edges.
WORK_PX_PER_MM = 3.0
#: Blur before sampling, mm: less than 1 % is left of ribs and lines of 0.3 to 0.7 mm, and 95 % of a fringe of 10 mm.
BLUR_MM = 0.5
#: Approximate height of the parts of a band.  A twisted sheet shifts the fringes from part to part, which gives the
#: twist, up to half a turn per part (4.5 degrees at 50 lines per inch).
PART_MM = 3.0
#: Focal length over a picture's longer side, from the widest phone lens to the longest tele lens.  A distance that
#: leads to another value is a mistake, such as centimetres for metres.
LENS_RANGE = (0.25, 20.0)


@dataclass(frozen=True)
class ChartView:
    """One registered picture of the chart.

    Parameters
    ----------
    camera_mm : array (3,)
        Camera centre, page mm; z is negative before the page.
    profiles : array (P, N)
        Brightness along each part of each band, light and not coded counts.
    page : array (3, 3), optional
        Homography from the page, mm, to the picture as it was given, px.

    Notes
    -----
    Convention: P parts as `moireid.calibration.chart_reading.parts_of` has them, from top to bottom; N samples along x.
    """

    camera_mm: Array
    profiles: Array
    page: Array | None = None


def check_chart(chart: Badge) -> None:
    """Raise SpecError unless the badge is a pitch test sheet: bands below one another that grow finer downwards."""
    grating, *others = chart.gratings
    rects = np.array([cell.rect_mm for cell in grating.cells]).reshape(-1, 4)
    finer = np.all(np.diff([cell.pitch_mm for cell in grating.cells]) < 0)
    below = np.all(rects[1:, 1] >= rects[:-1, 3] - 1e-6) and np.all(
        np.abs(rects[:, [0, 2]] - rects[:1, [0, 2]]) <= 1e-6
    )
    one = not others and grating.family == CHART_FAMILY and grating.axis == "x" and chart.lens.kind == "lenticular"
    if not (one and finer and below) or len(rects) < 3:
        raise SpecError(
            f"{chart.name!r} is no pitch test sheet; give the pitch-test.json that moireid pitch-test wrote"
        )


def printed_frequencies(chart: Badge) -> Array:
    """Line frequency of every band as printed, cycles per mm: on whole dots if the form says so.

    Convention: in the order of the cells, which is that of the bands' numbers.  Source: `dots.realised`.
    """
    grating, dot_mm = chart.gratings[0], drawn_dot_mm(chart)
    pitches = np.array([cell.pitch_mm for cell in grating.cells])
    if dot_mm is not None:
        pitches = pitches * [
            1 + realised(grating, cell, chart.lens.pitch_mm, dot_mm).pitch_error for cell in grating.cells
        ]
    return np.asarray(1 / pitches)


def view_chart(
    luma: NDArray[np.uint8], chart: Badge, *, focal_px: float, distance_mm: float | None = None
) -> ChartView:
    """Find the chart in a picture and read its bands.

    Parameters
    ----------
    luma : array (height, width) of uint8
        The picture, grey.
    chart : Badge
        The pitch test sheet.
    focal_px : float
        Focal length of this picture, px: for the direction, and for the distance unless that is given.
    distance_mm : float, optional
        From the camera to the middle of the sheet, mm.

    Returns
    -------
    ChartView
        The camera's position and the brightness of every band.

    Raises
    ------
    MediaError
        Where the picture does not show the chart.
    SpecError
        Where no camera could show it so large from that distance.

    Notes
    -----
    Convention: the principal point is the picture's centre.
    Source: `markers`, `registration`, `plane_pose` and `profiles` of the verifier.
    """
    start = _found(luma, chart)
    corners_mm = marker_corners_mm(chart.squares).reshape(-1, 2)
    middle_mm = corners_mm.mean(axis=0)
    shrink = WORK_PX_PER_MM / scale_px_per_mm(start, middle_mm)
    # Average light and not counts: over ink and paper, a mean of coded counts is wrong by a tenth.
    light, change = LINEAR_COUNTS[luma], np.eye(3)
    if shrink < 1:
        light, change = _shrunk(light, shrink)
        start = change @ start
        start /= start[2, 2]
        luma = counts_of(light)
        focal_px *= shrink
    registered = PageRegistrar(chart.squares).register(luma, start)
    if registered is None:
        raise MediaError(
            "the picture's markers do not match the chart's page; photograph it flat, sharp, with all four squares "
            "free, and give the pitch-test.json of this very chart"
        )
    homography = registered.homography
    camera = _camera_mm(homography, corners_mm, luma.shape, focal_px, distance_mm)
    blur_px = BLUR_MM * scale_px_per_mm(homography, middle_mm)
    smooth = np.asarray(cv2.GaussianBlur(light, (0, 0), blur_px))
    profiles = ProfileReader(parts_of(chart)).read_light(smooth, homography)
    return ChartView(camera, np.asarray(profiles, float), np.linalg.inv(change) @ homography)


def _found(luma: NDArray[np.uint8], chart: Badge) -> Array:
    """A first homography of the chart's page, by its markers."""
    finder = MarkerFinder(chart.squares)
    pages = finder.pages(luma) or finder.pages(luma, faint=True)
    if not pages:
        raise MediaError(
            f"the picture does not show this chart (markers {list(chart.squares.ids)} are not found); photograph the "
            "whole chart, sharp and evenly lit, and give the pitch-test.json of this very chart"
        )
    return pages[0]


def _camera_mm(
    homography: Array, corners_mm: Array, shape: tuple[int, ...], focal_px: float, distance_mm: float | None
) -> Array:
    """Camera centre, page mm, from the page's homography; at `distance_mm` from the sheet if that is given."""
    centre, middle_mm = ((shape[1] - 1) / 2, (shape[0] - 1) / 2), corners_mm.mean(axis=0)
    mapped = np.column_stack([corners_mm, np.ones(len(corners_mm))]) @ homography.T
    plane = np.column_stack([corners_mm - middle_mm, np.zeros(len(corners_mm))])
    poses = start_poses(plane, (mapped[:, :2] / mapped[:, 2:])[None], focal_px, centre)
    camera = poses.camera[0, int(poses.error_px[0].argmin())]
    if distance_mm is not None:
        guessed_mm = float(np.linalg.norm(camera))
        least, most = (share * max(shape) / focal_px * guessed_mm / 1000 for share in LENS_RANGE)
        if not least <= distance_mm / 1000 <= most:
            raise SpecError(
                f"a distance of {distance_mm / 1000:g} m does not go with the picture, in which a camera shows the "
                f"chart so large from {least:.2g} to {most:.2g} m; give distance_m= in metres, or leave it out"
            )
        camera = camera * distance_mm / np.linalg.norm(camera)
    return np.asarray(camera + np.append(middle_mm, 0.0), float)


def parts_of(chart: Badge) -> Badge:
    """The chart with every band cut into the same number of parts, about `PART_MM` high, from top to bottom."""
    grating = chart.gratings[0]
    cells = []
    for cell in grating.cells:
        x0, y0, x1, y1 = cell.rect_mm
        count = parts_in_a_band(chart)
        edges = np.linspace(y0, y1, count + 1)
        cells += [replace(cell, rect_mm=(x0, float(edges[k]), x1, float(edges[k + 1]))) for k in range(count)]
    return replace(chart, gratings=(replace(grating, cells=tuple(cells)),))


def parts_in_a_band(chart: Badge) -> int:
    """Number of parts of every band; at least two, which the twist needs."""
    lowest = min(cell.rect_mm[3] - cell.rect_mm[1] for cell in chart.gratings[0].cells)
    return max(2, round(lowest / PART_MM))


def _shrunk(light: NDArray[np.float32], share: float) -> tuple[NDArray[np.float32], Array]:
    """The picture scaled by `share`, and the homography to it; areas are averaged, and pixel edges stay in place."""
    size = (round(light.shape[1] * share), round(light.shape[0] * share))
    x, y = size[0] / light.shape[1], size[1] / light.shape[0]
    change = np.array([[x, 0, (x - 1) / 2], [0, y, (y - 1) / 2], [0, 0, 1.0]])
    return np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_AREA)), change
