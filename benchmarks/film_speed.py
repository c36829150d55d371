"""Seconds that a 10 s film takes, by stage: run `.venv/bin/python benchmarks/film_speed.py [CAMERA ...]`.

60 frames a second, 1080p where the camera has it, the default badge held in the hand at 1 m, sensor and H.264.  A
short film runs first, so that compiling is not counted; its time is printed separately.  CPU seconds are those of all
threads: divided by the number of cores, they are the least time on idle cores; a busy machine takes longer.
"""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import time
from pathlib import Path

import numba

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene

SECONDS, FPS = 10, 60.0


def main() -> None:
    """Print one row a camera."""
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    print(
        f"{platform.machine()}, {os.cpu_count()} cores, numba {numba.__version__} on {numba.get_num_threads()} threads"
    )
    columns = "".join(f"{word:>9}" for word in ("render", "sensor", "encode", "total s", "CPU s"))
    print(f"{'camera':<12}{'first 2 frames':>16}{columns}{'MB':>7}")
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        for name in sys.argv[1:] or ["phone"]:
            scene = Scene(badge, Build.typical(1), camera_named(name))
            motion = motion_named("handheld", distance_mm=1000.0, seed=1)
            begun = time.perf_counter()
            film(scene, motion, video, frames=2, fps=FPS, overwrite=True)
            compiled, used = time.perf_counter(), time.process_time()
            report = film(scene, motion, video, frames=round(SECONDS * FPS), fps=FPS, overwrite=True)
            total, used = time.perf_counter() - compiled, time.process_time() - used
            stages = "".join(f"{report.stages_s[stage]:>9.1f}" for stage in ("render", "sensor", "encode"))
            size = video.stat().st_size / 1e6
            print(f"{name:<12}{compiled - begun:>16.1f}{stages}{total:>9.1f}{used:>9.1f}{size:>7.1f}", flush=True)


if __name__ == "__main__":
    main()
