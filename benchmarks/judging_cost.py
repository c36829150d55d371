"""Error against run time of a judgement: run `.venv/bin/python benchmarks/judging_cost.py [--films N] [--keep DIR]`.

True films of natural motion (`natural_films.py`, whose kept tracks are used) are judged with fewer and fewer blocks of
frames: with the third harmonic, which detects photographs, and with the rivals' shares; and by the odds of the phase
alone (the fundamental), as each few seconds of a film are.  Printed is the
processor time of a film and a frame, the verdicts that differ from those by all frames, and how far the score is off.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

import numpy as np
from natural_films import DISTANCES_M, FPS, MOTIONS, Task, prepared, tracked

from moireid.verifier import Claim
from moireid.verifier.decision.judge import Invariant, judge_signals
from moireid.verifier.decision.sheet_gain import SheetGain
from moireid.verifier.explanations import honest
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.signals import measure
from moireid_lab.bench.natural import cut_track

PART_S = 10
#: Most blocks of a film; the first is more than all frames of one.
BLOCKS = (2400, 600, 300, 150, 75, 40)
Part = tuple[tuple[GratingSignal, ...], SheetGain]


def parts_of(task: Task) -> list[Part]:
    """The film's parts of 10 s, and the film itself."""
    track = tracked(task)
    sheet = Claim(track.badge, track.badge.id).sheet
    length = PART_S * FPS
    pieces = [cut_track(track, k, k + length) for k in range(0, track.frames_read - length + 1, length)]
    return [(measure(piece).gratings, sheet) for piece in [*pieces, track] if piece.tracked >= 60]


def judged(parts: list[Part], *, blocks: int, whole: bool) -> tuple[list[Invariant], float]:
    """The judgements and their processor time, s."""
    usual, honest.MOST_BLOCKS = honest.MOST_BLOCKS, blocks
    clock = time.process_time()
    try:
        found = [judge_signals(signals, sheet, whole=whole) for signals, sheet in parts]
    finally:
        honest.MOST_BLOCKS = usual
    return found, time.process_time() - clock


def main() -> None:
    """Track the films, judge their parts in all ways, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--films", type=int, default=2, metavar="N", help="of each motion and distance; default: 2")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep tracks there, and use those that are there")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = prepared(arguments.keep or Path(scratch))
        films = [(m, d, k) for k in range(arguments.films) for m in MOTIONS for d in DISTANCES_M]
        parts = [part for m, d, k in films for part in parts_of(Task(m, d, k, str(folder), seed=arguments.seed))]
    frames = sum(len(signals[0].times_s) for signals, _ in parts)
    print(f"{len(parts)} films, {frames / len(parts):.0f} frames each on average")
    print(
        f"{'harmonics':<10}{'blocks':>7}{'ms a film':>11}{'ms a frame':>11}{'accept':>8}{'differ':>8}{'score off':>11}"
    )
    wanted, _ = judged(parts, blocks=BLOCKS[0], whole=True)
    for whole in (True, False):
        for blocks in BLOCKS:
            found, seconds = judged(parts, blocks=blocks, whole=whole)
            differ = sum(one.verdict != other.verdict for one, other in zip(found, wanted, strict=True))
            off = [abs((a.score or 0) / (b.score or 1) - 1) for a, b in zip(found, wanted, strict=True)]
            accepted = sum(one.verdict == "accept" for one in found)
            print(
                f"{'1 and 3, and shares' if whole else '1':<22}{blocks:>7}{1e3 * seconds / len(parts):>11.0f}"
                f"{1e3 * seconds / frames:>11.3f}{accepted:>8}{differ:>8}{np.median(off):>11.3f}"
            )


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
