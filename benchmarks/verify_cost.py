"""What a verify costs, and how exact it is: run `.venv/bin/python benchmarks/verify_cost.py [--keep DIR]`.

Sweeps of length, picture size, frame rate and badge size, one thing at a time; the rest stays as in the middle film:
1080p, 30 frames a second, 4 s, 1 m, swaying.  Each film is verified in a process of its own.  CPU seconds are those
of all threads, from opening the file to the verdict, imports apart; the least of some runs.  Errors are against the
simulator's truth: of the phase of the fringes and of that which the poses predict, together, rad (RMS); and of the
gain.  A longer film is the middle one over and over, its packets copied; where a loop ends the badge jumps, so its
phase has no error here, but its gain has.

Then error against run time of the whole verifier, decoding and all: frames are skipped or shrunk after decoding.  The
default uses all; the knee is the least error times time.  It is
drawn in `verify_cost.svg`.

With `--minutes N` a film of so many minutes instead, loops of 12 s, and the memory as it goes.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from verify_speed import looped

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import PictureFormat, camera_named
from moireid.simulate.filming import film as film_it
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped, run_script
from moireid_lab.bench.bench_plots import error_against_time
from moireid_lab.bench.verify.films import Array, FilmTruth, phase_error_rad, truth_of

BADGE = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
SEED, RUNS = 3, 2
LOOPS = (1, 4, 15)
WIDTHS, RATES, DISTANCES_M = (640, 1280, 1920, 3840), (15, 30, 60, 120), (0.7, 1.0, 1.5, 2.2, 3.0)
EVERY, SHRINKS = (1, 2, 4), (1, 2, 3)


@dataclass(frozen=True)
class Kind:
    """A film: width of its picture, px (9/16 of it high), frames a second, distance, m, length, s, and loops of it."""

    width: int = 1920
    fps: int = 30
    distance_m: float = 1.0
    length_s: float = 4.0
    loops: int = 1

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.width}_{self.fps}_{self.distance_m:g}_{self.length_s:g}"

    @property
    def badge_px(self) -> float:
        """Width of the badge's page at that distance, px."""
        width_mm: float = BADGE.page_mm[0]
        return self.camera().focal_px * width_mm / (1000 * self.distance_m)

    def camera(self) -> Any:
        """A phone's, with pictures of this size."""
        return PictureFormat(self.width, self.width * 9 // 16, float(self.fps)).of(camera_named("phone"))


#: Each sweep: its name, unit, and its films with their place on the axis.
SWEEPS: dict[str, tuple[str, list[tuple[float, Kind]]]] = {
    "length": ("s", [(4.0 * loops, Kind(loops=loops)) for loops in LOOPS]),
    "picture": ("pixels, million", [(width * width * 9 / 16 / 1e6, Kind(width=width)) for width in WIDTHS]),
    "frame rate": ("frames a second", [(float(fps), Kind(fps=fps)) for fps in RATES]),
    "badge": ("width in the picture, px", [(Kind(distance_m=m).badge_px, Kind(distance_m=m)) for m in DISTANCES_M]),
}


@dataclass(frozen=True)
class Setting:
    """Frames used, every so many; and pixels across and down that are averaged to one."""

    every: int = 1
    shrink: int = 1


def filmed(kind: Kind, folder: Path) -> Path:
    """The film, in the folder; made unless it lies there."""
    once = folder / f"{kind.name}.mp4"
    if not once.exists():
        motion = motion_named("sway", distance_mm=1000 * kind.distance_m, seed=SEED)
        scene, frames = Scene(BADGE, Build(), kind.camera()), round(kind.fps * kind.length_s)
        film_it(scene, motion, once, frames=frames, fps=float(kind.fps), seed=SEED, overwrite=True)
    loops = folder / f"{kind.name}_{kind.loops}.mp4"
    return once if kind.loops == 1 else loops if loops.exists() else looped(once, kind.loops, loops)


def measured(path: Path, once: Path, badge_path: Path, setting: Setting, runs: int = RUNS) -> Row:
    """Cost of one film in a process of its own, and its errors against the truth of `once`."""
    asked = json.dumps([str(path), str(badge_path), setting.every, setting.shrink, runs])
    command = [sys.executable, str(Path(__file__).with_name("one_verify.py")), asked]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    found: dict[str, Any] = json.loads(done.stdout)
    truth, signals, gain = truth_of(BADGE, once), found.pop("signals"), found.pop("gain")
    error = error_rad(*map(np.array, signals), truth) if signals and path == once else None
    ratios = {"ms": 1e3 * found["cpu_s"] / found["frames"], "ratio": found["cpu_s"] / found["decode_s"]}
    return {**found, **ratios, "error_rad": error, "gain_error": None if gain is None else gain - truth.gain}


def error_rad(times_s: Array, measured_rad: Array, predicted_rad: Array, truth: FilmTruth) -> float | None:
    """Error of measured and predicted phase together; None where it is not known."""
    errors = [
        phase_error_rad(times_s, own, truth.times_s, true)
        for own, true in ((measured_rad, truth.shown_rad), (predicted_rad, truth.law_rad))
    ]
    known = [error for error in errors if error is not None]
    return math.hypot(*known) if len(known) == len(errors) else None


def knee_of(settings: list[dict[str, Any]]) -> dict[str, Any]:
    """The setting of least error times time among those that accept the film."""
    right = [one for one in settings if one["verdict"] == "accept" and one["error_rad"] is not None]
    return min(right, key=lambda one: one["error_rad"] * one["cpu_s"])


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film, then one a setting; or those of a long film."""
    with wish.kept_folder() as folder, tempfile.TemporaryDirectory() as temporary:
        badge_path = Path(temporary) / "badge.json"
        badge_path.write_text(BADGE.to_json(), encoding="utf-8")
        if wish.own.minutes:
            once = Kind(length_s=12.0)
            long = Kind(length_s=12.0, loops=round(5 * wish.own.minutes))
            found = measured(filmed(long, folder), filmed(once, folder), badge_path, Setting(), 1)
            yield from ({"minute": read / 60 / once.fps, "MB": memory} for read, memory in found["course"])
            yield {"sweep": f"{wish.own.minutes:g} minutes"} | found
            return
        kinds = [(name, f"{at:.4g} {unit}", kind) for name, (unit, own) in SWEEPS.items() for at, kind in own]
        wanted = wish.chosen([*(f"{name} {place}" for name, place, _ in kinds), "setting"])
        for name, place, kind in kinds:
            if f"{name} {place}" in wanted:
                once = filmed(Kind(kind.width, kind.fps, kind.distance_m, kind.length_s), folder)
                yield {"sweep": name, "film": place} | measured(filmed(kind, folder), once, badge_path, Setting())
        middle = filmed(Kind(fps=60), folder)
        for setting in (Setting(every, shrink) for shrink in SHRINKS for every in EVERY) if "setting" in wanted else ():
            words = {"sweep": "setting", "film": f"1/{setting.every} of frames, 1/{setting.shrink} size"}
            yield words | asdict(setting) | measured(middle, middle, badge_path, setting)


def plot(found: list[Row]) -> Iterator[str]:
    """Error against run time, with the default and the knee."""
    settings = [row for row in found if row.get("sweep") == "setting"]
    if not settings:
        return
    marked = {"the default": settings[0], "the knee": knee_of(settings)}
    for words, one in marked.items():
        yield f"{words}: {one['film']}: {one['error_rad']:.4f} rad in {one['cpu_s']:.2f} CPU s"
    series = {f"1/{shrink} size": own for shrink, own in grouped(settings, "shrink").items()}
    errors = {"phase error of fringes and poses, rad": lambda row: row["error_rad"]}
    figure = error_against_time(series, errors, lambda row: row["cpu_s"], "CPU s, decoding and all", marked)
    figure.savefig("verify_cost.svg")
    yield "written: verify_cost.svg"


COLUMNS = {"minute": ">6.0f", "MB": ">6.0f", "sweep": "<11", "film": "<34", "frames": ">7", "CPU s": "cpu_s >7.2f"}
COLUMNS |= {"ms": ">7.2f", "/dec.": "ratio >7.2f", "wall s": "wall_s >7.2f", "peak MB": "peak_mb >7.0f"}
COLUMNS |= {"rad": "error_rad >8.4f", "gain": "gain_error >8.4f", "verdict": "<1"}
OPTIONS = {"--minutes": {"type": float, "default": 0.0, "metavar": "N", "help": "a film of so many minutes instead"}}
BENCH = Bench(rows, COLUMNS, plot, OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
