"""Seconds that a 10 s film takes, by stage: run `.venv/bin/python benchmarks/film_speed.py [CAMERA ...]`.

60 frames a second, 1080p where the camera has it, the default badge held in the hand at 1 m, sensor and H.264.  A
short film runs first, so that compiling is not counted; its time is printed separately.  CPU seconds are those of all
threads: divided by the number of cores, they are the least time on idle cores; a busy machine takes longer.  The limit
is what encoding alone takes of pictures that lie ready, CPU milliseconds a frame; the ratio is over that.
"""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import time
from pathlib import Path

import numba
import numpy as np
from numpy.typing import NDArray

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import Motion, motion_named
from moireid.simulate.recording.encode import FilmWriter, recipe_for
from moireid.simulate.scene import Build, Scene

SECONDS, FPS = 10, 60.0
#: Pictures that are encoded alone.
READY = 120


def encoding_s(scene: Scene, motion: Motion, video: Path) -> float:
    """CPU seconds a frame of encoding pictures that lie ready."""
    ready: list[NDArray[np.uint8]] = []

    def kept(number: int, picture: NDArray[np.uint8], homography: NDArray[np.float64]) -> NDArray[np.uint8]:
        ready.append(picture)
        return picture

    film(scene, motion, video, frames=READY, fps=FPS, edit=kept, overwrite=True)
    used = time.process_time()
    size = (scene.camera.width, scene.camera.height)
    with FilmWriter(video, video.name, size, FPS, recipe_for(None, "h264", None)) as writer:
        for number, picture in enumerate(ready):
            writer.write(picture, number)
    return (time.process_time() - used) / len(ready)


def main() -> None:
    """Print one row a camera."""
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    print(
        f"{platform.machine()}, {os.cpu_count()} cores, numba {numba.__version__} on {numba.get_num_threads()} threads"
    )
    words = ("render", "sensor", "encode", "total s", "CPU s", "CPU ms", "limit ms", "ratio")
    columns = "".join(f"{word:>9}" for word in words)
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
            frame_ms, limit_ms = 1e3 * used / report.frames, 1e3 * encoding_s(scene, motion, video)
            shares = f"{used:>9.1f}{frame_ms:>9.1f}{limit_ms:>9.1f}{frame_ms / limit_ms:>9.2f}"
            print(f"{name:<12}{compiled - begun:>16.1f}{stages}{total:>9.1f}{shares}{size:>7.1f}", flush=True)


if __name__ == "__main__":
    main()
