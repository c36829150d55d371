"""The fringe fields of a badge in some frames of a film, rectified; nothing else of the film.

The picture is resampled onto the page, and cut at the fields' borders.  A hand before the fields would be in it; faces,
rooms and names are not, as they lie outside.

Convention: page millimetres; grey counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.frames import Rect
from moireid.verifier.session.result import Report
from moireid.verifier.video import Film

#: Frames of a film, spread over the fringes' way; pixels to a millimetre at most.
CROPS, MOST_PX_PER_MM = 6, 4.0


@dataclass(frozen=True)
class FieldCrop:
    """The fields in one frame; number: among the film's tracked frames; picture (height, width) grey."""

    number: int
    time_s: float
    rect_mm: Rect
    px_per_mm: float
    picture: NDArray[np.uint8]


def field_crops(report: Report, count: int = CROPS) -> list[FieldCrop]:
    """The fields in frames that are spread over the fringes' way, in the order of the predicted phase.

    Raises: MediaError where the film is no longer there.
    """
    track, found = report.track, report.measurement
    if found is None or not track.tracked:
        return []
    law = found.gratings[report.most_informative].predicted_rad
    order = np.argsort(law)
    chosen = sorted({int(order[k]) for k in np.linspace(0, len(order) - 1, count).round().astype(int)})
    rect, scale = _fields_mm(report), min(MOST_PX_PER_MM, _px_per_mm(report))
    wanted = {int(track.frame_numbers[k]): k for k in chosen}
    frames = takewhile(lambda frame: frame.index <= max(wanted), Film(Path(report.film["path"])).frames())
    crops = []
    for frame in frames:
        if (k := wanted.get(frame.index)) is not None:
            picture = frame.picture.mirrored() if track.mirrored else frame.picture
            cut = rectified(picture.whole, track.homographies[k], rect, scale)
            crops.append(FieldCrop(k, float(track.times_s[k]), rect, scale, cut))
    return sorted(crops, key=lambda crop: float(law[crop.number]))


def _fields_mm(report: Report) -> Rect:
    """The rectangle around all fringe fields, which holds neither name nor squares."""
    bounds = np.array([report.badge.bounds_of(grating) for grating in report.badge.gratings])
    x0, y0 = bounds[:, :2].min(axis=0)
    x1, y1 = bounds[:, 2:].max(axis=0)
    return (float(x0), float(y0), float(x1), float(y1))


def _px_per_mm(report: Report) -> float:
    """The film's own scale in its middle frame, to a tenth."""
    page = report.track.homographies[report.track.tracked // 2]
    x0, y0, x1, y1 = _fields_mm(report)
    ends = cv2.perspectiveTransform(np.array([[[x0, y0]], [[x1, y1]]]), page)
    scale = float(np.linalg.norm(ends[1] - ends[0])) / float(np.hypot(x1 - x0, y1 - y0))
    return max(0.5, round(scale, 1))


def rectified(luma: NDArray[np.uint8], page: NDArray[np.float64], rect: Rect, scale: float) -> NDArray[np.uint8]:
    """The rectangle of the page as seen in a picture, upright."""
    x0, y0, x1, y1 = rect
    place = np.array([[1 / scale, 0, x0 + 0.5 / scale], [0, 1 / scale, y0 + 0.5 / scale], [0, 0, 1.0]])
    size = (round((x1 - x0) * scale), round((y1 - y0) * scale))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpPerspective(luma, page @ place, size, flags=flags), np.uint8)
