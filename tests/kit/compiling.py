"""Has Numba compile the renderer and the sensor, which it keeps next to their files: python -m kit.compiling."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

from kit.places import FILMS
from moireid.badge import load_badge
from moireid.simulate.build import Build
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Camera, Scene

if __name__ == "__main__":
    scene = Scene(load_badge(FILMS / "badge.json"), camera=Camera(width=320, height=180, focal_px=240.0))
    with tempfile.TemporaryDirectory() as folder:
        motion = motion_named("sway", distance_mm=1000.0, seed=1)
        for number, (one, setting) in enumerate([(scene, None), (replace(scene, build=Build(haze=0.1)), "desk")]):
            film(one, motion, Path(folder) / f"film{number}.mp4", frames=2, fps=30.0, setting=setting)
