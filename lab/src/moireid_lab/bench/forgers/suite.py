"""What an attacker who reads this code gets past it, and what happens to honest films that a hand or an editor spoils.

Convention: a film is accepted, open or rejected by `verify` with the badge as claim and its identity, not known as
built.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.simulate.filming import film
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Claim, verify
from moireid_lab.bench.forgers.cases import Case, Shoot, cases
from moireid_lab.bench.rows import Where, chosen_names, rows_of_cases
from moireid_lab.bench.verdicts import told

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES = 240
CRF = 23
CAMERA = Camera(1280, 720, 1150.0)
HERE = Where()


def badge_of(axes: str) -> Badge:
    """The badge that is filmed."""
    return design_badge(Request("Bench", axes=axes), PAYLOAD)


def film_case(case: Case, shoot: Shoot, video: Path) -> None:
    """Film one case."""
    filming = case.make(shoot)
    film(
        Scene(shoot.badge, Build.typical(shoot.seed), CAMERA),
        filming.motion,
        video,
        frames=round(shoot.length_s * filming.seconds_times * filming.fps),
        fps=filming.fps,
        show=filming.show,
        edit=filming.edit,
        seed=shoot.seed,
        crf=CRF,
    )


def run_case(job: tuple[str, int, int]) -> dict[str, Any]:
    """One film of one case, judged."""
    name, seed, frames = job
    case = next(case for case in cases() if case.name == name)
    badge = badge_of(case.axes)
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        film_case(case, Shoot(badge, (1000.0, 1400.0)[seed % 4 // 2], seed, frames), video)
        clock = time.perf_counter()
        report = verify(video, Claim(badge, badge.id))
        seconds = time.perf_counter() - clock
    return {"case": name, "genuine": case.genuine, "seed": seed, "seconds": seconds} | told(report)


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
    """All cases as one JSON object, or those whose name holds the regular expression `only`.

    Raises: SpecError where no case is left.
    """
    count = clips or (2 if quick else 100)
    chosen = chosen_names([case.name for case in cases()], only)
    numbers = range(seed, seed + count)
    rows = rows_of_cases(run_case, chosen, numbers, FRAMES, kept=kept, where=where, progress=progress)
    return {"suite": "forgers", "seed": seed, "rows": rows}
