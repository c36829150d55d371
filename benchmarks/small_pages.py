"""True films of badges that are small in the picture: run `moireid lab bench small-pages [--films N]`.

A page of 60 x 66 mm, whose markers are then 10 to 16 px wide, and the default board at 2 m, with markers of 19 px, are
filmed in ordinary and in poor quality, swaying and moved against the camera in turns.  Poses are the weak part there.

Printed is what becomes of the films, and by how much the predicted phase is wrong over its error bar, in the median
film and in the worst.  None may be rejected: each film is true.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from itertools import product

import numpy as np

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


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    jobs = {
        f"{name}, {metres:g} m, crf {crf}, {seed}": (name, metres, crf, seed)
        for (name, metres), crf in product(PLACES, QUALITIES)
        for seed in range(1, 1 + (wish.clips or 4))
    }
    return wish.each(judged, jobs)


def table(films: list[Row]) -> Iterator[Row]:
    """One row a page, distance and quality."""
    for (name, metres, crf), found in grouped(films, "page", "m", "crf").items():
        ratios = [row["ratio"] for row in found if row["ratio"] is not None]
        spread = {"ratio": float(np.median(ratios)), "ratio, worst": max(ratios)} if ratios else {}
        yield {"page": name, "m": metres, "crf": crf} | counted_verdicts(found) | spread


COLUMNS = {"page, mm": "page <10", "m": ">4", "crf": ">4", "accept": ">8", "inconclusive": ">13", "reject": ">8"}
COLUMNS |= {"ratio": ">8.2f", "ratio, worst": ">12.2f"}
BENCH = Bench(rows, COLUMNS | {"reasons": "<1"}, table=table)
