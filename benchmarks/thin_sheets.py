"""A badge under a thinner sheet than it was designed for: run `.venv/bin/python benchmarks/thin_sheets.py [--films N]`.

A badge designed for a sheet of 0.67 mm is built under one of 0.457 mm, as shops sell it at the same pitch.  Each badge
is enrolled from two films; then it is filmed again: as it is, with a gain 7 % lower and higher, and with half the gain.
A gain 7 % off is the film of a sheet 7 % thinner or thicker, so the lie is exact in all else.  Printed is the gain
with its error bar, and what becomes of each film: before enrolment, and after it.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.errors import MediaError
from moireid.simulate import Build, Scene, camera_named, film, motion_named
from moireid.verifier import Claim, verify
from moireid.verifier.session.capture import capture_as_built
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

SOLD_MM, DISTANCE_MM, FRAMES, FPS = 0.457, 1000.0, 240, 30
MOTIONS = ("sway", "handheld", "linear")
#: The thickness of the sheet in each film over that at enrolment, and the forgery.
LIES = {"as it is": (1.0, None), "7 % lower": (0.93, None), "7 % higher": (1.07, None), "half": (1.0, "gain_low")}


def filmed(badge: Badge, build: Build, motion: str, seed: int, folder: Path, forge: str | None = None) -> Path:
    """A film of the badge."""
    video = folder / f"{motion}-{seed}-{build.thickness_ratio:.4f}-{forge}.mp4"
    course = motion_named(motion, distance_mm=DISTANCE_MM, seed=seed)
    film(Scene(badge, build, camera_named("phone")), course, video, frames=FRAMES, fps=FPS, forge=forge, seed=seed)
    return video


def enrolled(badge: Badge, build: Build, motion: str, seed: int, folder: Path) -> AsBuilt | None:
    """As-built figures from two films, or None where they are refused."""
    try:
        return capture_as_built([filmed(badge, build, motion, seed + k, folder) for k in (100, 200)], badge)
    except MediaError as error:
        print(f"    not enrolled: {error}")
        return None


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    badge = design_badge(Request("Bench", lens="75lpi"), bytes.fromhex("0f5ac3962d784be1"))
    thin = SOLD_MM / badge.lens.thickness_mm
    for motion, seed in product(MOTIONS, range(1, 1 + (wish.clips or 2))):
        with tempfile.TemporaryDirectory() as name:
            folder, build = Path(name), replace(Build.typical(seed), thickness_ratio=thin)
            built = enrolled(badge, build, motion, seed, folder)
            for lie, (gain, forge) in LIES.items() if built else ():
                video = filmed(badge, replace(build, thickness_ratio=gain * thin), motion, seed, folder, forge)
                after = verify(video, Claim(badge, badge.id, as_built=built))
                yield {
                    "motion": motion,
                    "seed": seed,
                    "sheet": lie,
                    "enrolled": built.gain_ratio,
                    "bar": built.gain_sd,
                    "film": after.invariant.gain_ratio,
                    "its bar": after.invariant.gain_sd,
                    "before": verify(video, Claim(badge, badge.id)).verdict,
                    "after": after.verdict,
                }


def sums(found: list[Row]) -> Iterator[str]:
    """How many films of each sheet have each verdict after enrolment."""
    for (what, end), count in sorted(Counter((row["sheet"], row["after"]) for row in found).items()):
        yield f"{what:<12}{end:<14}{count}"


COLUMNS = {"motion": ">9", "seed": ">4", "sheet": "<10", "enrolled": ">8.3f", "bar": ">6.3f", "film": ">7.3f"}
BENCH = Bench(rows, COLUMNS | {"its bar": ">7.3f", "before": "<12", "after": "<12"}, sums)

if __name__ == "__main__":
    run_script(__file__)
