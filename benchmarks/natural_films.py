"""Natural motion by an outside tracer: run `moireid lab bench natural [--clips N]`.

A printed badge is filmed by `outside`, which shares nothing with `moireid.simulate`, with measured motions (a hand's
run, a phone carried about a room) at 1 m and 2 m for 10 s.  The measured phase of each accepted film is then forged on
its own trajectory, with its own errors kept: each rival at its best (`KINDS`).  On both motions each forgery of
`outside.rivals` is filmed too.
"""

from __future__ import annotations

import shutil
import tempfile
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from outside.build import built
from outside.camera import PHONE, drawn
from outside.film import Shoot, film
from outside.motion import course
from outside.page import load_page
from outside.rivals import KINDS as FILMED_KINDS

from moireid.badge import load_badge
from moireid.designer import Order
from moireid.verifier import Question, verify
from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.decision.judge import judge
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.session.claim import sheet_of
from moireid_lab.bench.part import OUTSIDE, Asked, Part, Row, answer_of, film_row, interleaved, printed

FPS, SECONDS = 30, 10
MOTIONS, DISTANCES_M = ("walk", "measured"), (1.0, 2.0)
#: Numerical forgeries on a part's own trajectory.
KINDS = (
    "drift", "late_0.3", "late_0.5", "late_1", "late_2", "early_0.3", "place", "gain_0.5", "gain_0.8", "gain_1.25",
    "wander_0.2", "still_0.3", "still_0.5", "still_1", "stop_0.3", "stop_0.5",
)  # fmt: skip
#: Least motion of the law in a lie for a while, rad.
LEAST_RAD = 0.25


@dataclass(frozen=True)
class Task:
    """One film: motion, distance, number, and the filmed forgery, if any."""

    motion: str
    distance_m: float
    number: int
    forge: str | None = None

    @property
    def name(self) -> str:
        """Unique among films of one run."""
        return "_".join(str(word) for word in (self.motion, self.distance_m, self.number, self.forge or "true"))


def prepared(folder: Path, **wish: Any) -> Path:
    """The folder of films, with the badge printed into it; wish: fields of its order."""
    if not (folder / "badge").exists():
        folder.mkdir(parents=True, exist_ok=True)
        own = Path(tempfile.mkdtemp(dir=folder))
        printed(Order("Guest", **{"payload": "0f5ac3962d784be1"} | wish), own / "badge")
        # Another process may have printed it meanwhile.
        with suppress(OSError):
            (own / "badge").rename(folder / "badge")
        shutil.rmtree(own)
    return folder


def judged(task: Task, folder: Path) -> Row:
    """Make a film and judge it; of a true one that is accepted, its forged signals too."""
    home = prepared(folder) / "badge"
    rng = np.random.default_rng([MOTIONS.index(task.motion), round(10 * task.distance_m), task.number])
    camera, page, video = drawn(rng, PHONE), load_page(home), folder / f"{task.name}.mp4"
    path = course(task.motion, 1000 * task.distance_m, SECONDS, rng)
    shoot = Shoot(SECONDS * FPS, FPS, (23, 28)[task.number % 2], int(rng.integers(1 << 30)), task.forge)
    film(page, built(page, rng), camera, path, video, shoot)
    badge = load_badge(home / "badge.json")
    claim = Question(badge, badge.id)
    report = verify(video, claim)
    video.unlink()
    if task.forge:
        return film_row(f"filmed, {task.forge}", report, true=False)
    row = film_row(f"{task.motion}, {task.distance_m:g} m", report, true=True)
    if report.verdict == "accept" and report.measurement is not None:
        first, *others = report.measurement.gratings
        lies = (forged(first, kind, rng) for kind in KINDS)
        verdicts = [judge((lie, *others), sheet_of(claim)).verdict for lie in lies if lie is not None]
        counts = np.array([answer_of(verdict, true=False) for verdict in verdicts])
        row["answers"]["signals"] = counts.sum(axis=0).tolist()
    return row


def forged(signal: GratingSignal, kind: str, rng: np.random.Generator) -> GratingSignal | None:
    """A signal whose fringes do what a rival says, with the film's own errors; None where the law does not move so."""
    name, _, figure = kind.partition("_")
    times, law, errors = signal.times_s, signal.predicted_rad, signal.measured_rad - signal.predicted_rad
    read = np.isfinite(signal.phase_sd_rad)
    if name == "drift":
        phase = np.polyfit(times[read], law[read], 1)[0] * (times - times.mean())
    elif name in ("late", "early"):
        phase = np.interp(times - (1 if name == "late" else -1) * float(figure), times, law)
    elif name == "place":
        assert signal.beyond is not None
        place = signal.beyond.place_px - signal.beyond.place_px.mean(axis=0)
        phase = place @ np.linalg.lstsq(place[read], law[read] - law[read].mean(), rcond=None)[0]
    elif name == "gain":
        phase = float(figure) * law
    elif name == "wander":
        waves = np.sin(2 * np.pi * np.outer(times, rng.uniform(0.2, 1.0, 4)) + rng.uniform(0, 2 * np.pi, 4)).sum(axis=1)
        phase = law + float(figure) * waves / waves.std()
    else:
        spell = _spell(signal, float(figure), rng)
        if spell is None:
            return None
        phase = law.copy()
        phase[spell] = law[spell[0]]
        if name == "stop":
            phase[spell[-1] + 1 :] -= law[spell[-1]] - law[spell[0]]
    return replace(signal, measured_rad=within_stretches(phase + errors, signal.stretch))


def _spell(signal: GratingSignal, seconds: float, rng: np.random.Generator) -> np.ndarray | None:
    """Frames of a spell in which the law moves by `LEAST_RAD` and the badge is seen; None where there is none."""
    times = signal.times_s
    count = round(seconds / float(np.median(np.diff(times)))) + 1
    read = np.isfinite(signal.phase_sd_rad)
    begins = [
        k
        for k in range(len(times) - count)
        if signal.stretch[k] == signal.stretch[k + count - 1]
        and times[k + count - 1] - times[k] < 1.3 * seconds + 0.05
        and read[k : k + count].mean() > 0.9
        and np.ptp(signal.predicted_rad[k : k + count]) >= LEAST_RAD
    ]
    return int(rng.choice(begins)) + np.arange(count) if begins else None


def cases(asked: Asked) -> dict[str, Task]:
    """All films."""
    places = [(motion, metres) for motion in MOTIONS for metres in DISTANCES_M]
    true = [Task(*places[k % len(places)], k // len(places)) for k in range(asked.clips or 30)]
    lies = [Task(motion, 1.0, 1000 + k, kind) for k, motion in enumerate(MOTIONS) for kind in FILMED_KINDS]
    return interleaved({task.name: task for task in true}, {task.name: task for task in lies})


QUESTIONS = {
    "genuine": "Is a true film of 10 s of natural motion accepted?",
    "signals": "Is its measured phase rejected once it is forged on its own trajectory? 16 kinds",
    "forged": "Is a film rejected that is forged on its own trajectory? 11 kinds",
}
PART = Part(QUESTIONS, OUTSIDE, cases, judged, 2)
