"""How well badges without markers are followed from corners given by hand, and what comes of it.

Run `.venv/bin/python benchmarks/by_corners.py [MANIFEST.csv] [--paint square|page] [--wrong PX] [--seed N]`; without a
manifest it takes the films of tests/data/films.  In each frame the markers, once they have told where the page is, are
painted over: by a plain dark square of their size, or by the page's own shade, which leaves letters and the board's
outline alone.  The corners of the first frame are given with an error of so many pixels (standard deviation of each
coordinate).  The error told is that of the followed corners against those by markers, as wrong as they were given.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.evaluation.manifest import read_manifest
from moireid.verifier.session.chapters import Claim, identity_of, invariant_of
from moireid.verifier.session.streaming import Verifier
from moireid.verifier.tracking.markers import marker_corners_mm
from moireid.verifier.tracking.scene_tracker import BadgesInView
from moireid.verifier.video import Film, Frame

Array = NDArray[np.float64]
COLLECTION = Path(__file__).resolve().parent.parent / "tests" / "data" / "films" / "collection.csv"
#: Of a marker's side, what is painted in the page's shade, which is taken where the last figure says.
PAINTED, SHADE_AT = 1.12, 1.10


def painted(frames: Iterator[Frame], badge: Badge, how: str) -> Iterator[tuple[Frame, Array | None]]:
    """Frames with their markers painted over, and the page by markers, None where these were not seen."""
    view = BadgesInView(badge)
    corners_mm = marker_corners_mm(badge.markers)
    middles = corners_mm.mean(axis=1, keepdims=True)
    for frame in frames:
        view.push(frame)
        page = view.trackers[0].place
        if page is not None and not view.trackers[0].look(1).mirrored:
            luma = frame.luma.copy()
            for square, middle in zip(corners_mm, middles, strict=True):
                grown = square if how == "square" else middle + PAINTED * (square - middle)
                beside = seen(page, middle + SHADE_AT * (square - middle)).round().astype(int)
                inside = np.clip(beside, 0, np.array(luma.shape[::-1]) - 1)
                shade = 45 if how == "square" else int(np.median(luma[inside[:, 1], inside[:, 0]]))
                cv2.fillConvexPoly(luma, np.round(seen(page, grown) * 16).astype(np.int32), shade, cv2.LINE_AA, 4)
            yield replace(frame, luma=luma), page
        else:
            yield frame, None


def seen(page: Array, places_mm: Array) -> Array:
    """Places (N, 2) mm of the page in the picture, px."""
    return np.asarray(cv2.perspectiveTransform(places_mm[:, None], page)[:, 0], float)


def row_of(video: Path, badge: Badge, how: str, wrong_px: float, seed: int) -> str:
    """Follow, judge; one line of figures."""
    x0, y0, x1, y1 = badge.gratings[0].rect_mm
    region = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    verifier: Verifier | None = None
    warp, errors = np.eye(3), []
    for frame, page in painted(Film(video).frames(), badge, how):
        if verifier is None:
            if page is None or frame.index:
                return "markers are not seen in the first frame, or in a mirror"
            given = seen(page, region) + wrong_px * np.random.default_rng(seed).standard_normal((4, 2))
            believed = cv2.getPerspectiveTransform(region.astype(np.float32), given.astype(np.float32))
            warp = np.linalg.inv(page) @ believed
            verifier = Verifier(Claim(badge, badge.id), running=False, corners={0: given})
        verifier.push(frame)
        place = verifier.judged.tracker.place
        if place is not None and page is not None:
            errors.append(np.linalg.norm(seen(place, region) - seen(page @ warp, region), axis=1))
    if verifier is None:
        return "holds no frame"
    chapters = verifier.finish()
    invariant, identity = invariant_of(chapters), identity_of(chapters)[0]
    others = [r.code for r in invariant.reasons if r.level in ("fail", "undecided") and r.code != "corners"]
    error = np.concatenate(errors) if errors else np.zeros(1)
    tracked = sum(chapter.tracked for chapter in chapters)
    return (
        f"{tracked:>5}{np.median(error):>8.3f}{error.max():>7.3f}  {invariant.verdict:<13}{identity.verdict:<12}"
        f"{_figure(invariant.gain_ratio)}{_figure(invariant.score)}  {' '.join(others)}"
    )


def _figure(value: float | None) -> str:
    return f"{'':>8}" if value is None else f"{value:>8.3f}"


def main() -> None:
    """Print one row a film."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("manifest", nargs="?", type=Path, default=COLLECTION)
    parser.add_argument("--paint", choices=["square", "page"], default="square")
    parser.add_argument("--wrong", type=float, default=1.5)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    print(
        f"{'film':<28}{'label':<20}{'seen':>5}{'px mid':>8}{'most':>7}  {'invariant':<13}{'identity':<12}"
        f"{'gain':>8}{'score':>8}  beside the corners"
    )
    for entry in read_manifest(given.manifest).entries:
        row = row_of(entry.video, entry.claimed.badge, given.paint, given.wrong, given.seed)
        print(f"{entry.video.stem:<28}{entry.label:<20}{row}", flush=True)


if __name__ == "__main__":
    main()
