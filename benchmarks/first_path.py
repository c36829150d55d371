"""The figures of the films of the tests, by an outside simulator: run `.venv/bin/python benchmarks/first_path.py`.

They are measured on the films in tests/data/films, with the time of decoding alone in the same run.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

from moireid.badge import load_badge
from moireid.verifier import Claim, verify
from moireid.verifier.video import Film
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script
from moireid_lab.bench.verdicts import why_not

FILMS = Path(__file__).resolve().parent.parent / "tests" / "data" / "films"


def decode_s(video: Path) -> float:
    """Seconds that decoding a film to grey frames takes, and nothing else."""
    begun = time.perf_counter()
    for _ in Film(video).frames():
        pass
    return time.perf_counter() - begun


def rows(wish: Wish) -> Iterator[Row]:
    """What each film gives."""
    for name in wish.chosen(video.stem for video in sorted(FILMS.glob("*.mp4"))):
        video = FILMS / f"{name}.mp4"
        badge = load_badge(FILMS / ("badge_mask.json" if name.startswith("rendered") else "badge.json"))
        report = verify(video, Claim(badge))
        found, seconds = report.invariant, report.timing["total_s"]
        yield {
            "film": name,
            "verdict": report.verdict,
            "|rho|": found.correlation,
            "windows": found.window_correlation_mean,
            "gain": found.gain_ratio,
            "residual": found.phase_residual_rad,
            "seconds": seconds,
            "x decode": seconds / decode_s(video),
            "why": why_not(report),
        }


COLUMNS = {"film": "<25", "verdict": "<12", "|rho|": ">7.4f", "windows": ">8.4f", "gain": ">8.4f", "residual": ">8.4f"}
BENCH = Bench(rows, COLUMNS | {"seconds": ">8.2f", "x decode": ">8.1f", "why": "<1"})

if __name__ == "__main__":
    run_script(__file__)
