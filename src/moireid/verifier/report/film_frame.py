"""One frame of the film as a picture: the one that shows best what was found, with the badge outlined.

The film is opened again for it, and must still be the file that was judged.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError
from moireid.verifier.session.result import Report
from moireid.verifier.tracking.track import board_px
from moireid.verifier.video import Film

Array = NDArray[np.float64]
#: Colours of the outline (red, green, blue), by verdict.
OUTLINES = {"accept": (40, 190, 110), "reject": (230, 50, 40), "inconclusive": (240, 180, 30)}
#: Width or height of the picture at most, px, and quality of its JPEG.
MOST_PX, QUALITY = 960, 82


#: A frame: its number, its time, s (None if the film's times start anew), the badge's corners (4, 2) px.
Moment = tuple[int, float | None, Array | None]


def moment_to_show(report: Report) -> Moment:
    """The frame whose fringes are furthest from the law, if they break it; else the one that shows the badge best.

    Convention: corners as `board_px`; without a badge the middle frame of the film.
    """
    track = report.track
    if not track.tracked:
        return report.frames["read"] // 2, None, None
    k = int(np.argmax(track.correlations))
    if report.measurement is not None and report.invariant.verdict == "reject":
        signal = report.measurement.gratings[report.most_informative]
        off = np.abs(signal.measured_rad - signal.predicted_rad)
        off = np.where(np.isfinite(signal.phase_sd_rad), off, -1.0)
        k = int(np.argmax(off)) if len(off) == track.tracked else k
    corners = board_px(track.badge, track.homographies[k], track.image_px[0] if track.mirrored else None)
    restarted = any(reason.code == "times" for reason in report.reasons)
    return int(track.frame_numbers[k]), None if restarted else float(track.times_s[k]), corners


def frame_picture(report: Report, moment: Moment) -> bytes | None:
    """That frame as a JPEG, in colour, the badge outlined; None if the film is gone or has changed."""
    index, time_s, corners_px = moment
    try:
        chosen = next((one["index"] for one in report.film.get("tracks", ()) if one["chosen"]), None)
        film = Film(Path(report.film["path"]), track=chosen)
        if film.described()["sha256"] != report.film["sha256"]:
            return None
        seen, turns = film.picture(index, time_s)
    except MediaError:
        return None
    seen = np.ascontiguousarray(seen)
    share = min(MOST_PX / max(seen.shape[:2]), 1.0)
    small = cv2.resize(seen, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    if corners_px is not None:
        outline = np.rint(16 * share * corners_px).astype(np.int32)[:, None]
        for colour, width in (((255, 255, 255), 6), (OUTLINES[report.verdict], 3)):
            cv2.polylines(small, [outline], True, colour, width, cv2.LINE_AA, shift=4)
    upright = np.rot90(small[:, :, ::-1], turns)
    done, coded = cv2.imencode(".jpg", upright, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return coded.tobytes() if done else None
