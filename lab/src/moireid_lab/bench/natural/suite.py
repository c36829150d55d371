"""Films of a true badge with measured motions: verdicts on parts of 4 to 40 s of each.

Convention: a film is tracked once, by `verify` with the badge as claim and its identity, not known as built.  Its track
is cut, and each part is judged as a chapter of its own.  The verdict of a row is the motion's.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from moireid.designer import Request, design_badge
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Claim, verify
from moireid.verifier.session.chapters import judge_chapter
from moireid.verifier.tracking.track import Track
from moireid_lab.bench.natural.cases import LENGTHS_S, QUICK_LENGTHS_S, Case, cases, usual
from moireid_lab.bench.natural.film_parts import cut_track, part_starts
from moireid_lab.bench.rows import Where, chosen_names, rows_of_cases

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FPS = 30
FRAMES = max(LENGTHS_S) * FPS
CAMERA = Camera(1280, 720, 966.7)
HERE = Where()


def run_case(job: tuple[str, int, int]) -> dict[str, Any]:
    """One film of one case; the figures of all its parts."""
    name, seed, frames = job
    case = next(case for case in cases() if case.name == name)
    badge = design_badge(Request("Bench"), PAYLOAD)
    claim = Claim(badge, badge.id)
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        motion = motion_named(case.motion, distance_mm=1000 * case.distance_m, seed=seed)
        film(Scene(badge, Build.typical(seed), CAMERA), motion, video, frames=frames, fps=float(FPS), seed=seed)
        track = verify(video, claim).track
    starts = part_starts(LENGTHS_S, frames / FPS)
    parts = [judge_part(track, claim, start, seconds) for seconds in starts for start in starts[seconds]]
    return {"case": name, "seed": seed, "parts": parts}


def judge_part(track: Track, claim: Claim, start_s: int, seconds: int) -> dict[str, Any]:
    """The verdict on a part of a film, and the processor time of judging it."""
    part = cut_track(track, start_s * FPS, (start_s + seconds) * FPS)
    with threadpool_limits(limits=1, user_api="blas"):
        clock = time.process_time()
        chapter = judge_chapter(part, claim)
        judge_s = time.process_time() - clock
    motion, reasons = chapter.invariant, (*chapter.invariant.reasons, *chapter.identity.reasons)
    return {
        "seconds": seconds,
        "start_s": start_s,
        "frames": part.tracked,
        "verdict": motion.verdict,
        "score": motion.score,
        "gain": motion.gain_ratio,
        "residual_rad": motion.phase_residual_rad,
        "excitation_rad": motion.excitation_rad,
        "identity": chapter.identity.verdict,
        "why": [reason.code for reason in reasons if reason.level in ("fail", "undecided")],
        "judge_s": judge_s,
    }


def rows_of_film(found: dict[str, Any], lengths_s: tuple[int, ...]) -> list[dict[str, Any]]:
    """One row for each part of these lengths, with its film's motion, distance and seed."""
    case: Case = next(case for case in cases() if case.name == found["case"])
    film_row = {"motion": case.motion, "distance_m": case.distance_m, "seed": found["seed"]}
    return [film_row | part for part in found["parts"] if part["seconds"] in lengths_s]


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
    numbers = range(seed, seed + (clips or (1 if quick else 5)))
    films = rows_of_cases(run_case, chosen, numbers, FRAMES, kept=kept, where=where, progress=progress)
    lengths = QUICK_LENGTHS_S if quick else LENGTHS_S
    return {"suite": "natural", "seed": seed, "rows": [row for found in films for row in rows_of_film(found, lengths)]}
