"""Real lenses and the solver of the camera: run `.venv/bin/python benchmarks/lens_profiles.py --profiles FILE`.

FILE is a table of measured lenses as gyroflow's profiles have them: columns focal_over_long_side, fy_over_fx,
axis_x_over_long_side, axis_y_over_long_side, k1 to k4 (OpenCV's fisheye model), rms_error_px.  Lenses are drawn from
it; each films the corners of a badge's markers on a natural motion by `outside.motion`.  The corners are registered as
the verifier does, by one homography a frame, with noise, and `fit_camera` solves the camera.

Printed is, for each kind of lens, the gain's error (the spread of the parallax along x over the true one, less 1), the
error bar that the solver states, the share of films whose error is beyond three error bars, the share whose focal
length ends at the border of its search, and the processor time of a solution.  With `--fit`, no film is made: printed
are percentiles of the figures that the solver's priors are calibrated on.
"""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import cycle, product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from outside.motion import course

from moireid.verifier.camera.distortion import MIDDLE
from moireid.verifier.camera.fit import fit_camera
from moireid.verifier.measuring import FOCAL_PRIOR_RATIO
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

Array = NDArray[np.float64]
SIZE_PX, FPS, SECONDS = (1920, 1080), 30, 8
MOTIONS, DISTANCES_M = ("walk", "measured", "sway"), (0.6, 1.0, 2.0)
#: Corners of four markers of 20 mm at the corners of a board of 180 x 120 mm, and noise of a corner of one frame, px.
MARKER_MM, BOARD_MM, CORNER_PX = 20.0, (180.0, 120.0), 0.05
READOUT_S = 0.0145
#: Profiles that fit their chart worse than this are left out, px.
WORST_PROFILE_PX = 2.0
#: For `--fit`: lenses longer than this, whose charts do not determine the distortion, and those that two terms describe
#: worse than this, px.
LONG, WORST_RADIAL_PX = 1.6, 12.0
BINS = (("below 0.5", 0.0, 0.5), ("0.5 to 1.1", 0.5, 1.1), ("beyond 1.1", 1.1, 9.0))


@dataclass(frozen=True)
class FisheyeLens:
    """focal: over the long side; aspect: fy over fx; axis: from the middle, in long sides; k: of the fisheye model."""

    focal: float
    aspect: float
    axis: tuple[float, float]
    k: tuple[float, ...]

    def project(self, points: Array) -> Array:
        """Places in the picture, px, of points (..., 3) of the camera's frame (Kannala and Brandt 2006)."""
        flat = points[..., :2] / points[..., 2:]
        radius = np.linalg.norm(flat, axis=-1, keepdims=True)
        angle = np.arctan(radius)
        bent = angle * (1 + sum(k * angle ** (2 * n + 2) for n, k in enumerate(self.k)))
        share = np.where(radius > 1e-9, bent / np.maximum(radius, 1e-9), 1.0)
        long_side = max(SIZE_PX)
        middle = (np.array(SIZE_PX) - 1) / 2 + long_side * np.array(self.axis)
        return np.asarray(flat * share * self.focal * long_side * np.array([1.0, self.aspect]) + middle)


@dataclass(frozen=True)
class LensFilm:
    """One film: lens, motion, distance, and the number that its chance follows from."""

    lens: FisheyeLens
    motion: str
    distance_m: float
    number: int


@dataclass(frozen=True)
class CameraSolution:
    """What the solver made of a film.  gain: along x; sd: its error bar; focal: over the true one."""

    film: LensFilm
    gain: float
    sd: float
    focal: float
    at_limit: bool
    run_s: float


def profiles(path: Path) -> list[FisheyeLens]:
    """The lenses of a table; those whose picture turns back before its corner are no lenses of this model."""
    lenses = []
    with path.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if float(row["rms_error_px"] or math.inf) > WORST_PROFILE_PX:
                continue
            lens = FisheyeLens(
                float(row["focal_over_long_side"]),
                float(row["fy_over_fx"]),
                (float(row["axis_x_over_long_side"]), float(row["axis_y_over_long_side"])),
                tuple(float(row[f"k{n}"]) for n in range(1, 5)),
            )
            angle = np.linspace(0, 1.2, 200)
            bent = angle * (1 + sum(k * angle ** (2 * n + 2) for n, k in enumerate(lens.k)))
            corner = 0.5 * math.hypot(*SIZE_PX) / max(SIZE_PX) / lens.focal if 0.2 < lens.focal < 5 else math.inf
            rises = np.argmax(np.diff(bent) <= 0) if np.any(np.diff(bent) <= 0) else len(angle) - 1
            if bent[rises] > corner:
                lenses.append(lens)
    return lenses


def register_corners(film: LensFilm) -> tuple[Array, Array, Array, Array]:
    """Marker corners (T, 16, 2) px as registered, page (16, 2) mm, times (T,), and the camera's places (T, 3), mm."""
    rng = np.random.default_rng([film.number, 5])
    times = np.arange(SECONDS * FPS) / FPS
    path = course(film.motion, 1000 * film.distance_m * film.lens.focal / 0.75, SECONDS, rng)
    half = np.array(BOARD_MM) / 2
    one = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]) * MARKER_MM
    page = np.concatenate([one - half + np.array(at) * (np.array(BOARD_MM) - MARKER_MM) for at in np.ndindex(2, 2)])
    solid = np.column_stack([page, np.zeros(len(page))])
    seen = np.zeros((len(times), len(page), 2))
    shutter = np.zeros(seen.shape[:2])
    for _ in range(3):
        places, turns = path.views((times[:, None] + shutter).ravel())
        local = np.einsum("kji,kj->ki", turns, np.tile(solid, (len(times), 1)) - places)
        seen = film.lens.project(local).reshape(seen.shape)
        shutter = READOUT_S * seen[..., 1] / SIZE_PX[1]
    seen += rng.normal(scale=CORNER_PX, size=seen.shape)
    points = np.stack([_by_homography(page, frame) for frame in seen])
    middle, _ = path.views(times + READOUT_S / 2)
    return points, page, times, middle


def _by_homography(page: Array, seen: Array) -> Array:
    """The places where one homography has the points; it is the one with the least squares in the picture."""
    import cv2

    matrix, _ = cv2.findHomography(page, seen, 0)
    return np.asarray(cv2.perspectiveTransform(page[None], matrix)[0])


def solve_film(film: LensFilm) -> CameraSolution:
    """Solve one film's camera."""
    points, page, times, places = register_corners(film)
    begun = time.process_time()
    fit = fit_camera(points, page, times, SIZE_PX)
    run_s = time.process_time() - begun
    true, found = (c[:, 0] / -c[:, 2] for c in (places, fit.camera_mm))
    true, found = true - true.mean(), found - np.median(found)
    kept = np.abs(found) < 3 * np.abs(true).max()
    gain = float(found[kept] @ true[kept] / (true[kept] @ true[kept]))
    scatter = float(np.std(found[kept] - gain * true[kept]) / np.sqrt(true[kept] @ true[kept]))
    sd = math.hypot(fit.tangent_sd[0], scatter)
    focal = fit.focal_px / max(SIZE_PX) / film.lens.focal
    return CameraSolution(film, gain, sd, focal, fit.focal_at_limit, run_s)


def radial(lens: FisheyeLens) -> tuple[float, float, float, float]:
    """The lens as the solver has it: focal length, a and b of `camera.distortion`, and what they leave, px.

    Source: least squares over the picture's area, from the axis to the corner.
    """
    angle = np.linspace(0.005, 1.45, 600)
    bent = angle * (1 + sum(k * angle ** (2 * n + 2) for n, k in enumerate(lens.k)))
    shown = bent <= 0.5 * math.hypot(*SIZE_PX) / max(SIZE_PX) / lens.focal
    shown &= np.arange(len(angle)) <= np.argmax(~shown)
    true = np.tan(angle[shown])
    weight = np.sqrt(true)
    table = np.stack([true, true**3, true**5], axis=1)
    terms = np.linalg.lstsq(table * weight[:, None], bent[shown] * weight, rcond=None)[0]
    left_px = float(np.abs(table @ terms - bent[shown]).max()) * lens.focal * max(SIZE_PX)
    focal = lens.focal * float(terms[0])
    unit = FOCAL_PRIOR_RATIO / focal
    k1, k2 = float(terms[1] / terms[0]) * unit**2, float(terms[2] / terms[0]) * unit**4
    return focal, k1 + MIDDLE * k2, k2, left_px


def lens_percentiles(lenses: list[FisheyeLens]) -> Iterator[Row]:
    """Percentiles of the lenses' figures."""
    figures = np.array([radial(lens) for lens in lenses if lens.focal < LONG])
    figures = figures[figures[:, 3] < WORST_RADIAL_PX]
    for name, column in zip(("focal length", "a", "b", "left, px"), figures.T, strict=True):
        percentiles = zip(PERCENTILES, np.percentile(column, PERCENTILES).tolist(), strict=True)
        yield {"figure": name, "lenses": len(figures)} | {f"{step} %": value for step, value in percentiles}
    yield {"correlation of a and b": float(np.corrcoef(figures[:, 1], figures[:, 2])[0, 1])}


def rows(wish: Wish) -> Iterator[Row]:
    """One row a kind of lens, and one for each of the worst films; with `--fit`, the lenses' own figures."""
    known = profiles(wish.own.profiles)
    if wish.own.fit:
        yield from lens_percentiles(known)
        return
    count = min(wish.clips or 200, len(known))
    picked = np.random.default_rng(wish.seed).choice(len(known), count, replace=False)
    films = [
        LensFilm(known[k], motion, distance_m, n + 1000 * wish.seed)
        for n, (k, (distance_m, motion)) in enumerate(zip(picked, cycle(product(DISTANCES_M, MOTIONS)), strict=False))
    ]
    with ProcessPoolExecutor(wish.where.workers) as pool:
        found = list(pool.map(solve_film, films, chunksize=4))
    for name, low, high in (*BINS, ("all", 0.0, 9.0)):
        if own := [one for one in found if low <= one.film.lens.focal < high]:
            error, bar = (
                np.array(values) for values in zip(*((abs(one.gain - 1), one.sd) for one in own), strict=True)
            )
            yield {
                "focal length": name,
                "films": len(own),
                "|gain-1| 50 %": float(np.median(error)),
                "90 %": float(np.percentile(error, 90)),
                "error bar 50 %": float(np.median(bar)),
                "beyond 3 bars": int(np.sum(error > 3 * bar)),
                "at border": sum(one.at_limit for one in own),
                "s a film": float(np.mean([one.run_s for one in own])),
            }
    for one in sorted(found, key=lambda one: -abs(one.gain - 1) / one.sd)[: wish.own.worst]:
        film = one.film
        lens = f"{film.motion} {film.distance_m} m, lens {film.lens.focal} {film.lens.axis} {film.lens.k}"
        yield {"gain": one.gain, "error bar": one.sd, "focal length of the true one": one.focal, "worst films": lens}


PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
OPTIONS = {
    "--profiles": {"type": Path, "required": True, "metavar": "FILE"},
    "--worst": {"type": int, "default": 5, "metavar": "N", "help": "films to name, furthest in error bars"},
    "--fit": {"action": "store_true", "help": "print the lenses' own figures instead"},
}
COLUMNS = {"focal length": "<12", "films": ">6", "|gain-1| 50 %": ">13.4f", "90 %": ">7.4f", "error bar 50 %": ">14.4f"}
COLUMNS |= {"beyond 3 bars": ">13", "at border": ">9", "s a film": ">8.2f", "figure": "<12", "lenses": ">6"}
COLUMNS |= {f"{step} %": ">7.3f" for step in PERCENTILES} | {"correlation of a and b": ">22.2f", "gain": ">7.3f"}
COLUMNS |= {"error bar": ">9.3f", "focal length of the true one": ">28.3f", "worst films": "<1"}
BENCH = Bench(rows, COLUMNS, options=OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
