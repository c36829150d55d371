"""Natural motion by an outside tracer: run `moireid lab bench natural [--films N] [--filmed N]`.

A printed badge is filmed by `outside`, which shares nothing with `moireid.simulate`, with measured motions (a hand's
run, a phone carried about a room) at 1 m and 2 m for 24 s.  Each film is tracked once; its parts of 4, 10 and 24 s are
judged by themselves.  Printed is, by distance and length, how many parts are accepted, inconclusive and rejected, the
same of those whose predicted phase spreads by 0.3 rad or more, the median odds, and processor time; and in how many
nested pairs the longer part's verdict is the worse one.

Then the measured phase of each accepted part of 10 s is forged on its own trajectory, with its own errors kept: each
rival at its best (`KINDS`).  With `--filmed N`, N such trajectories are also filmed with each forgery of
`outside.rivals`.  `--table FILE` writes the figures of all parts, true and forged, which the bench `priors` reads.
"""

from __future__ import annotations

import csv
import pickle
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from outside.build import built
from outside.camera import PHONE, drawn
from outside.film import Shoot, film
from outside.motion import course
from outside.page import load_page
from outside.rivals import KINDS as FILMED_KINDS

from moireid.badge import load_badge
from moireid.verifier import Question, verify
from moireid.verifier.camera.stretches import within_stretches
from moireid.verifier.decision.judge import judge
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.signals import measure
from moireid.verifier.session.claim import sheet_of
from moireid.verifier.tracking.track import Track
from moireid_lab.bench.bench_frame import Bench, Row, Wish, counted_verdicts, grouped

FPS, SECONDS, LENGTHS_S, FORGED_S = 30, 24, (4, 10, 24), 10
MOTIONS, DISTANCES_M = ("walk", "measured"), (1.0, 2.0)
PROGRAM = Path(sys.executable).with_name("print-your-badge")
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
    folder: str
    forge: str | None = None
    seed: int = 0
    seconds: int = SECONDS

    @property
    def name(self) -> str:
        """Unique among films of one run."""
        return "_".join(str(word) for word in (self.motion, self.distance_m, self.number, self.forge or "true"))


def prepared(folder: Path, *options: str) -> Path:
    """The folder of films, with the badge printed into it; options: of `print-your-badge`."""
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "badge").exists():
        wish = ["Guest", "--payload", "0f5ac3962d784be1", "--mount", "none", *options, "--out", str(folder / "badge")]
        subprocess.run([str(PROGRAM), *wish, "--json"], check=True, stdout=subprocess.DEVNULL)
    return folder


def tracked(task: Task) -> Track:
    """Make the film, and follow the badge in it; kept in the task's folder."""
    folder = Path(task.folder)
    kept = folder / f"{task.name}.track"
    if kept.is_file():
        return pickle.loads(kept.read_bytes())  # type: ignore[no-any-return]
    rng = np.random.default_rng([task.seed, MOTIONS.index(task.motion), round(10 * task.distance_m), task.number])
    camera = drawn(rng, PHONE)
    path = course(task.motion, 1000 * task.distance_m, min(task.seconds, 18 if task.motion == "measured" else 40), rng)
    page, video = load_page(folder / "badge"), folder / f"{task.name}.mp4"
    seconds = min(task.seconds, 18) if task.motion == "measured" else task.seconds
    shoot = Shoot(seconds * FPS, FPS, (23, 28)[task.number % 2], int(rng.integers(1 << 30)), task.forge)
    film(page, built(page, rng), camera, path, video, shoot)
    badge = load_badge(folder / "badge" / "badge.json")
    track = replace(verify(video, Question(badge, badge.id)).track, snapshot=None)
    video.unlink()
    kept.write_bytes(pickle.dumps(track))
    return track


def judged(task: Task) -> Row:
    """The parts of a film, judged, and the forgeries of its accepted parts; a filmed forgery is judged whole."""
    track = tracked(task)
    claim = Question(track.badge, track.badge.id)
    lengths = (task.seconds,) if task.forge else LENGTHS_S
    starts = part_starts(lengths, track.frames_read // FPS)
    rows: list[Row] = []
    for length, begins in starts.items():
        for begin in begins:
            within = (track.frame_numbers >= begin * FPS) & (track.frame_numbers < (begin + length) * FPS)
            part = replace(track.only(within), frames_read=length * FPS)
            if part.tracked < 60:
                continue
            signals = measure(part).gratings
            clock = time.process_time()
            row = row_of(task, f"filmed_{task.forge}" if task.forge else "true", signals, claim)
            row |= {"length_s": length, "start_s": begin, "judge_s": time.process_time() - clock}
            rows.append(row)
            if length == FORGED_S and row["verdict"] == "accept":
                rng = np.random.default_rng([task.seed, task.number, begin])
                for kind in KINDS:
                    lie = forged(signals[0], kind, rng)
                    if lie is not None:
                        rows.append(row_of(task, kind, (lie, *signals[1:]), claim) | {"length_s": length})
    return {"parts": rows}


def row_of(task: Task, kind: str, signals: tuple[GratingSignal, ...], claim: Question) -> Row:
    """The figures of one set of signals."""
    found = judge(signals, sheet_of(claim))
    figures = max(found.gratings, key=lambda one: one["information"], default={})
    law = found.explanations[0].parameters if found.explanations else {}
    return {
        "film": task.name,
        "distance_m": task.distance_m,
        "kind": kind,
        "verdict": found.verdict,
        "score": found.score if found.explanations else None,
        "gain": found.gain_ratio,
        "residual_rad": law.get("deviation_rad"),
        **{
            name: figures.get(name)
            for name in ("excitation_rad", "expected_error_rad", "strip_wander_rad", "strip_sd_rad", "place_wander_rad")
        },
        "frames": len(signals[0].times_s),
        "why": " ".join(reason.code for reason in found.reasons if reason.level in ("fail", "undecided")),
    }


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


def rows(wish: Wish) -> Iterator[Row]:
    """One row a part of a film, true or forged."""
    with wish.kept_folder() as name:
        common = {"folder": str(prepared(name)), "seed": wish.seed}
        numbers = range(wish.clips or (1 if wish.quick else 6))
        tasks = [Task(motion, metres, k, **common) for k in numbers for motion in MOTIONS for metres in DISTANCES_M]
        tasks += [
            Task(MOTIONS[k % 2], 1.0, 1000 + k, forge=kind, seconds=FORGED_S, **common)
            for k in range(wish.own.filmed)
            for kind in FILMED_KINDS
        ]
        parts = [part for film in wish.each(judged, {task.name: task for task in tasks}) for part in film["parts"]]
    yield from parts
    if wish.own.table:
        with wish.own.table.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, list(dict.fromkeys(name for part in parts for name in part)))
            writer.writeheader()
            writer.writerows(parts)


def table(parts: list[Row]) -> Iterator[Row]:
    """The true films by distance and length, then the forgeries by kind, then each one that was accepted."""
    true, lies = ([part for part in parts if (part["kind"] == "true") == kind] for kind in (True, False))
    shown = [part | {"seconds": part["length_s"], "why": part["why"].split()} for part in true]
    for (metres, seconds), own in sorted(grouped(shown, "distance_m", "seconds").items()):
        yield {"true badge": f"{metres:g} m", "length": f"{seconds} s"} | part_figures(own)
    for (kind, metres), own in grouped(lies, "kind", "distance_m").items():
        counted = counted_verdicts([part | {"why": part["why"].split()} for part in own])
        yield {"forged": kind, "m": metres, "films": len(own)} | counted
    for part in lies:
        if part["verdict"] == "accept":
            yield {"accepted": part["film"], "kind": part["kind"], "spread, rad": part["excitation_rad"]}
    pairs = [(a, b) for film in grouped(shown, "film").values() for a in film for b in film if inside(a, b)]
    yield {"pairs of parts": len(pairs), "longer worse": sum(worse(longer, part) for part, longer in pairs)}


def part_figures(rows: list[Row]) -> Row:
    """Verdicts, odds and times of parts of one length; "of": those accepted of the ones that move enough."""
    enough = [row for row in rows if (row["excitation_rad"] or 0.0) >= ENOUGH_RAD]
    scores = [row["score"] for row in rows if row["score"] is not None]
    return {
        "films": len(rows),
        **counted_verdicts(rows),
        f"of >= {ENOUGH_RAD:g} rad": f"{sum(row['verdict'] == 'accept' for row in enough)} of {len(enough)}",
        "log10 odds": float(np.median(scores)) if scores else None,
        "ms a frame": 1e3 * sum(row["judge_s"] for row in rows) / sum(row["frames"] for row in rows),
    }


def inside(part: Row, longer: Row) -> bool:
    """Whether a part is inside a longer one of its film."""
    ends = [row["start_s"] + row["length_s"] for row in (part, longer)]
    return part["length_s"] < longer["length_s"] and longer["start_s"] <= part["start_s"] and ends[0] <= ends[1]


def worse(one: Row, other: Row) -> bool:
    """Whether a verdict is worse than another."""
    return VERDICTS.index(one["verdict"]) < VERDICTS.index(other["verdict"])


def part_starts(lengths_s: tuple[int, ...], film_s: int) -> dict[int, list[int]]:
    """When the parts of each length begin, s: `MOST_PARTS` of each at most, none over another, each inside a part of
    every longer length; lengths beyond the film's are left out."""
    found: dict[int, list[int]] = {}
    longer_s, longer = film_s, [0]
    for length_s in sorted((length for length in lengths_s if length <= film_s), reverse=True):
        starts = [start + k * length_s for start in longer for k in range(longer_s // length_s)]
        longer_s, longer = length_s, starts[:MOST_PARTS]
        found[length_s] = longer
    return found


#: From the worst to the best; parts of one length; films with this much motion, rad, hold enough for a verdict.
VERDICTS, MOST_PARTS, ENOUGH_RAD = ("reject", "inconclusive", "accept"), 4, 0.3
COLUMNS = {"true badge": "<16", "length": ">8", "forged": "<16", "m": ">3g", "films": ">7", "accept": ">8"}
COLUMNS |= {"inconclusive": ">13", "reject": ">8", f"of >= {ENOUGH_RAD:g} rad": ">15", "log10 odds": ">12.2f"}
COLUMNS |= {"ms a frame": ">12.2f", "reasons": "<1"}
COLUMNS |= {"accepted": "<30", "kind": "<16", "spread, rad": ">11.2f", "pairs of parts": ">14", "longer worse": ">12"}
OPTIONS = {
    "--filmed": {"type": int, "default": 0, "metavar": "N", "help": "trajectories filmed with each forgery"},
    "--table": {"type": Path, "metavar": "FILE", "help": "write the figures of all parts as CSV"},
}
BENCH = Bench(rows, COLUMNS, options=OPTIONS, table=table)
