"""What flaws cost to film and do to a verdict: `.venv/bin/python benchmarks/flawed_builds.py [--only REGEX] [--quick]`.

Each build of `moireid simulate --build` and each flaw of `--flaw`, by itself at the size that the usual build has, is
traced at 1 m, and filmed there for 5 s by a camera that circles.  Printed are CPU milliseconds of tracing the badge in
a frame, the least of some, over those of the ideal build in the same run; and verdict and gain of the film, not
enrolled (not with `--quick`).  `benchmarks/builds.py` asks the same of an outside tracer.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.build import Build, build_named, flawed
from moireid.simulate.filming import film
from moireid.simulate.flaw_table import BUILDS, PRESETS
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Instant, Scene
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script
from moireid_lab.bench.verdicts import why_not

SEED, RUNS, FRAMES, FPS = 5, 15, 150, 30.0
#: Flaws that the usual build lacks.
OTHERS = {"gradient": 0.003, "corner": 3.0, "ellipse": -0.4, "jitter": 0.005}


def named_builds() -> dict[str, Build]:
    """Every build by name, and every flaw by itself on a typical one."""
    found = {name: build_named(name, SEED) for name in BUILDS}
    single = PRESETS["usual"] | OTHERS
    return found | {f"{name}={value:g}": flawed(Build.typical(SEED), {name: value}) for name, value in single.items()}


def traced_ms(scene: Scene) -> float:
    """CPU milliseconds of tracing one frame, the least of some."""
    renderer = AnalyticRenderer(scene)
    poses = motion_named("handheld", distance_mm=1000.0, seed=SEED)(np.array([0.4]))
    instant = Instant(poses, poses, poses.camera_mm[0])
    renderer.render(instant)
    found = []
    for _ in range(RUNS):
        begun = time.process_time()
        renderer.render(instant)
        found.append(time.process_time() - begun)
    return 1e3 * min(found)


def rows(wish: Wish) -> Iterator[Row]:
    """One row a build."""
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    builds = named_builds()
    ideal_ms = traced_ms(Scene(badge, builds["ideal"]))
    for name in wish.chosen(builds):
        scene = Scene(badge, builds[name])
        cost_ms = ideal_ms if name == "ideal" else traced_ms(scene)
        row: Row = {"build": name, "ms": cost_ms, "over ideal": cost_ms / ideal_ms}
        if not wish.quick:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "film.mp4"
                motion = motion_named("circle", distance_mm=1000.0, seed=SEED)
                film(scene, motion, path, frames=FRAMES, fps=FPS, seed=SEED)
                report = verify(path, Claim(badge, badge.id))
            row |= {"verdict": report.verdict, "gain": report.invariant.gain_ratio, "why": why_not(report)}
            row |= {"identity": report.identity.verdict}
        yield row


COLUMNS = {"build": "<17", "ms": ">7.1f", "over ideal": ">10.1f", "verdict": "<12", "gain": ">6.3f"}
COLUMNS |= {"identity": "<12", "why": "<1"}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
