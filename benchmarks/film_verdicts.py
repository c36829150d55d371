"""What the verifier says of each kind of film: run `.venv/bin/python benchmarks/film_verdicts.py [--only REGEX]`.

A swaying badge at 1 m, 7 s at 30 frames a second, 1080p where nothing else is said: every forgery, then the true film
through every camera, codec, recipe and motion.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import CAMERAS, camera_named
from moireid.simulate.forgeries.trajectories import KINDS
from moireid.simulate.motion import motion_named
from moireid.simulate.recording.encode import CODECS, RECIPES
from moireid.simulate.scene import Build, Scene
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script, temporary_film
from moireid_lab.bench.verdicts import why_not

FRAMES, FPS, SEED, DISTANCE_MM = 210, 30.0, 5, 1000.0
MOTIONS = ("handheld", "linear", "roll", "oblique", "tumble", "circle")


def kinds() -> dict[str, dict[str, Any]]:
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


def judged(name: str) -> Row:
    """Film and verify one kind."""
    badge, how = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b")), kinds()[name]
    scene = Scene(badge, Build.typical(SEED), how.pop("camera", None) or camera_named("phone"))
    course = motion_named(how.pop("motion", "sway"), distance_mm=DISTANCE_MM, seed=SEED)
    with temporary_film(scene, course, frames=FRAMES, fps=FPS, seed=SEED, **how) as video:
        report = verify(video, Claim(badge, badge.id))
        megabytes = video.stat().st_size / 1e6
    motion = report.invariant
    return {
        "film": name,
        "verdict": report.verdict,
        "invariant": motion.verdict,
        "identity": report.identity.verdict,
        "|rho|": motion.correlation,
        "gain": motion.gain_ratio,
        "residual": motion.phase_residual_rad,
        "MB": megabytes,
        "against": why_not(report),
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    return wish.each(judged, {name: name for name in kinds()})


COLUMNS = {"film": "<19", "verdict": "<12", "invariant": "<12", "identity": "<11", "|rho|": ">8.3f", "gain": ">8.3f"}
COLUMNS |= {"residual": ">8.3f", "MB": ">6.2f", "against": "<1"}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
