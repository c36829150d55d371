"""The paper's experiments (Qing et al. 2026), filmed as in `paper_films`, scored by its pipeline and by ours.

A row has, for each field of a badge, the paper's figures by either: |rho| over windows of 30 frames, mean, standard
deviation, least and greatest, and over the whole film; ours are of measured against predicted phase.  And what limits
the published ones: place, phase: mean |rho| over windows of its camera place, and of its fringe phase, against the true
parallax across the fringes.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.question import KnownCamera, Question
from moireid.simulate.filming import truth_path
from moireid.verifier import Report, verify
from moireid.verifier.decision.figures import window_correlation_mean
from moireid.verifier.video import Film
from moireid_lab.baseline.corners import Corners
from moireid_lab.baseline.pipeline import PublishedInvariant, judge, read_film
from moireid_lab.bench.paper_films import PaperFilm, every_film
from moireid_lab.bench.part import OWN, Part, Row, film_row, temporary_film

Array = NDArray[np.float64]
#: Frames after which corners given by hand are corrected.
CORRECTED_EVERY = 24
#: What a film answers, by the start of its set's name.
QUESTIONS = {
    "real": "Is a stand-in for the paper's recordings accepted?",
    "generated": "Is a stand-in for its generated films, whose fringes know nothing of the law, rejected?",
    "experiment": "Is a film of its experiments accepted? Most are single sweeps, which a drift could be as well",
}


def judged(one: PaperFilm, folder: Path) -> Row:
    """Make one film and score it by both pipelines."""
    badge, camera = one.scene.badge, KnownCamera(one.scene.camera.focal_px) if one.known else None
    with temporary_film(one.scene, one.motion, **one.how) as video:
        with truth_path(video).open(encoding="utf-8", newline="") as stream:
            truth = list(csv.DictReader(stream))
        report = verify(video, Question(badge, camera=camera))
        fields = {}
        for number, grating in enumerate(badge.gratings):
            # The baseline reads a badge's first field.
            claim = Question(replace(badge, gratings=(grating,)), camera=camera)
            published = _published(one, Film(video), claim, truth)
            fields[str(grating.axis)] = published | {"ours": _ours(report, number)}
    metres = float(np.mean([-float(frame["camera_z_mm"]) for frame in truth])) / 1000
    question = next((name for name in QUESTIONS if one.set.startswith(name)), "experiment")
    figures = {"score": report.invariant.score, "metres": round(metres, 3), "fields": fields}
    return film_row(one.set, report, true=one.true, question=question, **figures)


def _published(one: PaperFilm, video: Film, claim: Question, truth: list[dict[str, str]]) -> Row:
    """The published pipeline's figures of one field."""
    corners = given_corners(one) if one.marked else None
    reader = read_film(video, claim, corners=corners, compensated=one.compensated)
    phase, place = np.unwrap(reader.phases), np.array(reader.places)
    found = judge(phase, place, reader.read)
    axis = claim.badge.gratings[0].axis
    true = np.array([float(truth[k][f"parallax_{axis}"]) for k in reader.frames if k < len(truth)])
    known = found.score is not None and len(true) == len(place)
    limits = {name: window_correlation_mean(series, true) for name, series in (("place", place), ("phase", phase))}
    return _figures(found) | (limits if known else dict.fromkeys(limits))


def _ours(report: Report, number: int) -> Row:
    """The same figures of the phases that our method measures and predicts."""
    if report.measurement is None:
        return _figures(PublishedInvariant("inconclusive", ()))
    signal = report.measurement.gratings[number]
    seen = np.isfinite(signal.phase_sd_rad)
    return _figures(judge(signal.measured_rad[seen], signal.predicted_rad[seen], len(seen)))


def _figures(found: PublishedInvariant) -> Row:
    """The paper's figures, None in a film without a score."""
    return {
        "mean": found.window_correlation_mean,
        "sd": found.window_correlation_sd,
        "least": found.window_correlation_min,
        "greatest": found.window_correlation_max,
        "global": found.correlation,
    }


def given_corners(one: PaperFilm) -> Corners:
    """The region's corners as a hand would give them: true in the first frame and every second or so."""
    count, camera = one.how["frames"], one.scene.camera
    x0, y0, x1, y1 = one.scene.badge.gratings[0].rect_mm
    flat = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) - one.scene.board_centre_mm
    frames = range(0, count, CORRECTED_EVERY)
    poses = one.motion(np.array(frames) / one.how["fps"])
    seen = np.column_stack([flat, np.zeros(4)]) - poses.camera_mm[:, None]
    return dict(zip(frames, camera.project(np.einsum("tij,tkj->tki", poses.rotation, seen)), strict=True))


PART = Part(QUESTIONS, OWN, lambda asked: every_film(), judged)
