"""Short lies put into true films: run `.venv/bin/python benchmarks/short_lies.py [MANIFEST.csv]`.

Each genuine film of a collection (columns as `moireid evaluate` takes them; the default is the films of the tests) is
followed and measured as `verify` does.  Then its measured phase is forged for a while: the fringes stay still, go half
as far, or go the wrong way.  The lie begins at a random time, and the fringes return to their true course afterwards,
which makes the lie hardest to find.  The motion test's result is printed by the lie's length.
"""

from __future__ import annotations

import csv
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from moireid.badge import load_badge
from moireid.verifier import Claim, Film, Verifier
from moireid.verifier.decision.judge import judge_signals
from moireid.verifier.fringes.signals import GratingSignal

FILMS = Path(__file__).parents[1] / "tests/data/films/collection.csv"
SECONDS = (0.3, 0.5, 1.0, 2.0)
#: How far the fringes go meanwhile, over how far they should.
LIES = {"stand still": 0.0, "half as far": 0.5, "the wrong way": -1.0}
TRIALS = 4


def signals_of(film: Path, badge_path: Path) -> tuple[GratingSignal, ...]:
    """The signals of a film's only chapter; empty where it has none, or several."""
    badge = load_badge(badge_path)
    verifier = Verifier(Claim(badge, badge.id), running=False)
    for frame in Film(film).frames_ahead():
        verifier.push(frame)
    chapters = verifier.finish()
    return chapters[0].signals if len(chapters) == 1 else ()


def forged(signal: GratingSignal, within: np.ndarray, gain: float) -> GratingSignal:
    """The signal with another gain in some frames; its own errors stay."""
    first = int(np.argmax(within))
    course = signal.predicted_rad - signal.predicted_rad[first]
    return replace(signal, measured_rad=signal.measured_rad + np.where(within, (gain - 1) * course, 0.0))


def main() -> None:
    manifest = Path(sys.argv[1]) if len(sys.argv) > 1 else FILMS
    with manifest.open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["label"] == "genuine"]
    rng = np.random.default_rng(7)
    told: dict[tuple[str, float], Counter[str]] = {(lie, s): Counter() for lie in LIES for s in SECONDS}
    true = Counter[str]()
    for row in rows:
        signals = signals_of(manifest.parent / row["video"], manifest.parent / row["claim"])
        verdict = judge_signals(signals).verdict if signals else "inconclusive"
        true[verdict] += 1
        if verdict != "accept":
            continue
        times = signals[0].times_s
        for (lie, seconds), counted in told.items():
            # Only short lies: less than half of the film.
            for _ in range(TRIALS if times[-1] - times[0] > 2 * seconds else 0):
                start = rng.uniform(times[0], times[-1] - seconds)
                within = (times >= start) & (times < start + seconds)
                counted[judge_signals([forged(s, within, LIES[lie]) for s in signals]).verdict] += 1
    print(f"true films: {dict(true)}; {TRIALS} lies of each kind and length in each that is accepted")
    print(f"{'fringes':<16}{'for, s':>8}{'accept':>8}{'open':>8}{'reject':>8}")
    for (lie, seconds), counted in told.items():
        print(f"{lie:<16}{seconds:>8}" + "".join(f"{counted[v]:>8}" for v in ("accept", "inconclusive", "reject")))


if __name__ == "__main__":
    main()
