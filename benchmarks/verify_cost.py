"""What a verify costs, and how exact it is: run `.venv/bin/python benchmarks/verify_cost.py --out DIR [--films DIR]`.

Sweeps of length, picture size, frame rate and badge size, one thing at a time; the rest stays as in the middle film:
1080p, 30 frames a second, 4 s, 1 m, swaying.  Each film is verified in a process of its own.  CPU seconds are those
of all threads, from opening the file to the verdict, imports apart; the least of some runs.  Errors are against the
simulator's truth: of the phase of the fringes and of that which the poses predict, together, rad (RMS); and of the
gain.  A longer film is the middle one over and over, its packets copied; where a loop ends the badge jumps, so its
phase has no error here, but its gain has.

Then error against run time of the whole verifier, decoding and all: frames are skipped or shrunk after decoding.  The
default uses all; the knee is the least error times time.  `DIR` gets `verify_cost.json` and `verify_cost.svg`.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from verify_speed import looped

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import PictureFormat, camera_named
from moireid.simulate.filming import film as film_it
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene
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


def measured(path: Path, once: Path, badge_path: Path, setting: Setting) -> dict[str, Any]:
    """Cost of one film in a process of its own, and its errors against the truth of `once`."""
    asked = json.dumps([str(path), str(badge_path), setting.every, setting.shrink, RUNS])
    command = [sys.executable, str(Path(__file__).with_name("one_verify.py")), asked]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    found: dict[str, Any] = json.loads(done.stdout)
    truth, signals, gain = truth_of(BADGE, once), found.pop("signals"), found.pop("gain")
    error = error_rad(*map(np.array, signals), truth) if signals and path == once else None
    return {**found, "error_rad": error, "gain_error": None if gain is None else gain - truth.gain}


def error_rad(times_s: Array, measured_rad: Array, predicted_rad: Array, truth: FilmTruth) -> float | None:
    """Error of measured and predicted phase together; None where it is not known."""
    errors = [
        phase_error_rad(times_s, own, truth.times_s, true)
        for own, true in ((measured_rad, truth.shown_rad), (predicted_rad, truth.law_rad))
    ]
    known = [error for error in errors if error is not None]
    return math.hypot(*known) if len(known) == len(errors) else None


def row(name: str, place: str, found: dict[str, Any]) -> str:
    """One line of the table."""
    frames, verdict = found["frames"], found["verdict"]
    cost = f"{found['cpu_s']:>8.2f}{1e3 * found['cpu_s'] / frames:>8.2f}{found['cpu_s'] / found['decode_s']:>8.2f}"
    errors = f"{_figure(found['error_rad'], 4):>9}{_figure(found['gain_error'], 4):>9}"
    return f"{name:<12}{place:>24}{frames:>8}{cost}{found['wall_s']:>8.2f}{found['peak_mb']:>8.0f}{errors}  {verdict}"


def _figure(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def knee_of(settings: list[dict[str, Any]]) -> dict[str, Any]:
    """The setting of least error times time among those that accept the film."""
    right = [one for one in settings if one["verdict"] == "accept" and one["error_rad"] is not None]
    return min(right, key=lambda one: one["error_rad"] * one["cpu_s"])


def plot(sweeps: dict[str, list[dict[str, Any]]], settings: list[dict[str, Any]]) -> Any:
    """Cost of each sweep with its error, then error against run time."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 7), layout="constrained")
    FigureCanvasSVG(figure)
    panels = figure.subplots(2, 3)
    for axes, (name, found) in zip(panels.flat, sweeps.items(), strict=False):
        places = [one["place"] for one in found]
        axes.loglog(places, [one["cpu_s"] for one in found], "o-", color="#12406b", label="verify, CPU s")
        axes.loglog(places, [one["decode_s"] for one in found], "s--", color="#5a6673", label="decoding, CPU s")
        right_axis = axes.twinx()
        right_axis.set_yscale("log")
        key = "gain_error" if name == "length" else "error_rad"
        errors = [math.nan if one[key] is None else abs(one[key]) for one in found]
        words = "error of the gain" if name == "length" else "phase error, rad"
        right_axis.plot(places, errors, "^:", color="#c2571a", label=words)
        right_axis.set_ylabel(words, color="#c2571a", fontsize=8)
        axes.set_xlabel(f"{name}: {SWEEPS[name][0]}")
        axes.legend(fontsize=7, loc="upper left", frameon=False)
    axes = panels.flat[len(sweeps)]
    for shrink, colour in zip(SHRINKS, ("#12406b", "#3fa7a0", "#c9a227"), strict=True):
        own = [one for one in settings if one["shrink"] == shrink and one["error_rad"] is not None]
        size = "full size" if shrink == 1 else f"1/{shrink} size"
        axes.loglog([one["error_rad"] for one in own], [one["cpu_s"] for one in own], "o-", color=colour, label=size)
        for one in own:
            axes.annotate(f" 1/{one['every']}", (one["error_rad"], one["cpu_s"]), fontsize=7)
    for one, mark, words in ((settings[0], "*", "the default"), (knee_of(settings), "o", "the knee")):
        if one["error_rad"] is not None:
            axes.plot(one["error_rad"], one["cpu_s"], mark, mfc="none", mec="#c0392b", markersize=15, label=words)
    axes.set_xlabel("phase error of fringes and poses, rad (share of frames: 1/n)")
    axes.set_ylabel("CPU s, decoding and all")
    axes.legend(fontsize=7, frameon=False)
    panels.flat[-1].axis("off")
    return figure


def main() -> None:
    """Print the tables as rows come, then write JSON and plot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, metavar="DIR", default=Path("verify_cost"))
    parser.add_argument("--films", type=Path, metavar="DIR", help="keep the films here, and use those that lie here")
    given = parser.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, OpenCV {cv2.__version__}")
    words = f"{'frames':>8}{'CPU s':>8}{'ms':>8}{'/dec.':>8}{'wall s':>8}{'MB':>8}{'rad':>9}{'gain':>9}  verdict"
    print(f"{'sweep':<12}{'':>24}{words}")
    sweeps: dict[str, list[dict[str, Any]]] = {}
    known: dict[Kind, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.films or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        badge_path = Path(temporary) / "badge.json"
        badge_path.write_text(BADGE.to_json(), encoding="utf-8")
        for name, (unit, kinds) in SWEEPS.items():
            for place, kind in kinds:
                once = filmed(Kind(kind.width, kind.fps, kind.distance_m, kind.length_s), folder)
                if kind not in known:
                    known[kind] = measured(filmed(kind, folder), once, badge_path, Setting())
                sweeps.setdefault(name, []).append({"place": place, **asdict(kind), **known[kind]})
                print(row(name, f"{place:.4g} {unit.partition(',')[0]}", known[kind]), flush=True)
        middle = filmed(Kind(fps=60), folder)
        settings = []
        for setting in (Setting(every, shrink) for shrink in SHRINKS for every in EVERY):
            settings.append({**asdict(setting), **measured(middle, middle, badge_path, setting)})
            words = f"1/{setting.every} of frames, 1/{setting.shrink} size"
            print(row("setting", words, settings[-1]), flush=True)
    knee, default = knee_of(settings), settings[0]
    for words, one in (("default", default), ("knee", knee)):
        print(
            f"{words}: 1/{one['every']} of the frames at 1/{one['shrink']} size: {_figure(one['error_rad'], 4)} rad in "
            f"{one['cpu_s']:.2f} CPU s"
        )
    given.out.mkdir(parents=True, exist_ok=True)
    document = {"sweeps": sweeps, "settings": settings, "knee": knee, "machine": platform.machine()}
    (given.out / "verify_cost.json").write_text(json.dumps(document, indent=1), encoding="utf-8")
    plot(sweeps, settings).savefig(given.out / "verify_cost.svg")


if __name__ == "__main__":
    main()
