"""The verify suite: error against run time of the verifier.

On films of known truth, every setting of frames used and working resolution: error of the fringe phase, of the phase
that the poses predict, and of the gain; verdicts that are right; processor time of a film's frame, decoding apart.
knee: the setting of least phase error times processor time among those whose verdicts are all right.

A setting changes only the frames: they are skipped or shrunk before they are pushed into `verifier.Verifier`.  The time
for shrinking counts for the setting.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from moireid.verifier import Question, Verifier
from moireid.verifier.picture import Frame, Picture
from moireid.verifier.reasons import worst
from moireid.verifier.session.badge_session import reasons_of
from moireid.verifier.session.chapters import invariant_of
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped
from moireid_lab.bench.bench_rows import Where
from moireid_lab.bench.verify.films import KINDS, DecodedFilm, Kind, phase_error_rad, shoot

#: 8 s, so that every fourth frame is still more than the verifier asks for at least.
FRAMES, QUICK_FRAMES = 250, 150
RUNS, QUICK_RUNS = 3, 2
#: Every so many frames, at so much of the film's resolution.
Setting = tuple[int, float]
DEFAULT: Setting = (1, 1.0)
EVERY, SCALES = (1, 2, 3, 4), {1.0: "full size", 3 / 4: "3/4 size", 1 / 2: "1/2 size", 1 / 3: "1/3 size"}
QUICK_SETTINGS: tuple[Setting, ...] = (DEFAULT, (2, 1.0), (4, 1.0), (1, 1 / 2))
QUICK_KINDS = (KINDS[1], KINDS[-1])


def rows(wish: Wish) -> Iterator[Row]:
    """A row for each film and setting, timed one after the other."""
    kinds = {kind.name: (kind, wish.quick, wish.seed) for kind in (QUICK_KINDS if wish.quick else KINDS)}
    for film in replace(wish, where=Where(workers=1)).each(swept, kinds):
        yield from film["settings"]


def swept(job: tuple[Kind, bool, int]) -> Row:
    """One film by all settings; forged films are judged once, because only the times of true films are used."""
    kind, quick, seed = job
    frames, runs = (QUICK_FRAMES, QUICK_RUNS) if quick else (FRAMES, RUNS)
    # Children of the engine are limited to one thread; a user's process is not.
    cv2.setNumThreads(max(cv2.getNumberOfCPUs(), 2))
    with tempfile.TemporaryDirectory() as folder:
        filmed = shoot(kind, frames, seed, Path(folder))
    read(filmed, DEFAULT)  # Tables that a process makes once are made here, and not while a setting is timed.
    settings = QUICK_SETTINGS if quick else [(every, scale) for scale in SCALES for every in EVERY]
    return {"settings": [timed(filmed, setting, 1 if kind.forge else runs) for setting in settings]}


def timed(filmed: DecodedFilm, setting: Setting, runs: int) -> Row:
    """One row: figures of the film, and the processor ms a frame of each run."""
    row, cpu_ms = Row(), []
    for _ in range(runs):
        used = time.process_time()
        row = read(filmed, setting)
        cpu_ms.append(1e3 * (time.process_time() - used) / len(filmed.frames))
    right = (row["verdict"] == "accept") == (filmed.kind.forge is None)
    about = {"film": filmed.kind.name, "forge": filmed.kind.forge, "every": setting[0], "scale": setting[1]}
    return about | row | {"right": right, "cpu_ms": cpu_ms}


def used_frames(frames: list[Frame], setting: Setting) -> Iterator[Frame]:
    """The frames of a setting, numbered as a film of them would be; shrunk by averaging, which moves no centre."""
    every, scale = setting
    for index, frame in enumerate(frames[::every]):
        picture = frame.picture
        if scale != 1:
            size = (round(picture.shape[1] * scale), round(picture.shape[0] * scale))
            picture = Picture(np.asarray(cv2.resize(picture.whole, size, interpolation=cv2.INTER_AREA), np.uint8))
        yield Frame(index, frame.time_s, picture)


def read(filmed: DecodedFilm, setting: Setting) -> Row:
    """The verifier's figures of one film."""
    badge, truth = filmed.badge, filmed.truth
    verifier = Verifier(Question(badge, badge.id), running=False)
    for frame in used_frames(filmed.frames, setting):
        verifier.push(frame)
    chapters = verifier.finish()
    row: Row = {"verdict": worst(list(reasons_of(chapters)))}
    row |= dict.fromkeys(("phase_rad", "pose_rad", "gain_error"))
    measurement, gain = chapters[0].measurement, invariant_of(chapters).gain_ratio
    if measurement is None:
        return row
    signal = measurement.gratings[0]
    used = np.isfinite(signal.phase_sd_rad)
    times = measurement.times_s[used]
    return row | {
        "phase_rad": phase_error_rad(times, signal.measured_rad[used], truth.times_s, truth.shown_rad),
        "pose_rad": phase_error_rad(times, signal.predicted_rad[used], truth.times_s, truth.law_rad),
        "gain_error": None if gain is None else gain - truth.gain,
    }


def table(rows: list[Row]) -> Iterator[Row]:
    """The settings over all films: errors as root mean squares, times as medians over all runs of the true films."""
    for (every, scale), films in grouped(rows, "every", "scale").items():
        right, cpu_ms = (
            sum(row["right"] for row in films),
            [ms for row in films if not row["forge"] for ms in row["cpu_ms"]],
        )
        errors = {name: _rms([row[name] for row in films]) for name in ("phase_rad", "pose_rad", "gain_error")}
        both = math.hypot(errors["phase_rad"] or math.inf, errors["pose_rad"] or math.inf)
        yield {
            "setting": f"every {every}. frame, {SCALES[scale]}",
            "size": SCALES[scale],
            "right": f"{right} of {len(films)}",
            "all_right": right == len(films),
            "both_rad": both,
            "cpu_ms": float(np.median(cpu_ms)),
            "spread": float(np.subtract(*np.percentile(cpu_ms, [75, 25]))),
        } | errors


def _rms(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.sqrt(np.mean(np.square(known)))) if known else None


def knee(rows: list[Row]) -> Iterator[str]:
    """The setting at the knee, in a sentence.

    Convention: least error times run time, where the slope of error against time, both log, is -1: before it a halved
    error costs less than twice the time, after it more.  The error is that of fringes and poses together.
    """
    right = [row for row in table(rows) if row["all_right"]]
    best = min(right, key=lambda row: row["both_rad"] * row["cpu_ms"], default=None)
    yield (
        f"the knee is at {best['setting']}: {best['both_rad']:.4f} rad in {best['cpu_ms']:.2f} CPU ms a frame"
        if best
        else "no setting judges all films right"
    )


COLUMNS = {"setting": "<28", "fringes": "phase_rad >8.4f", "poses": "pose_rad >8.4f", "gain": "gain_error >8.4f"}
COLUMNS |= {"right": ">8", "CPU ms": "cpu_ms >8.2f", "spread": ">8.2f"}
BENCH = Bench(rows, COLUMNS, knee, table=table, plot=("both_rad", "cpu_ms", "size"))
