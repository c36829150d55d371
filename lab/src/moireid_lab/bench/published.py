"""The paper's experiments (Qing et al. 2026), filmed as in `paper_films`, scored by its pipeline and by ours.

Columns are the paper's: |rho| over windows of 30 frames, mean, standard deviation and range; over the whole film; its
decision, by the greatest window.  Ours: decadic logarithm of the calibrated odds, and the verdict on the motion.

place, phase: what limits the published score: mean |rho| over windows of its camera place, and of its fringe phase,
against the true parallax across the fringes.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ttest_ind

from moireid.question import KnownCamera, Question
from moireid.simulate.filming import film, truth_path
from moireid.verifier import verify
from moireid.verifier.decision.figures import calibrated_log10, window_correlation_mean
from moireid.verifier.video import Film
from moireid_lab.baseline.corners import Corners
from moireid_lab.baseline.pipeline import THRESHOLD, judge, read_film
from moireid_lab.bench.bench_frame import Bench, Row, Wish, counted_verdicts, grouped
from moireid_lab.bench.paper_films import PaperFilm, every_film
from moireid_lab.bench.verdicts import verdict_row
from moireid_lab.evaluation.summary import PAPER, separation

Array = NDArray[np.float64]
REAL, GENERATED = "real (stand-ins)", "generated (stand-ins)"
#: The paper's table, by set and field: window mean, its range, and the whole film.
PANELS = {
    ("A", "x"): "0.951 (0.722 to 0.998), 0.807",
    ("A", "y"): "0.854 (0.561 to 0.999), 0.325",
    ("B, trajectory 1", "x"): "0.758 (0.033 to 0.990), 0.141",
    ("B, trajectory 2", "x"): "0.809 (0.445 to 0.987), 0.024",
    ("C", "x"): "0.720 (0.139 to 0.997), 0.447",
    ("D", "x"): "0.667 (0.045 to 0.998), 0.713",
    ("D", "y"): "0.570 (0.004 to 0.988), 0.709",
}
#: What the paper has of the other sets.
OTHERS = {
    "rendering 1": "0.99",
    "rendering 2": "0.99",
    REAL: f"{PAPER['genuine']['mean']:.2f} ± {PAPER['genuine']['sd']:.2f}",
    GENERATED: f"{PAPER['forged']['mean']:.2f} ± {PAPER['forged']['sd']:.2f}",
}
#: Thresholds of the published score at which rates are printed.
THRESHOLDS = (0.5, 0.6, 0.7, 0.8, 0.9, THRESHOLD, 0.95, 0.98, 0.99, 0.995)
#: Frames after which corners given by hand are corrected.
CORRECTED_EVERY = 24


def rows(wish: Wish) -> Iterator[Row]:
    """A row a film: all of them, those whose name is asked for, or the first of each set; quick: one of each."""
    most, films = wish.clips or (1 if wish.quick else None), list(every_film().values())
    sets: dict[str, list[PaperFilm]] = {}
    for one in films:
        sets.setdefault(one.set, []).append(one)
    names = {film.name for own in sets.values() for film in own[:most]}
    return wish.each(score_film, {film.name: (film.name, wish.seed) for film in films if film.name in names})


def score_film(job: tuple[str, int]) -> Row:
    """Make one film and score it by both pipelines; it is sent by its name, as motions cannot travel."""
    name, seed = job
    one = every_film()[name]
    badge, camera = one.scene.badge, KnownCamera(one.scene.camera.focal_px) if one.known else None
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        film(one.scene, one.motion, video, seed=seed, **one.how)
        with truth_path(video).open(encoding="utf-8", newline="") as stream:
            truth = list(csv.DictReader(stream))
        metres = float(np.mean([-float(frame["camera_z_mm"]) for frame in truth])) / 1000
        fields = {}
        for grating in badge.gratings:
            # The baseline reads a badge's first field.
            claim = Question(replace(badge, gratings=(grating,)), camera=camera)
            corners = given_corners(one) if one.marked else None
            fields[str(grating.axis)] = _published(one, Film(video, reduced=False), claim, corners, truth)
        ours = verdict_row(verify(video, Question(badge, camera=camera)))
    return {"set": one.set, "film": name, "distance_m": round(metres, 3), "fields": fields} | ours


def _published(
    one: PaperFilm, video: Film, claim: Question, corners: Corners | None, truth: list[dict[str, str]]
) -> Row:
    """The published pipeline's figures of one field."""
    reader = read_film(video, claim, corners=corners, compensated=one.compensated)
    phase, place = np.unwrap(reader.phases), np.array(reader.places)
    found = judge(phase, place, reader.read)
    axis = claim.badge.gratings[0].axis
    true = np.array([float(truth[k][f"parallax_{axis}"]) for k in reader.frames if k < len(truth)])
    known = found.score is not None and len(true) == len(place)
    return {
        "mean": found.window_correlation_mean if found.score is not None else None,
        "sd": found.window_correlation_sd,
        "least": found.window_correlation_min,
        "greatest": found.score,
        "global": found.correlation if found.score is not None else None,
        "place": window_correlation_mean(place, true) if known else None,
        "phase": window_correlation_mean(phase, true) if known else None,
        "tracked": len(place),
        "frames": reader.read,
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


def table(rows: list[Row]) -> Iterator[Row]:
    """Sets by distance, fields next to the paper, what lowers the score, and what scores separate."""
    for (name, metres), own in grouped(rows, "set", "distance_m").items():
        if name.startswith("rendering"):
            yield _line(f"{name}, {metres:g} m", own, "x") | {"paper": OTHERS[name]}
    for (name, axis), figures in PANELS.items():
        if own := [row for row in rows if row["set"] == name]:
            yield _line(f"{name}, {axis}", own, axis) | {"paper": figures}
    for name in (REAL, GENERATED):
        if own := [row for row in rows if row["set"] == name]:
            yield _line(name, own, "x") | {"paper": OTHERS[name]}
    for (name, metres), own in grouped(rows, "set", "distance_m").items():
        if name.startswith("cause"):
            yield _line(f"{name.removeprefix('cause: ')}, {metres:g} m", own, "x")
    true, false = (_greatest(rows, name) for name in (REAL, GENERATED))
    if len(true) and len(false):
        for limit in THRESHOLDS:
            kept, taken = int((true >= limit).sum()), int((false >= limit).sum())
            accuracy = (kept + len(false) - taken) / (len(true) + len(false))
            rates = {"true accepted": kept / len(true), "false accepted": taken / len(false), "accuracy": accuracy}
            yield {"threshold": limit} | rates


def _line(name: str, rows: list[Row], axis: str) -> Row:
    """The figures of one set of films."""
    fields = [row["fields"][axis] for row in rows]

    def mean(key: str) -> float | None:
        found = [one[key] for one in fields if one[key] is not None]
        return float(np.mean(found)) if found else None

    some = [one for one in fields if one["greatest"] is not None]
    likely = sum(one["greatest"] >= THRESHOLD for one in some)
    odds = [calibrated_log10(row["score"]) for row in rows if row["score"] is not None]
    counts = counted_verdicts(rows)
    return {
        "set": name,
        "films": len(rows),
        **{key: mean(key) for key in ("mean", "sd", "greatest", "global")},
        "range": f"{min(one['least'] for one in some):.2f} to {max(one['greatest'] for one in some):.3f}"
        if some
        else "-",
        "real": f"{likely} of {len(rows)}",
        "place": mean("place"),
        "phase": mean("phase"),
        "log10 odds": float(np.median(odds)) if odds else None,
        "acc./inc./rej.": "/".join(str(counts[word]) for word in ("accept", "inconclusive", "reject")),
    }


def _greatest(rows: list[Row], name: str) -> Array:
    """The published scores of a set; films without one, which are in no figure of the paper, are left out."""
    found = [row["fields"]["x"]["greatest"] for row in rows if row["set"] == name]
    return np.array([score for score in found if score is not None], float)


def notes(rows: list[Row]) -> Iterator[str]:
    """Welch's t, Cohen's d and the area under the curve, next to the paper's."""
    yield "real: films that the published pipeline calls likely real; paper: window mean (range), global."
    for words, key in (("greatest window", "greatest"), ("window mean", "mean")):
        true, false = (
            np.array(
                [one for row in rows if row["set"] == name and (one := row["fields"]["x"][key]) is not None], float
            )
            for name in (REAL, GENERATED)
        )
        if min(len(true), len(false)) > 1:
            test, both = ttest_ind(true, false, equal_var=False), separation(true, false, 0, means=True)
            spread = np.sqrt((true.var(ddof=1) + false.var(ddof=1)) / 2)
            best = both["best_threshold"]
            yield (
                f"{words}: {true.mean():.3f} ± {true.std(ddof=1):.3f} ({len(true)} of 87) against {false.mean():.3f} ± "
                f"{false.std(ddof=1):.3f} ({len(false)} of 92); Welch t({test.df:.0f}) = {test.statistic:.1f}, p = "
                f"{test.pvalue:.1g}; d = {(true.mean() - false.mean()) / spread:.2f}; AUC {both['auc']:.3f}; best "
                f"threshold {best['threshold']:.3f}, accuracy {best['accuracy']:.3f}."
            )
    yield "The paper: t(160) = 11.6, p < 1e-20; d 1.71; AUC 0.845; threshold 0.927; on recordings and generated films."
    scores = [[row["score"] for row in rows if row["set"] == name] for name in (REAL, GENERATED)]
    if all(scores):
        # A film without a score ranks lowest, as no threshold accepts it.
        true, false = (np.array([-np.inf if one is None else one for one in some], float) for some in scores)
        yield f"Our score on the same films: AUC {separation(true, false, 0, means=False)['auc']:.3f}."


COLUMNS = {"set": "<38", "films": ">5", "mean": ">6.3f", "sd": ">6.3f", "range": ">14", "global": ">6.3f"}
COLUMNS |= {"greatest": ">8.3f", "real": ">8", "place": ">6.3f", "phase": ">6.3f", "log10 odds": ">10.1f"}
COLUMNS |= {"acc./inc./rej.": ">14", "paper": "<1"}
COLUMNS |= {"threshold": ">9.3f", "true accepted": ">13.3f", "false accepted": ">14.3f", "accuracy": ">8.3f"}
BENCH = Bench(rows, COLUMNS, notes, table=table)
