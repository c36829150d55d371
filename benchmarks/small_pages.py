"""True films of badges that are small in the picture: run `moireid lab bench small-pages [--films N]`.

A page of 60 x 66 mm, whose markers are then 10 to 16 px wide, and the default board at 2 m, with markers of 19 px, are
filmed in ordinary and in poor quality, swaying and moved against the camera in turns.  Poses are the weak part there.
Boards and A6 badges are also filmed at an angle by `outside`, in a moving hand, by a webcam of 720p: as many px wide as
stated when seen from the front, and then turned about an axis.

Printed is what becomes of the films, by how much the predicted phase is wrong over its error bar, in the median film
and in the worst; of those at an angle, the share of frames that are tracked in the median and in the worst film, and
the error of the parallax, root mean square in the median film.  None may be rejected: each film is true.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import cv2
import numpy as np
from natural_films import prepared
from outside.build import built
from outside.camera import LAPTOP
from outside.camera import Camera as Webcam
from outside.film import Shoot
from outside.film import film as traced
from outside.motion import Course
from outside.motion import course as course_of
from outside.page import load_page
from scipy.spatial.transform import Rotation

from moireid.badge import load_badge
from moireid.designer import Order, design_badge
from moireid.simulate import Build, Camera, Scene, motion_named
from moireid.simulate.filming import truth_path
from moireid.verifier import Question, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, counted_verdicts, grouped, temporary_film
from moireid_lab.bench.verdicts import why_not

PAGES = {
    "60 x 66": Order("Bench", lens="75lpi", size_mm=(60, 66), range_m=(0.5, 1.0)),
    "146 x 160": Order("Bench", lens="50lpi"),
}
PLACES, QUALITIES, MOTIONS = (
    (("60 x 66", 1.0), ("60 x 66", 1.2), ("60 x 66", 1.5), ("146 x 160", 2.0)),
    (23, 28),
    ("sway", "both"),
)
FRAMES, FPS = 240, 30
#: Format, width from the front, px, angle, degrees, axis, and frames a second; a webcam's focal length, px.
AXES = {"vertical": (0.0, 1.0, 0.0), "horizontal": (1.0, 0.0, 0.0), "oblique": (0.7071, 0.7071, 0.0)}
SLANTED = tuple(product(("board", "a6"), (100, 110, 120, 140), (0, 40, 50, 60), AXES, (30, 6)))
SLANTED_S = 12
WEBCAM = Webcam(LAPTOP, 750.0, (645.0, 355.0), blur_px=0.6, exposure_s=8e-3, readout_s=20e-3, white_electrons=6600)


def judged(job: tuple[str, float, int, int]) -> Row:
    """Verdict of one film, and the error of its predicted phase over the error bar; nan where nothing was measured."""
    name, metres, crf, seed = job
    badge = design_badge(PAGES[name], bytes.fromhex("0f5ac3962d784be1"))
    course = motion_named(MOTIONS[seed % 2], distance_mm=1000 * metres, seed=seed)
    scene = Scene(badge, Build.typical(seed), Camera())
    with temporary_film(scene, course, frames=FRAMES, fps=FPS, seed=seed, crf=crf) as video:
        report = verify(video, Question(badge, badge.id))
        truth = list(csv.DictReader(truth_path(video).open(encoding="utf-8")))
    row = {"page": name, "m": metres, "crf": crf, "verdict": report.verdict, "why": why_not(report), "ratio": None}
    if report.measurement is None:
        return row
    true = np.unwrap([float(row["phase_rad"]) for row in truth])[report.track.frame_numbers]
    off = report.measurement.gratings[0].predicted_rad - true
    # A focal length that is off scales the phase, and has an error bar of its own.
    scatter = float(np.std(off - np.polyval(np.polyfit(true, off, 1), true)))
    return row | {"ratio": scatter / report.invariant.gratings[0]["expected_error_rad"]}


def slanted(task: tuple[str, int, int, str, int, str]) -> Row:
    """Verdict, share of tracked frames and error of the parallax of one film at an angle."""
    name, width, degrees, axis, fps, kept = task
    folder = Path(kept) / name
    page, badge = load_page(folder / "badge"), load_badge(folder / "badge" / "badge.json")
    rng = np.random.default_rng([width, degrees, list(AXES).index(axis), fps])
    hand = course_of("measured", WEBCAM.focal_px * page.size_mm[0] / width, SLANTED_S, rng)
    course = replace(hand, badge=turned(hand, math.radians(degrees) * np.array(AXES[axis])))
    video = folder / f"{width}_{degrees}_{axis}_{fps}.mp4"
    places = traced(page, built(page, rng), WEBCAM, course, video, Shoot(SLANTED_S * fps, fps, 23, 1))
    report = verify(video, Question(badge, badge.id))
    track = report.track
    video.unlink()
    rect = badge.outline_mm
    corners = np.array([[rect[0], rect[1]], [rect[2], rect[1]], [rect[2], rect[3]], [rect[0], rect[3]]])
    solid = np.column_stack([corners - corners.mean(axis=0), np.zeros(4)])
    lens = np.array(
        [[WEBCAM.focal_px, 0, WEBCAM.center_px[0] - 0.5], [0, WEBCAM.focal_px, WEBCAM.center_px[1] - 0.5], [0, 0, 1]]
    )
    off = []
    for number, homography in zip(track.frame_numbers, track.homographies, strict=True):
        seen = cv2.perspectiveTransform(corners[:, None], homography)
        _, turn, place = cv2.solvePnP(solid, seen, lens, None)
        found, true = -cv2.Rodrigues(turn)[0].T @ place[:, 0], places[number]
        off.append(found[0] / abs(found[2]) - true[0] / abs(true[2]))
    return {
        "page": name, "m": f"{width} px, {degrees} deg", "crf": 23, "verdict": report.verdict, "why": why_not(report),
        "ratio": None, "tracked": (track.tracked + track.passed) / track.frames_read,
        "parallax": float(np.sqrt(np.mean(np.square(off)))) if off else None,
    }  # fmt: skip


def turned(hand: Course, turn: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The badge's poses, turned about an axis of the page first."""

    def six(t: np.ndarray) -> np.ndarray:
        own = hand.badge(t)
        angles = (Rotation.from_euler("YXZ", own[:, [1, 0, 2]]) * Rotation.from_rotvec(turn)).as_euler("YXZ")
        return np.column_stack([angles[:, [1, 0, 2]], own[:, 3:]])

    return six


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    jobs = {
        f"{name}, {metres:g} m, crf {crf}, {seed}": (name, metres, crf, seed)
        for (name, metres), crf in product(PLACES, QUALITIES)
        for seed in range(1, 1 + (wish.clips or 4))
    }
    with wish.kept_folder() as kept:
        at_angle = {
            " ".join(map(str, case)): (*case, str(kept)) for case in SLANTED if case[2] or case[3] == "vertical"
        }
        for name in {case[0] for case in SLANTED}:
            prepared(kept / name, "--format", name)
        yield from wish.each(made, jobs | at_angle)


def made(job: tuple) -> Row:
    """A row of either kind."""
    return judged(job) if len(job) == 4 else slanted(job)


def table(films: list[Row]) -> Iterator[Row]:
    """One row a page, distance and quality, or a page, width and angle."""
    for (name, metres, crf), found in grouped(films, "page", "m", "crf").items():
        spread: Row = {}
        for key, ends in (
            ("ratio", (np.nanmedian, np.nanmax)),
            ("tracked", (np.median, np.min)),
            ("parallax", (np.nanmedian,)),
        ):
            values = np.array([row.get(key) for row in found], float)
            if np.any(np.isfinite(values)):
                spread |= {f"{key}{'' if k == 0 else ', worst'}": float(end(values)) for k, end in enumerate(ends)}
        yield {"page": name, "m": metres, "crf": crf} | counted_verdicts(found) | spread


COLUMNS = {"page, mm": "page <10", "m": ">14", "crf": ">4", "accept": ">8", "inconclusive": ">13", "reject": ">8"}
COLUMNS |= {"ratio": ">8.2f", "ratio, worst": ">12.2f", "tracked": ">8.2f", "tracked, worst": ">14.2f"}
BENCH = Bench(rows, COLUMNS | {"parallax": ">9.4f", "reasons": "<1"}, table=table)
