"""Processor time of a verify over that of decoding: run `.venv/bin/python benchmarks/verify_speed.py [--only WORD]`.

Measured as the time that four more loops of a film cost: a verify of 5 loops less one of 1, over the decoding of 5
loops less that of 1.  So start, camera and verdict of a short film do not count, but frames do.  Packets are copied one
loop after another with their times moved on, so nothing is coded again, and where a loop ends the badge jumps.
CPU seconds are those of all threads.  Each film has a process of its own, whose peak of memory is printed.

The films are those of `speed_films.py`; the low bit rate of the outside films is the hard case here, as decoding costs
least.  `--stages` adds where the time goes: wall seconds of each stage over the CPU seconds of decoding.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import av
import cv2
from one_verify import peak_mb
from speed_films import SpeedFilm, speed_films

from moireid.badge import Badge
from moireid.verifier import Claim, Report, verify
from moireid.verifier.video import Film

LOOPS = 5
#: A stage is named if it takes at least this share of decoding.
LEAST_SHARE = 0.02


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


def made(film: SpeedFilm, folder: Path) -> Path:
    """The film, written into the folder unless it lies there."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{film.name.replace(' ', '_')}.mp4"
    return path if path.exists() else film.write(path)


def decode_cpu_s(film: Path) -> float:
    """CPU seconds of decoding and nothing else: no picture is turned into counts."""
    begun = time.process_time()
    for _ in Film(film).frames():
        pass
    return time.process_time() - begun


def verify_cpu_s(film: Path, badge: Badge) -> tuple[float, Report]:
    """CPU seconds of a verify, and its report."""
    begun = time.process_time()
    report = verify(film, Claim(badge, badge.id))
    return time.process_time() - begun, report


def measured(film: SpeedFilm, once: Path, loops: Path, repeats: int) -> dict[str, Any]:
    """What more loops of a film cost, and what they give."""
    verify_cpu_s(once, film.badge)
    decoding, verifying = [], []
    for _ in range(repeats):
        decoding.append(decode_cpu_s(loops) - decode_cpu_s(once))
        short, report = verify_cpu_s(once, film.badge)
        long, whole = verify_cpu_s(loops, film.badge)
        verifying.append(long - short)
    stages = Counter(whole.timing["stages"])
    stages.subtract(report.timing["stages"])
    return {
        "decode_s": statistics.median(decoding),
        "verify_s": statistics.median(verifying),
        "frames": whole.frames["read"] - report.frames["read"],
        "tracked": whole.frames["tracked"] / whole.frames["read"],
        "verdict": report.verdict,
        "gain": report.invariant.gain_ratio,
        "stages": stages,
        "peak_mb": peak_mb(),
    }


def row(name: str, found: dict[str, Any], *, stages: bool) -> str:
    """One line of figures, and one of stages if they are asked for."""
    gain = "-" if found["gain"] is None else f"{found['gain']:.4f}"
    line = (
        f"{name:<28}{found['frames']:>7}{1e3 * found['decode_s'] / found['frames']:>11.2f}"
        f"{1e3 * found['verify_s'] / found['frames']:>11.2f}{found['verify_s'] / found['decode_s']:>8.2f}"
        f"{found['tracked']:>9.3f}{found['peak_mb']:>9.0f}  {found['verdict']:<13}{gain:>8}"
    )
    shares = {stage: seconds / found["decode_s"] for stage, seconds in found["stages"].items()}
    shown = ", ".join(f"{stage} {share:.2f}" for stage, share in shares.items() if share >= LEAST_SHARE)
    return f"{line}\n    {shown}" if stages else line


def main() -> None:
    """Print one row a film, then median and worst of their ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", default=[""], metavar="WORD", help="films whose name holds one of these")
    parser.add_argument("--repeats", type=int, default=1, help="of each film, for the median")
    parser.add_argument("--stages", action="store_true", help="also print where the time goes")
    parser.add_argument("--films", type=Path, metavar="DIR", help="keep the films here, and use those that lie here")
    parser.add_argument("--child", nargs=3, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        name, once, loops = given.child
        film = next(film for film in speed_films() if film.name == name)
        print(json.dumps(measured(film, Path(once), Path(loops), given.repeats)))
        return
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, OpenCV {cv2.__version__}")
    words = f"{'frames':>7}{'decode ms':>11}{'verify ms':>11}{'ratio':>8}{'tracked':>9}{'peak MB':>9}  {'verdict':<13}"
    print(f"{'film':<28}{words}{'gain':>8}")
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        for film in speed_films():
            if not any(word in film.name for word in given.only):
                continue
            once = made(film, given.films or Path(folder))
            loops = looped(once, LOOPS, Path(folder) / "loops.mp4")
            command = [sys.executable, __file__, "--repeats", str(given.repeats), "--child", film.name, once, loops]
            done = subprocess.run([str(word) for word in command], check=True, stdout=subprocess.PIPE, text=True)
            found = json.loads(done.stdout)
            ratios.append(found["verify_s"] / found["decode_s"])
            print(row(film.name, found, stages=given.stages), flush=True)
    print(f"median {statistics.median(ratios):.2f}, worst {max(ratios):.2f}")


if __name__ == "__main__":
    main()
