"""What the verifier says of each kind of film: run `.venv/bin/python benchmarks/film_verdicts.py [WORD ...]`.

A swaying badge at 1 m, 7 s at 30 frames a second, 1080p where nothing else is said: every forgery, then the true film
through every camera, codec, recipe and motion.  WORDs leave only the rows that they begin.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import CAMERAS, camera_named
from moireid.simulate.filming import film
from moireid.simulate.forgeries.trajectories import KINDS
from moireid.simulate.motion import motion_named
from moireid.simulate.recording.encode import CODECS, RECIPES
from moireid.simulate.scene import Build, Scene
from moireid.verifier import Claim, verify
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import Limits, LostJob

FRAMES, FPS, SEED, DISTANCE_MM = 210, 30.0, 5, 1000.0
LIMITS = Limits(memory_mb=8192)
MOTIONS = ("handheld", "linear", "roll", "oblique", "tumble", "circle")


def rows() -> dict[str, dict[str, Any]]:
    """Every film by name: what differs from a true film of a swaying badge."""
    films: dict[str, dict[str, Any]] = {"genuine": {}}
    films |= {f"forged:{kind}": {"forge": kind} for kind in KINDS}
    films |= {f"camera:{name}": {"camera": camera_named(name)} for name in CAMERAS if name != "phone"}
    films |= {
        "camera:mirror": {"camera": camera_named("phone", mirror=True)},
        "camera:blur 2 px": {"camera": camera_named("phone", focus_blur_px=2.0)},
    }
    films |= {f"codec:{name}": {"codec": name} for name in CODECS if name != "h264"}
    films |= {f"recipe:{name}": {"recipe": name} for name in RECIPES}
    return films | {f"motion:{name}": {"motion": name} for name in MOTIONS}


def line_of(name: str) -> str:
    """The line of a film by its name, filmed and verified in a folder of its own."""
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    with tempfile.TemporaryDirectory() as folder:
        return f"{name:<20}{verdict_of(badge, Path(folder), **rows()[name])}"


def verdict_of(badge: Badge, folder: Path, *, motion: str = "sway", camera: Any = None, **options: Any) -> str:
    """Film and verify; one line of figures."""
    scene = Scene(badge, Build.typical(SEED), camera or camera_named("phone"))
    course = motion_named(motion, distance_mm=DISTANCE_MM, seed=SEED)
    video = folder / "film.mp4"
    film(scene, course, video, frames=FRAMES, fps=FPS, seed=SEED, overwrite=True, **options)
    report = verify(video, Claim(badge, badge.id))
    found = report.invariant
    against = [reason.code for reason in report.reasons if reason.level in ("fail", "undecided")]
    return (
        f"{report.verdict:<13}{found.verdict:<13}{report.identity.verdict:<11}{_figure(found.correlation)}"
        f"{_figure(found.gain_ratio)}{_figure(found.phase_residual_rad)}{video.stat().st_size / 1e6:>7.2f}"
        f"  {' '.join(against)}"
    )


def _figure(value: float | None) -> str:
    return f"{'':>9}" if value is None else f"{value:>9.3f}"


def main() -> None:
    """Print one row a film, as they come."""
    # Other processes know this file by its name alone.
    from film_verdicts import line_of

    head = f"{'verdict':<13}{'invariant':<13}{'identity':<11}{'|rho|':>9}{'gain':>9}{'residual':>9}{'MB':>7}  against"
    print(f"{'film':<20}{head}")
    names = [name for name in rows() if len(sys.argv) == 1 or name.startswith(tuple(sys.argv[1:]))]
    for place, done in run_tasks(line_of, [Task((name,)) for name in names], limits=LIMITS):
        (line,) = done.outcomes
        print(f"{names[place]:<20}{line.why}" if isinstance(line, LostJob) else line, flush=True)


if __name__ == "__main__":
    main()
