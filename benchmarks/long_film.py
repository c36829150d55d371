"""An hour of film: memory by the minute, and processor time: run `.venv/bin/python benchmarks/long_film.py`.

A badge swaying at 1 m for 12 s, 1080p at 30 frames a second, its packets copied one loop after another (`--minutes`);
where a loop ends the badge jumps.  One process of its own verifies the film and tells its memory as it goes; another
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

import cv2
from one_verify import peak_mb
from verify_cost import BADGE, Kind, filmed
from verify_speed import decode_cpu_s, looped

from moireid.verifier import Claim, verify

ONCE = Kind(length_s=12.0)
#: Memory is told after so many frames: two minutes.
TOLD_FRAMES = 120 * ONCE.fps


def resident_mb() -> float:
    """This process's resident memory now, MB."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmRSS:")[2].split()[0]) / 1e3


def verified(film: Path) -> dict[str, Any]:
    """Costs of a verify, and its memory by the frames read."""
    course: list[tuple[int, float]] = []

    def progress(read: int, expected: int | None) -> None:
        if read % TOLD_FRAMES == 0:
            course.append((read, resident_mb()))

    cpu, wall = time.process_time(), time.perf_counter()
    report = verify(film, Claim(BADGE, BADGE.id), progress=progress)
    return {
        "cpu_s": time.process_time() - cpu,
        "wall_s": time.perf_counter() - wall,
        "course": course,
        "peak_mb": peak_mb(),
        "frames": report.frames["read"],
        "verdict": report.verdict,
        "gain": report.invariant.gain_ratio,
    }


def main() -> None:
    """Print memory by the minute, then what the film cost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0, help="of film")
    parser.add_argument("--child", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        what, film = given.child
        print(json.dumps(verified(Path(film)) if what == "verify" else decode_cpu_s(Path(film))))
        return
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, OpenCV {cv2.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        loops = round(60 * given.minutes / ONCE.length_s)
        film = looped(filmed(ONCE, Path(folder)), loops, Path(folder) / "long.mp4")
        found, decode_s = (_asked(what, film) for what in ("verify", "decode"))
    print(f"{'minute':>8}{'MB':>8}")
    for read, resident in found["course"]:
        print(f"{read / ONCE.fps / 60:>8.0f}{resident:>8.0f}")
    print(
        f"{found['frames']} frames, {found['verdict']}, gain {found['gain']:.4f}; peak {found['peak_mb']:.0f} MB; "
        f"verify {found['cpu_s']:.0f} CPU s in {found['wall_s']:.0f} s, decoding alone {decode_s:.0f} CPU s: "
        f"{found['cpu_s'] / decode_s:.2f} times"
    )


def _asked(what: str, film: Path) -> Any:
    """What a process of its own finds."""
    command = [sys.executable, __file__, "--child", what, str(film)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


if __name__ == "__main__":
    main()
