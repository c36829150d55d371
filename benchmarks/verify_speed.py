"""Seconds and megabytes of a verify: run `.venv/bin/python benchmarks/verify_speed.py [FILM [BADGE]] [--loops N ...]`.

In one process, a film is decoded alone and verified in turn, several times.  On a shared machine only the ratio of two
neighbouring runs is meaningful, and its median is printed.  CPU seconds are those of all threads.  A child process then
verifies each film once more and prints its peak memory.

Longer films are the same film over and over: its packets are copied one loop after another with their times moved on,
so nothing is coded anew, and where a loop ends the badge jumps.  Without FILM it is the genuine one at 1 m of the
tests: 1080p, 60 frames a second, 240 frames, in a rate of 1.1 Mbit/s.  So low a rate is the hard case here, as
decoding costs least; a phone's own film has ten times of it.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import av
import cv2

from moireid.badge import Badge, load_badge
from moireid.verifier import Claim, verify
from moireid.verifier.video import Film

FILMS = Path(__file__).parent.parent / "tests" / "data" / "films"
LOOPS = (1, 8, 83)
REPEATS = {1: 7, 8: 3}


def looped(film: Path, loops: int, out: Path) -> Path:
    """The film over and over, its packets copied."""
    with av.open(str(out), "w") as made:
        stream, offset = None, 0
        for _ in range(loops):
            last = 0
            with av.open(str(film)) as source:
                seen = source.streams.video[0]
                if stream is None:
                    stream = made.add_stream_from_template(seen)
                for packet in source.demux(seen):
                    if packet.dts is None or packet.pts is None:
                        continue
                    last = max(last, packet.pts + (packet.duration or 0))
                    packet.pts, packet.dts = packet.pts + offset, packet.dts + offset
                    packet.stream = stream
                    made.mux(packet)
            offset += last
    return out


def timed_decode(film: Path) -> tuple[float, float, int]:
    """Wall and CPU seconds of decoding to grey pictures and nothing else, and frames."""
    wall, cpu, count = time.perf_counter(), time.process_time(), 0
    for _ in Film(film).frames():
        count += 1
    return time.perf_counter() - wall, time.process_time() - cpu, count


def timed_verify(film: Path, badge: Badge) -> tuple[float, float, dict[str, float], str]:
    """Wall and CPU seconds of a verify, its time by stage, and the verdict."""
    wall, cpu = time.perf_counter(), time.process_time()
    report = verify(film, Claim(badge, badge.id))
    return time.perf_counter() - wall, time.process_time() - cpu, report.timing["stages"], report.verdict


def peak_mb(film: Path, badge_json: Path) -> float:
    """Peak of resident memory of a process that verifies the film and writes the report, MB."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, __file__, str(film), str(badge_json), "--child", folder],
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        )
    return float(done.stdout)


def child(film: Path, badge_json: Path, folder: Path) -> None:
    """Verify and report as `moireid verify --report` does, and print the peak of memory."""
    from moireid.verifier.report.page import write_report

    badge = load_badge(badge_json)
    write_report(verify(film, Claim(badge, badge.id)), folder)
    if sys.platform == "linux":
        # Not `resource`: there a child's count begins with its parent's memory.
        print(int(re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[1]) / 1e3)
    else:
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3))


def row(film: Path, badge: Badge, badge_json: Path, repeats: int) -> str:
    """One line of figures, medians over repeats, and the time by stage."""
    alone, whole = [], []
    for _ in range(repeats):
        alone.append(timed_decode(film))
        whole.append(timed_verify(film, badge))
    middle = statistics.median
    ratio = middle(w[0] / a[0] for w, a in zip(whole, alone, strict=True))
    cpu_ratio = middle(w[1] / a[1] for w, a in zip(whole, alone, strict=True))
    names = list(whole[0][2])
    stages = ", ".join(f"{name} {middle(w[2].get(name, 0.0) for w in whole):.3f}" for name in names)
    figures = (
        middle(a[0] for a in alone),
        middle(w[0] for w in whole),
        ratio,
        middle(a[1] for a in alone),
        middle(w[1] for w in whole),
        cpu_ratio,
    )
    shown = "".join(f"{figure:>11.3f}" for figure in figures)
    return f"{alone[0][2]:>7}{repeats:>11}{shown}{peak_mb(film, badge_json):>11.0f}  {whole[0][3]}: {stages}"


def main() -> None:
    """Print one row a length of film."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("film", nargs="?", type=Path, default=FILMS / "genuine_1.0m.mp4")
    parser.add_argument("badge", nargs="?", type=Path, default=FILMS / "badge.json")
    parser.add_argument("--loops", nargs="*", type=int, default=LOOPS)
    parser.add_argument("--repeats", type=int, help="of every row")
    parser.add_argument("--child", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        child(given.film, given.badge, given.child)
        return
    badge = load_badge(given.badge)
    timed_verify(given.film, badge)
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, OpenCV {cv2.__version__}")
    words = ("repeats", "decode s", "verify s", "ratio", "decode CPU", "verify CPU", "CPU ratio", "peak MB")
    print(f"{'frames':>7}" + "".join(f"{word:>11}" for word in words) + "  verdict: s by stage")
    with tempfile.TemporaryDirectory() as folder:
        for loops in given.loops:
            film = looped(given.film, loops, Path(folder) / f"loops_{loops}.mp4")
            print(row(film, badge, given.badge, given.repeats or REPEATS.get(loops, 1)), flush=True)


if __name__ == "__main__":
    main()
