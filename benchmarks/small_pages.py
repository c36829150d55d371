"""True films of badges that are small in the picture: run `.venv/bin/python benchmarks/small_pages.py [--films N]`.

A page of 60 x 66 mm, whose markers are then 10 to 16 px wide, and the default board at 2 m, with markers of 19 px, are
filmed in ordinary and in poor quality, swaying and moved against the camera in turns.  Poses are the weak part there.
Printed is what becomes of the films, and by how much the predicted phase is wrong over its error bar, in the median
film and in the worst.  None may be rejected: each film is true.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.simulate import Build, Camera, Scene, film, motion_named
from moireid.simulate.filming import truth_path
from moireid.verifier import Claim, verify

PAGES = {
    "60 x 66": Request("Bench", lens="75lpi", size_mm=(60, 66), range_m=(0.5, 1.0)),
    "146 x 160": Request("Bench"),
}
PLACES, QUALITIES, MOTIONS = (
    (("60 x 66", 1.0), ("60 x 66", 1.2), ("60 x 66", 1.5), ("146 x 160", 2.0)),
    (23, 28),
    ("sway", "both"),
)
FRAMES, FPS = 240, 30


def judged(badge: Badge, metres: float, crf: int, seed: int) -> tuple[str, float]:
    """Verdict of one film, and the error of its predicted phase over the error bar; nan where nothing was measured."""
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        course = motion_named(MOTIONS[seed % 2], distance_mm=1000 * metres, seed=seed)
        scene = Scene(badge, Build.typical(seed), Camera())
        film(scene, course, video, frames=FRAMES, fps=FPS, seed=seed, crf=crf)
        report = verify(video, Claim(badge, badge.id))
        rows = list(csv.DictReader(truth_path(video).open(encoding="utf-8")))
    if report.measurement is None:
        return report.verdict, np.nan
    true = np.unwrap([float(row["phase_rad"]) for row in rows])[report.track.frame_numbers]
    off = report.measurement.gratings[0].predicted_rad - true
    # A focal length that is off scales the phase, and has an error bar of its own.
    scatter = float(np.std(off - np.polyval(np.polyfit(true, off, 1), true)))
    return report.verdict, scatter / report.invariant.gratings[0]["expected_error_rad"]


def main() -> None:
    """One line a page, distance and quality."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--films", type=int, default=4, metavar="N", help="films of each kind; default: 4")
    films = parser.parse_args().films
    badges = {name: design_badge(wish, bytes.fromhex("0f5ac3962d784be1")) for name, wish in PAGES.items()}
    print(f"{'page, mm':<11}{'m':>5}{'crf':>5}{'accepted':>10}{'open':>6}{'rejected':>10}{'median':>9}{'worst':>7}")
    for (name, metres), crf in product(PLACES, QUALITIES):
        found = [judged(badges[name], metres, crf, seed) for seed in range(1, films + 1)]
        verdicts, ratios = Counter(verdict for verdict, _ in found), [ratio for _, ratio in found]
        print(
            f"{name:<11}{metres:>5g}{crf:>5}{verdicts['accept']:>10}{verdicts['inconclusive']:>6}{verdicts['reject']:>10}"
            f"{np.nanmedian(ratios):>9.2f}{np.nanmax(ratios):>7.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
