"""Is the link budget right: run `.venv/bin/python benchmarks/link.py [--formats F ...] [--films N]`.

Badges of each format are filmed by each receiver, in films of eight seconds of a body's swaying and of camera and badge
moved against each other, where the budget promises to read 99, 50 and 1 of 100 films.  Printed is how many it promises,
how many were read, how many were accepted, and the median phase error of a cell, promised and measured.  A few films a
row are too few to compare a promise with a rate, so the last lines add all formats up, for each receiver and promise.
Outside tests may film the same badges with another renderer.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import zlib
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.designer.formats import FORMATS, in_format
from moireid.designer.reach import CALL, CHAT, PHONE, LinkBudget, Receiver, read_of
from moireid.idcodes.spacing import true_phases_rad
from moireid.simulate import Build, Camera, Scene, film, motion_named
from moireid.verifier import Claim, verify
from moireid.verifier.identity.decode import read_identity

FRAMES, FPS, MOTIONS = 240, 30, ("sway", "both")
#: Shares of films that the budget promises to read, where they are filmed.
PROMISED = (0.99, 0.5, 0.01)


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


def row(job: Job, promised: LinkBudget, films: list[dict[str, Any]]) -> str:
    """A format's films by one receiver at one distance, as a line."""
    verdicts = [one["verdict"] for one in films]
    errors = [one["error"] for one in films if math.isfinite(one["error"])]
    return (
        f"{job.format:<8}{job.way:<7}{job.metres:>6.2f}{100 * promised.decode_probability:>10.1f}"
        f"{sum(one['read'] for one in films):>4} of {len(films)}{verdicts.count('accept'):>10}"
        f"{verdicts.count('reject'):>10}{np.median(errors) if errors else math.nan:>12.3f}"
        f"{promised.phase_error_rad:>10.3f}"
    )


def total(way: str, promised: float, read: list[bool]) -> str:
    """All formats' films by one receiver where as much is promised: the rate, and its interval of 95 % (Wilson)."""
    share, n, z = float(np.mean(read)), len(read), 1.96
    middle = (share + z * z / (2 * n)) / (1 + z * z / n)
    half = z * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return (
        f"{way:<7} promised {100 * promised:5.1f}: read {sum(read)} of {n}, {100 * share:.0f} % "
        f"({100 * (middle - half):.0f} to {100 * (middle + half):.0f})"
    )


def main() -> None:
    """One line a format, receiver and distance; then the totals."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--formats", nargs="+", choices=FORMATS, default=list(FORMATS), help="default: all")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS), help="receivers; default: all")
    parser.add_argument("--promised", nargs="+", type=float, default=PROMISED, help="shares; default: 0.99 0.5 0.01")
    parser.add_argument("--metres", nargs="+", type=float, help="distances, in place of promised shares")
    parser.add_argument("--films", type=int, default=4, metavar="N", help="films of each; default: 4")
    parser.add_argument("--jobs", type=int, default=2, help="processes; default: 2")
    asked = parser.parse_args()
    head = (
        f"{'format':<8}{'way':<7}{'m':>6}{'promised':>10}{'read':>9}{'accepted':>10}{'rejected':>10}{'error rad':>12}"
    )
    print(head + f"{'promised':>10}")
    read: dict[tuple[str, float], list[bool]] = {}
    with ProcessPoolExecutor(asked.jobs) as pool:
        for name, way in product(asked.formats, asked.ways):
            able, receiver = read_of(badge_of(Job(name, way, 1.0, 0))), WAYS[way].receiver
            assert able is not None
            for metres in asked.metres or [round(able.reach_m(receiver, share), 2) for share in asked.promised]:
                # Each row has films of its own.
                first = zlib.crc32(f"{name} {way} {metres}".encode()) % 100000
                jobs = [Job(name, way, metres, first + k) for k in range(asked.films)]
                films, promised = list(pool.map(filmed, jobs)), able.at(metres, receiver)
                nearest = min(PROMISED, key=lambda share: abs(share - promised.decode_probability))
                read.setdefault((way, nearest), []).extend(one["read"] for one in films)
                print(row(jobs[0], promised, films), flush=True)
    for (way, share), films_read in sorted(read.items()):
        print(total(way, share, films_read), flush=True)


if __name__ == "__main__":
    main()
