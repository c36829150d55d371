"""The figures of `docs/accuracy.md` on the films of the tests: run `.venv/bin/python benchmarks/first_path.py`.

Times are of whole processes: the median of five, with the least and the most.  The films' figures are measured on the
films by an outside simulator in tests/data/films, with the time of decoding alone in the same run.
"""

from __future__ import annotations

import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from moireid.badge import load_badge
from moireid.verifier import Claim, verify
from moireid.verifier.video import Film

ROOT = Path(__file__).resolve().parent.parent
BIN = Path(sys.executable).parent
FILMS = ROOT / "tests" / "data" / "films"
RUNS = 5


def whole_process_s(*command: str) -> list[float]:
    """Seconds of each of `RUNS` runs of a command."""
    seconds = []
    for _ in range(RUNS):
        begun = time.perf_counter()
        subprocess.run([str(BIN / command[0]), *command[1:]], check=True, capture_output=True)
        seconds.append(time.perf_counter() - begun)
    return seconds


def decode_s(video: Path) -> float:
    """Seconds that decoding a film to grey frames takes, and nothing else."""
    begun = time.perf_counter()
    for _ in Film(video).frames():
        pass
    return time.perf_counter() - begun


def main() -> None:
    """Print two tables: seconds of commands, and what each film gives."""
    print(f"{platform.machine()}, Python {platform.python_version()}, {RUNS} runs each\n")
    print(f"{'command':<42}{'median s':>10}{'least':>8}{'most':>8}")
    with tempfile.TemporaryDirectory() as folder:
        out = ["--out", f"{folder}/badge", "--overwrite"]
        for command in (
            ("moireid", "--help"),
            ("print-your-badge", "--help"),
            ("print-your-badge", "Ada Lovelace", "--mount", "none", *out),
            ("print-your-badge", "Ada Lovelace", *out),
        ):
            seconds = whole_process_s(*command)
            shown = " ".join(word for word in command if word not in out)
            print(f"{shown:<42}{statistics.median(seconds):>10.2f}{min(seconds):>8.2f}{max(seconds):>8.2f}")
    head = ("film", "verdict", "|rho|", "windows", "gain", "residual", "seconds", "x decode")
    print(f"\n{head[0]:<26}{head[1]:<10}" + "".join(f"{word:>10}" for word in head[2:]))
    for video in sorted(FILMS.glob("*.mp4")):
        badge = load_badge(FILMS / ("badge_mask.json" if video.name.startswith("rendered") else "badge.json"))
        report = verify(video, Claim(badge))
        found, seconds = report.invariant, report.timing["total_s"]
        figures = [
            found.correlation,
            found.window_correlation_mean,
            found.gain_ratio,
            found.phase_residual_rad,
            seconds,
        ]
        row = "".join(f"{figure:>10.4f}" for figure in figures)
        print(f"{video.stem:<26}{report.verdict:<10}{row}{seconds / decode_s(video):>10.1f}")


if __name__ == "__main__":
    main()
