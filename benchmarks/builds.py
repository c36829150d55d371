"""Badges as people build them, by an outside tracer: run `.venv/bin/python benchmarks/builds.py [--only REGEX]`.

Each badge is printed by the command `print-your-badge` and traced by `outside`, which shares nothing with
`moireid.simulate`, with one flaw of print or sheet, or with all of them (`outside.flaws`).  It is enrolled from two
films, filmed again at the middle of its range, and filmed with half the gain; a second build of the same files, with
the same flaws of another draw, is the copy.  Narrowed: printed with `--ink-growth`.  Printed is whether it could be
enrolled, what becomes of the film before and after enrolment, with its gain, and of copy and forgery (not with
`--quick`).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from natural_films import prepared
from outside.build import built
from outside.camera import PHONE, drawn
from outside.film import Shoot, film
from outside.flaws import Flaws, flawed
from outside.motion import course
from outside.page import load_page

from moireid.asbuilt import AsBuilt
from moireid.badge import load_badge
from moireid.errors import MediaError
from moireid.verifier import Claim, verify
from moireid.verifier.session.capture import capture_as_built
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script
from moireid_lab.bench.verdicts import why_not

FRAMES, FPS, DISTANCE_MM = 240, 30, 1000.0
KINDS = {
    "none": Flaws(),
    "ink 42 um": Flaws(ink_um=42),
    "ink 85 um": Flaws(ink_um=85),
    "ink 85 um, narrowed": Flaws(ink_um=85),
    "bands 3 %": Flaws(bands=0.03),
    "bled and bands": Flaws(ink_um=42, bands=0.03),
    "focus 1.07": Flaws(focus=1.07),
    "focus 1.47": Flaws(focus=1.47),
    "air 0.05 mm": Flaws(air_mm=0.05),
    "air 0.15 mm": Flaws(air_mm=0.15),
    "wander 0.02 mm": Flaws(wander_mm=0.02),
    "wander 0.05 mm": Flaws(wander_mm=0.05),
    "haze 30 %": Flaws(haze=0.3),
    "haze 60 %": Flaws(haze=0.6),
    "usual": Flaws(ink_um=30, bands=0.01, focus=1.07, air_mm=0.05, wander_mm=0.02, haze=0.3),
}


def filmed(folder: Path, kind: str, build: int, number: int, forge: str | None = None) -> Path:
    """One film of one build; kept in the folder."""
    path = folder / f"{kind.replace(' ', '_').replace('%', 'pc')}_{build}_{number}_{forge or 'true'}.mp4"
    if not path.exists():
        rng = np.random.default_rng([build, number, 5])
        page = flawed(load_page(folder / "badge"), KINDS[kind], build)
        motion = course(("sway", "arc", "measured")[number % 3], DISTANCE_MM, FRAMES / FPS, rng)
        own = built(page, np.random.default_rng([build, 6]))
        film(page, own, drawn(rng, PHONE), motion, path, Shoot(FRAMES, FPS, 23, number, forge))
    return path


def rows(wish: Wish) -> Iterator[Row]:
    """One row a build."""
    with wish.kept_folder() as name:
        for kind in wish.chosen(KINDS):
            narrowed = kind.endswith("narrowed")
            folder = prepared(name / "narrowed", "--ink-growth", "85") if narrowed else prepared(name)
            badge = load_badge(folder / "badge" / "badge.json")
            for build in range(1, 1 + (wish.clips or 1)):
                again = filmed(folder, kind, build, 2)
                before = verify(again, Claim(badge, badge.id))
                figures: AsBuilt | None = None
                refused = ""
                try:
                    figures = capture_as_built([filmed(folder, kind, build, k) for k in (0, 1)], badge)
                except MediaError as error:
                    refused = str(error).split("cannot be used:")[-1][:60]
                row: Row = {"build": kind, "number": build, "before": before.verdict, "why before": why_not(before)}
                if figures is None:
                    yield row | {"refused": refused}
                    continue
                claim = Claim(badge, badge.id, as_built=figures)
                after = verify(again, claim)
                row |= {
                    "enrolled gain": figures.gain_ratio,
                    "gain": after.invariant.gain_ratio,
                    "after": after.verdict,
                    "why": why_not(after),
                }
                if not wish.quick:
                    row["copy"] = verify(filmed(folder, kind, build + 100, 2), claim).verdict
                    row["half gain"] = verify(filmed(folder, kind, build, 2, "gain_0.5"), claim).verdict
                yield row


COLUMNS = {
    "build": "<19",
    "number": ">6",
    "before": "<12",
    "why before": "<16",
    "enrolled gain": ">13.3f",
    "gain": ">6.3f",
}
COLUMNS |= {"after": "<12", "why": "<16", "copy": "<12", "half gain": "<12", "refused": "<1"}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
