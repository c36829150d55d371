"""An hour of film: memory by the minute, and processor time: run `.venv/bin/python benchmarks/long_film.py`.

A badge swaying at 1 m for 12 s, 1080p at 30 frames a second, its packets copied one loop after another (`--minutes`);
where a loop ends the badge jumps.  One process of its own verifies the film and reports its memory as it goes; another
decodes it and does nothing else.  CPU seconds are those of all threads, imports apart.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from one_verify import peak_mb

from moireid.badge import load_badge
from moireid.verifier import Claim, verify
from moireid.verifier.video import Film

FPS, ONCE_S = 30, 12.0
#: Memory is noted after so many frames: two minutes.
NOTE_FRAMES = 120 * FPS


def resident_mb() -> float:
    """This process's resident memory now, MB."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmRSS:")[2].split()[0]) / 1e3


def made(folder: Path, minutes: float) -> tuple[Path, Path]:
    """The film and its badge's file."""
    # The processes that are measured load no simulator.
    from verify_cost import BADGE, Kind, filmed
    from verify_speed import looped

    badge_path = folder / "badge.json"
    badge_path.write_text(BADGE.to_json(), encoding="utf-8")
    once = filmed(Kind(fps=FPS, length_s=ONCE_S), folder)
    return looped(once, round(60 * minutes / ONCE_S), folder / "long.mp4"), badge_path


def verified(film: Path, badge_path: Path) -> dict[str, Any]:
    """Costs of a verify, and its memory by the frames read."""
    badge = load_badge(badge_path)
    course: list[tuple[int, float]] = []

    def progress(read: int, expected: int | None) -> None:
        if read % NOTE_FRAMES == 0:
            course.append((read, resident_mb()))

    cpu, wall = time.process_time(), time.perf_counter()
    report = verify(film, Claim(badge, badge.id), progress=progress)
    return {
        "cpu_s": time.process_time() - cpu,
        "wall_s": time.perf_counter() - wall,
        "course": course,
        "peak_mb": peak_mb(),
        "frames": report.frames["read"],
        "verdict": report.verdict,
        "gain": report.invariant.gain_ratio,
    }


def decoded(film: Path) -> float:
    """CPU seconds of decoding and nothing else."""
    cpu = time.process_time()
    for _ in Film(film).frames():
        pass
    return time.process_time() - cpu


def main() -> None:
    """Print memory by the minute, then what the film cost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0, help="of film")
    parser.add_argument("--child", nargs=3, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        what, film, badge = given.child
        print(json.dumps(verified(Path(film), Path(badge)) if what == "verify" else decoded(Path(film))))
        return
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        film, badge = made(Path(folder), given.minutes)
        found, decode_s = (_asked(what, film, badge) for what in ("verify", "decode"))
    print(f"{'minute':>8}{'MB':>8}")
    for read, resident in found["course"]:
        print(f"{read / FPS / 60:>8.0f}{resident:>8.0f}")
    print(
        f"{found['frames']} frames, {found['verdict']}, gain {found['gain']:.4f}; peak {found['peak_mb']:.0f} MB; "
        f"verify {found['cpu_s']:.0f} CPU s in {found['wall_s']:.0f} s, decoding alone {decode_s:.0f} CPU s: "
        f"{found['cpu_s'] / decode_s:.2f} times"
    )


def _asked(what: str, film: Path, badge: Path) -> Any:
    """What a process of its own finds."""
    command = [sys.executable, __file__, "--child", what, str(film), str(badge)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


if __name__ == "__main__":
    main()
