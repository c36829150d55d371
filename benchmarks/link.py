"""Does the link budget tell the truth: run `.venv/bin/python benchmarks/link.py [--formats F ...] [--films N]`.

Badges of each format are filmed by each receiver over distances, in films of eight seconds of a body's swaying and of
camera and badge moved against each other.  Printed is how many of 100 films the budget promises to read, how many were
read, how many were accepted, and the median phase error of a cell, promised and measured.  Outside tests may film the
same badges with another renderer.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.designer.formats import FORMATS, in_format
from moireid.designer.link import CALL, CHAT, PHONE, Receiver
from moireid.designer.reach import read_of
from moireid.idcodes.spacing import true_phases_rad
from moireid.simulate import Build, Camera, Scene, film, motion_named
from moireid.verifier import Claim, verify
from moireid.verifier.identity.decode import read_identity

FRAMES, FPS, MOTIONS = 240, 30, ("sway", "both")


class Way(NamedTuple):
    """How a receiver films: its camera, and the recipe or the quality of its file."""

    receiver: Receiver
    camera: Camera
    recipe: str | None
    crf: int | None


WAYS = {
    "phone": Way(PHONE, Camera(), None, 28),
    "call": Way(CALL, Camera(1280, 720, CALL.focal_px), "meeting", None),
    "chat": Way(CHAT, Camera(), "chat", None),
}


class Job(NamedTuple):
    """One film."""

    format: str
    way: str
    metres: float
    seed: int


def badge_of(job: Job) -> Badge:
    """The badge of one film; each has an identity of its own."""
    payload = np.random.default_rng([job.seed, 20]).bytes(8)
    return design_badge(in_format(Request("Bench"), job.format), payload)


def filmed(job: Job) -> dict[str, Any]:
    """Film and judge one badge."""
    badge, way = badge_of(job), WAYS[job.way]
    course = motion_named(MOTIONS[job.seed % 2], distance_mm=1000 * job.metres, seed=job.seed)
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        scene = Scene(badge, Build.typical(job.seed), way.camera)
        film(scene, course, video, frames=FRAMES, fps=FPS, seed=job.seed, crf=way.crf, recipe=way.recipe)
        report = verify(video, Claim(badge, badge.id))
    row = {"read": report.identity.decoded_id == badge.id, "verdict": report.verdict, "error": math.nan}
    if report.measurement is not None and row["read"]:
        cells = read_identity(report.track, report.measurement).cells
        true = true_phases_rad(bytes.fromhex(badge.id or ""), badge.gratings)
        off = [math.remainder(cells[g][c].phase_rad - phase, 2 * math.pi) for (g, c), phase in true.items()]
        row["error"] = float(np.sqrt(np.mean(np.square(off))))
    return row


def main() -> None:
    """One line a format, receiver and distance."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--formats", nargs="+", choices=FORMATS, default=list(FORMATS), help="default: all")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS), help="receivers; default: all")
    parser.add_argument("--metres", nargs="+", type=float, help="distances; default: 0.9, 1 and 1.1 of the reach")
    parser.add_argument("--films", type=int, default=6, metavar="N", help="films of each; default: 6")
    parser.add_argument("--jobs", type=int, default=2, help="processes; default: 2")
    asked = parser.parse_args()
    head = (
        f"{'format':<8}{'way':<7}{'m':>6}{'promised':>10}{'read':>9}{'accepted':>10}{'rejected':>10}{'error rad':>12}"
    )
    print(head + f"{'promised':>10}")
    with ProcessPoolExecutor(asked.jobs) as pool:
        for name, way in product(asked.formats, asked.ways):
            read = read_of(badge_of(Job(name, way, 1.0, 0)))
            assert read is not None
            receiver = WAYS[way].receiver
            reach_m = read.reach_m(receiver)
            for metres in asked.metres or [round(share * reach_m, 2) for share in (0.9, 1.0, 1.1)]:
                link = read.at(metres, receiver)
                rows = list(pool.map(filmed, [Job(name, way, metres, seed) for seed in range(1, asked.films + 1)]))
                verdicts = [row["verdict"] for row in rows]
                errors = [row["error"] for row in rows if math.isfinite(row["error"])]
                print(
                    f"{name:<8}{way:<7}{metres:>6.2f}{100 * link.decode_probability:>10.1f}"
                    f"{sum(row['read'] for row in rows):>4} of {len(rows)}{verdicts.count('accept'):>10}"
                    f"{verdicts.count('reject'):>10}{np.median(errors) if errors else math.nan:>12.3f}"
                    f"{link.phase_error_rad:>10.3f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
