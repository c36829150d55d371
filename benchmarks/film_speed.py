"""Seconds that a 10 s film takes, by stage: run `.venv/bin/python benchmarks/film_speed.py [--cameras NAME ...]`.

60 frames a second, 1080p where the camera has it, the default badge held in the hand at 1 m, sensor and H.264.  A
short film runs first, so that compiling is not counted; its time is printed separately.  CPU seconds are those of all
threads: divided by the number of cores, they are the least time on idle cores; a busy machine takes longer.  The limit
is what encoding alone takes of pictures that lie ready, CPU milliseconds a frame; the ratio is over that.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import Motion, motion_named
from moireid.simulate.recording.encode import FilmWriter, recipe_for
from moireid.simulate.scene import Build, Scene
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

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


def rows(wish: Wish) -> Iterator[Row]:
    """One row a camera."""
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    motion, frames = motion_named("handheld", distance_mm=1000.0, seed=1), round((1 if wish.quick else SECONDS) * FPS)
    for name in wish.own.cameras:
        with tempfile.TemporaryDirectory() as folder:
            video, scene = Path(folder) / "film.mp4", Scene(badge, Build.typical(1), camera_named(name))
            begun = time.perf_counter()
            film(scene, motion, video, frames=2, fps=FPS, overwrite=True)
            compiled, used = time.perf_counter(), time.process_time()
            report = film(scene, motion, video, frames=frames, fps=FPS, overwrite=True)
            total, used = time.perf_counter() - compiled, time.process_time() - used
            megabytes, frame_ms = video.stat().st_size / 1e6, 1e3 * used / report.frames
            limit_ms = 1e3 * encoding_s(scene, motion, video)
        yield {
            "camera": name,
            "first 2 frames": compiled - begun,
            **{stage: report.stages_s[stage] for stage in ("render", "sensor", "encode")},
            "total s": total,
            "CPU s": used,
            "CPU ms": frame_ms,
            "limit ms": limit_ms,
            "ratio": frame_ms / limit_ms,
            "MB": megabytes,
        }


COLUMNS = {"camera": "<11", "first 2 frames": ">15.1f", "render": ">8.1f", "sensor": ">8.1f", "encode": ">8.1f"}
COLUMNS |= {
    "total s": ">8.1f",
    "CPU s": ">8.1f",
    "CPU ms": ">8.1f",
    "limit ms": ">8.1f",
    "ratio": ">8.2f",
    "MB": ">6.1f",
}
BENCH = Bench(rows, COLUMNS, options={"--cameras": {"nargs": "+", "default": ["phone"]}})

if __name__ == "__main__":
    run_script(__file__)
