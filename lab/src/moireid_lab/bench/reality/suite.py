"""Films of the world: accepted, open or rejected, with gain, residual and run time.

Convention: a film is judged by `verify` with the badge as claim and its identity, not known as built.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from moireid.designer import Request, design_badge
from moireid.simulate.effects.table import effect_named
from moireid.simulate.filming import film
from moireid.simulate.motion import Motion, motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Claim, verify
from moireid_lab.bench.reality.cases import NOTHING, TRUE, Case, cases, usual
from moireid_lab.bench.rows import Where, chosen_names, rows_of_cases
from moireid_lab.bench.verdicts import told

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES, FPS = 240, 30.0
MOTIONS = ("sway", "handheld", "linear")
CAMERA = Camera(1280, 720, 966.7)
HERE = Where()


def motion_of(case: Case, seed: int) -> Motion:
    """By the seed: a body that sways before a camera on a stand, a hand-held camera, or one moved to and fro."""
    return motion_named(MOTIONS[seed % len(MOTIONS)], distance_mm=1000 * case.distance_m, seed=seed)


def run_case(job: tuple[str, int, int]) -> dict[str, Any]:
    """One film of one case, judged."""
    name, seed, frames = job
    case = next(case for case in cases() if case.name == name)
    badge = design_badge(Request("Bench"), PAYLOAD)
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        film(
            Scene(badge, Build.typical(seed), CAMERA),
            motion_of(case, seed),
            video,
            frames=frames,
            fps=FPS,
            forge=None if case.badge == TRUE else case.badge,
            effects=[] if case.effect == NOTHING else [effect_named(f"{case.effect}:{case.strength}")],
            seed=seed,
        )
        clock = time.perf_counter()
        report = verify(video, Claim(badge, badge.id))
        seconds = time.perf_counter() - clock
    row = {"effect": case.effect, "strength": case.strength, "distance_m": case.distance_m, "badge": case.badge}
    motion = report.invariant
    lens = report.measurement.camera if report.measurement else None
    row |= {"focal_px": lens.focal_px, "axis_px": lens.axis_px, "aspect": lens.aspect} if lens else {}
    more = {"gain_sd": motion.gain_sd, "residual_rad": motion.phase_residual_rad, "tracked": report.frames["tracked"]}
    return row | {"seed": seed, "frames": frames, "seconds": seconds} | told(report) | more


def run(
    *,
    quick: bool,
    seed: int,
    clips: int | None,
    only: str | None = None,
    kept: Path | None,
    where: Where = HERE,
    progress: Callable[[int, int | None], None],
) -> dict[str, Any]:
    """The usual cases as one JSON object, or of all cases those whose name holds the regular expression `only`.

    Raises: SpecError where no case is left.
    """
    chosen = chosen_names([case.name for case in cases() if only is not None or usual(case, quick=quick)], only)
    count = clips or (1 if quick else 10)
    numbers = range(seed, seed + count)
    rows = rows_of_cases(run_case, chosen, numbers, FRAMES, kept=kept, where=where, progress=progress)
    return {"suite": "reality", "seed": seed, "rows": rows}
