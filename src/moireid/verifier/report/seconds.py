"""Which seconds were judged, as bars over the film's own time and in words; and one frame of the film as a picture.

The frame is the one that shows best what was found, with the badge outlined.  The film is opened again for it, and must
still be the file that was judged.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError
from moireid.verifier.report.plots import LAW
from moireid.verifier.session.cover import outside, within
from moireid.verifier.session.result import Report
from moireid.verifier.tracking.track import board_px
from moireid.verifier.video import Film

Array = NDArray[np.float64]
#: Colours of the outline (red, green, blue), by verdict.
OUTLINES = {"accept": (40, 190, 110), "reject": (230, 50, 40), "inconclusive": (240, 180, 30)}
#: Width or height of the picture at most, px, and quality of its JPEG.
MOST_PX, QUALITY = 960, 82


@dataclass(frozen=True)
class Moment:
    """A frame: its number, its time, s (None if the film's times start anew), the badge's corners (4, 2) px."""

    index: int
    time_s: float | None
    corners_px: Array | None


def moment_to_show(report: Report) -> Moment:
    """The frame whose fringes are furthest from the law, if they break it; else the one that shows the badge best.

    Convention: corners as `board_px`; without a badge the middle frame of the film.
    """
    track = report.track
    if not track.tracked:
        return Moment(report.frames["read"] // 2, None, None)
    k = int(np.argmax(track.correlations))
    if report.measurement is not None and report.invariant.verdict == "reject":
        signal = report.measurement.gratings[report.most_informative]
        off = np.abs(signal.measured_rad - signal.predicted_rad)
        off = np.where(np.isfinite(signal.phase_sd_rad), off, -1.0)
        k = int(np.argmax(off)) if len(off) == track.tracked else k
    corners = board_px(track.badge, track.homographies[k], track.image_px[0] if track.mirrored else None)
    restarted = any(reason.code == "times" for reason in report.reasons)
    return Moment(int(track.frame_numbers[k]), None if restarted else float(track.times_s[k]), corners)


def frame_picture(report: Report, moment: Moment) -> bytes | None:
    """That frame as a JPEG, in colour, the badge outlined; None if the film is gone or has changed."""
    try:
        chosen = next((one["index"] for one in report.film.get("tracks", ()) if one["chosen"]), None)
        film = Film(Path(report.film["path"]), track=chosen)
        if film.described()["sha256"] != report.film["sha256"]:
            return None
        seen, turns = film.picture(moment.index, moment.time_s)
    except MediaError:
        return None
    seen = np.ascontiguousarray(seen)
    share = min(MOST_PX / max(seen.shape[:2]), 1.0)
    small = cv2.resize(seen, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    if moment.corners_px is not None:
        outline = np.rint(16 * share * moment.corners_px).astype(np.int32)[:, None]
        for colour, width in (((255, 255, 255), 6), (OUTLINES[report.verdict], 3)):
            cv2.polylines(small, [outline], True, colour, width, cv2.LINE_AA, shift=4)
    upright = np.rot90(small[:, :, ::-1], turns)
    done, coded = cv2.imencode(".jpg", upright, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return coded.tobytes() if done else None


Span = tuple[float, float]
#: A shorter time without verdict is not named, and at most MOST_NAMED of them are.
LEAST_GAP_S, MOST_NAMED = 0.5, 3
#: From this share on, a film counts as judged completely.
WHOLE = 0.995


@dataclass(frozen=True)
class Bar:
    """A part of a row: from and width as shares of the film, 0 to 100, and what it shows."""

    at: float
    width: float
    kind: str


@dataclass(frozen=True)
class Seconds:
    """Rows of bars by their label, the film's end in s, the meanings of the kinds that occur, and a sentence."""

    rows: tuple[tuple[str, tuple[Bar, ...]], ...]
    end: str
    kinds: tuple[tuple[str, str], ...]
    text: str


def seconds_of(document: Mapping[str, Any]) -> Seconds | None:
    """The seconds of a report, as in its JSON; None if it does not state them."""
    cover = document.get("cover")
    if not cover or not cover.get("film_s") or cover["film_s"][1] <= cover["film_s"][0]:
        return None
    film = (float(cover["film_s"][0]), float(cover["film_s"][1]))
    seen, judged = _spans(cover["seen_s"]), _spans(cover["spans_s"])
    rows = [
        ("badge seen", _bars(film, seen, "seen")),
        ("judged", _bars(film, judged, "judged")),
        ("the law", _law_bars(film, document["segments"], seen)),
    ]
    if overlap := document.get("overlap"):
        rows += [
            ("face seen", _bars(film, _spans(overlap["faces"]), "seen")),
            ("badge before it", _bars(film, _spans(overlap["overlaps"]), "judged")),
        ]
    kinds = tuple((kind, LAW[kind]) for kind in LAW if any(bar.kind == kind for _, bars in rows for bar in bars))
    return Seconds(tuple(rows), f"{film[1] - film[0]:.1f} s", kinds, _words(film, seen, judged, cover["share"]))


def _spans(said: Iterable[Sequence[float]]) -> tuple[Span, ...]:
    return tuple((float(start), float(end)) for start, end in said)


def _bars(film: Span, spans: Sequence[Span], kind: str) -> tuple[Bar, ...]:
    long = film[1] - film[0]
    found = []
    for start, end in spans:
        at, to = (100 * min(max((time_s - film[0]) / long, 0.0), 1.0) for time_s in (start, end))
        # A moment is shown as a thin line.
        found.append(Bar(min(at, 99.5), max(to - at, 0.5), kind))
    return tuple(found)


def _law_bars(film: Span, segments: Sequence[Mapping[str, Any]], seen: Sequence[Span]) -> tuple[Bar, ...]:
    """The verdict on each few seconds, for the time in which the badge was seen."""
    return tuple(
        bar
        for segment in segments
        for bar in _bars(film, within((segment["start_s"], segment["end_s"]), seen), segment["verdict"])
    )


def _words(film: Span, seen: Sequence[Span], judged: Sequence[Span], share: float) -> str:
    """How much was judged, and the longest gaps."""
    if not seen:
        return f"The badge was not followed anywhere in this film of {film[1] - film[0]:.1f} s."
    if not judged:
        shown = sum(end - start for start, end in seen)
        return f"The badge is seen in {shown:.1f} of {film[1] - film[0]:.1f} s, and none of them could be judged."
    text = f"The verdict covers {100 * share:.0f} % of the film's {film[1] - film[0]:.1f} s."
    gaps = [gap for gap in outside(film, judged) if gap[1] - gap[0] >= LEAST_GAP_S]
    if not gaps:
        return f"{text} {'No part' if share >= WHOLE else 'No more than a moment'} of it is left out."
    longest = sorted(sorted(gaps, key=lambda gap: gap[0] - gap[1])[:MOST_NAMED])
    named = ", ".join(f"{start:.1f} to {end:.1f} s" for start, end in longest)
    more = " and more" if len(gaps) > MOST_NAMED else ""
    return f"{text} It does not cover {named}{more}."
