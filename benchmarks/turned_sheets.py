"""Pieces of lens sheet that are turned: run `.venv/bin/python benchmarks/turned_sheets.py`.

Badges of one, two and three directions; each piece of sheet has an offset of its own, and is turned by so many degrees,
to either side in turns; the badge sways at 1 m.  A maker is asked for 0.3 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

from moireid.designer import Request, design_badge
from moireid.simulate import Build, Scene, camera_named, motion_named
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script, temporary_film
from moireid_lab.bench.verdicts import why_not

PAYLOAD, FRAMES, FPS, SEED = bytes.fromhex("0f5ac3962d784be1"), 180, 30, 3
#: Offset, mm, and side to which each piece is turned.
PIECES = ((0.11, 1), (-0.2, -1), (0.05, 1))
TURNED_DEG = (0.2, 0.5, 0.8, 1.2, 1.5)


def judged(job: tuple[float, str]) -> Row:
    """One film, judged."""
    degrees, axes = job
    badge = design_badge(Request("Bench", axes=axes, range_m=(0.8, 2.0)), PAYLOAD)
    pieces = tuple((offset_mm, side * math.radians(degrees)) for offset_mm, side in PIECES)[: len(badge.gratings)]
    build = Build(print_scale=1.002, print_aspect=1.001, lens_scale=0.9995, pieces=pieces)
    sway = motion_named("sway", distance_mm=1000.0, seed=SEED)
    with temporary_film(Scene(badge, build, camera_named("phone")), sway, frames=FRAMES, fps=FPS, seed=SEED) as video:
        report = verify(video, Claim(badge, badge.id))
    gains = [one["gain_ratio"] if one["excitation_rad"] > 0.1 else None for one in report.invariant.gratings]
    return {
        "turned by": degrees,
        "axes": axes,
        "verdict": report.verdict,
        "identity": report.identity.verdict,
        "gains": ["-" if gain is None else f"{gain:.3f}" for gain in gains],
        "why": why_not(report),
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    kinds = product(TURNED_DEG, ("x", "xy", "hex"))
    return wish.each(judged, {f"{degrees:g} {axes}": (degrees, axes) for degrees, axes in kinds})


BENCH = Bench(
    rows, {"turned by": ">9g", "axes": "<4", "verdict": "<12", "identity": "<11", "gains": "<20", "why": "<1"}
)

if __name__ == "__main__":
    run_script(__file__)
