"""True films of a small badge from far: run `.venv/bin/python benchmarks/small_pages.py [--films N]`.

A page of 60 x 66 mm sways before a phone, at distances at which its markers are 10 to 16 px wide, in films of ordinary
and of poor quality.  Poses are the weak part there.  Printed is what becomes of the films, and by how much the
predicted phase is wrong over its error bar.  None may be rejected: each film is true.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np

from moireid.designer import Request, design_badge
from moireid.simulate import Build, Camera, Scene, film, motion_named
from moireid.simulate.filming import truth_path
from moireid.verifier import Claim, verify

METRES, QUALITIES = (1.0, 1.2, 1.5), (23, 28)
FRAMES, FPS = 240, 30


def main() -> None:
    """One line a distance and quality."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--films", type=int, default=4, metavar="N", help="films of each kind; default: 4")
    films = parser.parse_args().films
    badge = design_badge(
        Request("Bench", lens="75lpi", size_mm=(60, 66), range_m=(0.5, 1.0)), bytes.fromhex("0f5ac3962d784be1")
    )
    print(f"{'m':>5}{'crf':>5}{'accepted':>10}{'open':>6}{'rejected':>10}{'error over its bar':>20}")
    for metres, crf in product(METRES, QUALITIES):
        told, ratios = Counter[str](), []
        for seed in range(1, films + 1):
            with tempfile.TemporaryDirectory() as folder:
                video = Path(folder) / "film.mp4"
                course = motion_named("sway", distance_mm=1000 * metres, seed=seed)
                film(
                    Scene(badge, Build.typical(seed), Camera()),
                    course,
                    video,
                    frames=FRAMES,
                    fps=FPS,
                    seed=seed,
                    crf=crf,
                )
                report = verify(video, Claim(badge, badge.id))
                told[report.verdict] += 1
                if report.measurement is None:
                    continue
                rows = list(csv.DictReader(truth_path(video).open(encoding="utf-8")))
            true = np.unwrap([float(row["phase_rad"]) for row in rows])[report.track.frame_numbers]
            off = report.measurement.gratings[0].predicted_rad - true
            bar = report.invariant.gratings[0]["expected_error_rad"]
            ratios.append(float(np.std(off - np.polyval(np.polyfit(true, off, 1), true))) / bar)
        print(
            f"{metres:>5g}{crf:>5}{told['accept']:>10}{told['inconclusive']:>6}{told['reject']:>10}"
            f"{np.median(ratios) if ratios else np.nan:>20.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
