"""A badge under a thinner sheet than it was designed for: run `.venv/bin/python benchmarks/thin_sheets.py [--films N]`.

A badge designed for a sheet of 0.67 mm is built under one of 0.457 mm, as shops sell it at the same pitch.  Each badge
is enrolled from two films; then it is filmed again: as it is, with a gain 7 % lower and higher, and with half the gain.
A gain 7 % off is the film of a sheet 7 % thinner or thicker, so the lie is exact in all else.  Printed is the gain
with its error bar, and what becomes of each film: before enrolment, and after it.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
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


def main() -> None:
    """One line a film, and a sum at the end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--films", type=int, default=2, metavar="N", help="badges for each motion; default: 2")
    films, sums = parser.parse_args().films, Counter[tuple[str, str]]()
    badge = design_badge(Request("Bench", lens="75lpi"), bytes.fromhex("0f5ac3962d784be1"))
    thin = SOLD_MM / badge.lens.thickness_mm
    for motion, seed in product(MOTIONS, range(1, films + 1)):
        with tempfile.TemporaryDirectory() as name:
            folder, build = Path(name), replace(Build.typical(seed), thickness_ratio=thin)
            built = enrolled(badge, build, motion, seed, folder)
            sums["enrolled", "yes" if built else "no"] += 1
            if built is None:
                continue
            for lie, (gain, forge) in LIES.items():
                video = filmed(badge, replace(build, thickness_ratio=gain * thin), motion, seed, folder, forge)
                before = verify(video, Claim(badge, badge.id)).verdict
                after = verify(video, Claim(badge, badge.id, as_built=built))
                own = after.invariant
                sums[lie, after.verdict] += 1
                print(
                    f"{motion:>9} {seed} {lie:<11} enrolled {built.gain_ratio:.3f} ± {built.gain_sd:.3f}  film "
                    f"{own.gain_ratio:.3f} ± {own.gain_sd:.3f}  before: {before:<13} after: {after.verdict}",
                    flush=True,
                )
    for (what, end), count in sorted(sums.items()):
        print(f"{what:<12}{end:<14}{count}")


if __name__ == "__main__":
    main()
