"""True films of badges that are small in the picture: run `moireid lab bench small-pages [--clips N]`.

A page of 60 x 66 mm, whose markers are then 10 to 16 px wide, and the default board at 2 m, with markers of 19 px, are
filmed in ordinary and in poor quality, swaying and moved against the camera in turns.  Poses are the weak part there.

`ratio` is by how much the predicted phase is wrong over its error bar.  None may be rejected: each film is true.
"""

from __future__ import annotations

import csv
from itertools import product
from pathlib import Path

import numpy as np

from moireid.designer import Order, design_badge
from moireid.simulate import Build, Camera, Scene, motion_named
from moireid.simulate.filming import truth_path
from moireid.verifier import Question, verify
from moireid_lab.bench.part import OWN, Asked, Part, Row, film_row, temporary_film

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


def judged(job: tuple[str, float, int, int], folder: Path) -> Row:
    """Verdict of one film, and the error of its predicted phase over the error bar."""
    name, metres, crf, seed = job
    badge = design_badge(PAGES[name], bytes.fromhex("0f5ac3962d784be1"))
    course = motion_named(MOTIONS[seed % 2], distance_mm=1000 * metres, seed=seed)
    scene = Scene(badge, Build.typical(seed), Camera())
    with temporary_film(scene, course, frames=FRAMES, fps=FPS, seed=seed, crf=crf) as video:
        report = verify(video, Question(badge, badge.id))
        truth = list(csv.DictReader(truth_path(video).open(encoding="utf-8")))
    row = film_row(f"{name} mm, {metres:g} m", report, true=True)
    if report.measurement is None:
        return row
    true = np.unwrap([float(row["phase_rad"]) for row in truth])[report.track.frame_numbers]
    off = report.measurement.gratings[0].predicted_rad - true
    # A focal length that is off scales the phase, and has an error bar of its own.
    scatter = float(np.std(off - np.polyval(np.polyfit(true, off, 1), true)))
    return row | {"ratio": scatter / report.invariant.gratings[0]["expected_error_rad"]}


def cases(asked: Asked) -> dict[str, tuple[str, float, int, int]]:
    """All films."""
    return {
        f"{name}, {metres:g} m, crf {crf}|{seed}": (name, metres, crf, seed)
        for seed in range(1, 1 + (asked.clips or 2))
        for (name, metres), crf in product(PLACES, QUALITIES)
    }


PART = Part({"genuine": "Is a true film of a badge that is small in the picture accepted?"}, OWN, cases, judged)
