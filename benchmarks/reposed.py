"""How many true photographs of a badge must a forger re-pose.

Run `.venv/bin/python benchmarks/reposed.py [--films N]`.

A forger puts photographs of a true badge over a trajectory that he did not choose (`bench/forgers/reposed.py`): the
nearest, or those around cross-faded; taken whole, or field by field.  For each kind of badge, way, trajectory and
distance the fewest photographs are searched with which one of N films is accepted: doubled until one is, then narrowed
down.  A count that is never accepted is printed as more than the last one tried.
"""

from __future__ import annotations

import argparse
import tempfile
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from typing import NamedTuple

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.simulate import Build, Camera, Scene, film, motion_named
from moireid.verifier import Claim, verify
from moireid_lab.bench.forgers.reposed import Reposer

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
CAMERA = Camera(1280, 720, 1150.0)
FRAMES, FPS, CRF = 240, 30, 23
LEAST, MOST = 2, 512
#: The count is known to this ratio.
NARROW = 1.2


class Case(NamedTuple):
    """What is forged, and how; distance in m."""

    axes: str
    blend: bool
    by_field: bool
    course: str
    metres: float


def badge_of(axes: str) -> Badge:
    """The badge that was photographed."""
    if axes == "array":
        return design_badge(Request("Bench", front="array", range_m=(0.8, 2.0)), PAYLOAD)
    return design_badge(Request("Bench", axes=axes, range_m=(0.8, 2.0)), PAYLOAD)


def accepted(case: Case, count: int, films: int) -> bool:
    """Whether one of the films passes for the badge."""
    badge = badge_of(case.axes)
    for seed in range(1, films + 1):
        with tempfile.TemporaryDirectory() as folder:
            video = Path(folder) / "film.mp4"
            film(
                Scene(badge, Build.typical(seed), CAMERA),
                motion_named(case.course, distance_mm=1000 * case.metres, seed=seed),
                video,
                frames=FRAMES,
                fps=FPS,
                show=None if count == 0 else Reposer(count, case.blend, case.by_field).shown,
                seed=seed,
                crf=CRF,
            )
            if verify(video, Claim(badge, badge.id)).verdict == "accept":
                return True
    return False


def fewest(job: tuple[Case, int]) -> tuple[Case, int | None, bool]:
    """The fewest photographs with which a film is accepted, None if none is; and whether a true one is."""
    case, films = job
    true = accepted(case, 0, films)
    few, enough = LEAST - 1, LEAST
    while not accepted(case, enough, films):
        few, enough = enough, 2 * enough
        if enough > MOST:
            return case, None, true
    while enough > NARROW * few and enough - few > 1:
        middle = round((few * enough) ** 0.5) if few * enough > 0 else (few + enough) // 2
        middle = min(max(middle, few + 1), enough - 1)
        few, enough = (few, middle) if accepted(case, middle, films) else (middle, enough)
    return case, enough, true


def main() -> None:
    """One line a case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--films", type=int, default=2, metavar="N", help="films for each count; default: 2")
    parser.add_argument("--axes", nargs="+", default=["x", "xy", "hex", "array"], help="kinds of badge; default: all")
    parser.add_argument("--courses", nargs="+", default=["sway", "circle", "handheld"], help="default: three")
    parser.add_argument("--metres", nargs="+", type=float, default=[1.0], help="distances; default: 1")
    parser.add_argument("--jobs", type=int, default=2, help="processes; default: 2")
    asked = parser.parse_args()
    ways = product((False, True), (False, True))
    cases = [
        Case(axes, blend, by_field, course, metres)
        for axes, (blend, by_field), course, metres in product(asked.axes, list(ways), asked.courses, asked.metres)
        if not (by_field and axes in ("x", "array"))
    ]
    print(f"{'badge':<8}{'way':<14}{'taken':<16}{'course':<12}{'m':>5}{'photographs':>14}  true film")
    with ProcessPoolExecutor(asked.jobs) as pool:
        for case, count, true in pool.map(fewest, [(case, asked.films) for case in cases]):
            way = "cross-faded" if case.blend else "nearest"
            taken = "field by field" if case.by_field else "whole"
            least = f"more than {MOST}" if count is None else str(count)
            print(
                f"{case.axes:<8}{way:<14}{taken:<16}{case.course:<12}{case.metres:>5g}{least:>14}  "
                f"{'accepted' if true else 'not accepted'}",
                flush=True,
            )


if __name__ == "__main__":
    main()
