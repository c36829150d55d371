"""How long `Verifier.push` takes: run `.venv/bin/python benchmarks/live_latency.py [--film FILE --badge FILE]`.

A film of a badge in a hand is pushed at its own pace, as a camera's frames come, with running verdicts made aside, as
the live check makes them.  Pictures lie ready, at 1080p or reduced to 720p.  Times of single frames are printed, from a
second after the badge is found: on the clock, and on the clock less the time for which a frame waited for a processor
that other programs, or the verdict, had (Linux alone reports that).  The best of some rounds, frame by frame and
without verdicts, is what following the badge takes by itself.  The film is shown forwards and backwards until it is
longer than a chapter, so that the judging of one is among the times; CPU milliseconds of all threads are printed with
them.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, load_badge
from moireid.verifier import Claim, Film, Frame, Verifier
from moireid.verifier.session.chapters import CHAPTER_FRAMES

HEIGHTS = (720, 1080)
#: Of the film that is simulated, and rounds of the last figure.
FRAMES, FPS, ROUNDS = 600, 60.0, 4
WAITED = Path("/proc/thread-self/schedstat")


def simulated(folder: Path) -> tuple[Path, Path]:
    """A film of a badge in a hand by the project's own simulator, and the badge's file."""
    from click.testing import CliRunner

    from moireid.cli.main import main as moireid
    from moireid.designer import Request, design_badge, payload_from_hex

    film, badge = folder / "film.mp4", folder / "badge.json"
    badge.write_text(design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b")).to_json())
    wish = ["simulate", str(badge), "--out", str(film), "--frames", str(FRAMES), "--fps", str(FPS), "--json"]
    CliRunner().invoke(moireid, wish, catch_exceptions=False)
    return film, badge


def pictures(film: Path, height: int) -> list[Frame]:
    """Grey frames of a film, reduced to a height."""
    made = []
    for frame in Film(film).frames():
        luma = frame.luma
        if luma.shape[0] > height:
            size = (round(luma.shape[1] * height / luma.shape[0]), height)
            luma = np.asarray(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), np.uint8)
        made.append(Frame(frame.index, frame.time_s, luma))
    return made


def to_and_fro(frames: list[Frame]) -> list[Frame]:
    """The frames forwards and backwards, without a jump, until a chapter has ended among them."""
    legs = math.ceil((CHAPTER_FRAMES + 2 * FPS) / len(frames))
    order = [frame for leg in range(legs) for frame in (frames[::-1] if leg % 2 else frames)]
    return [Frame(k, k / FPS, frame.luma) for k, frame in enumerate(order)]


def waited_s() -> float:
    """Seconds for which this thread was ready and had no processor; nan if the system does not report it."""
    return int(WAITED.read_text().split()[1]) / 1e9 if WAITED.exists() else np.nan


def live(frames: list[Frame], badge: Badge) -> tuple[NDArray[np.float64], float]:
    """Milliseconds of each push at the film's pace, on the clock and less the wait, (T, 2); CPU ms a frame."""
    took, used = [], time.process_time()
    with ThreadPoolExecutor(1) as aside:
        verifier, begun = Verifier(Claim(badge, badge.id), aside=aside), time.perf_counter()
        for frame in frames:
            time.sleep(max(begun + frame.time_s - time.perf_counter(), 0.0))
            waited, clock = waited_s(), time.perf_counter()
            verifier.push(frame)
            wall = time.perf_counter() - clock
            took.append((wall, wall - (waited_s() - waited)))
        used = time.process_time() - used
        verifier.finish()
    return 1e3 * np.array(took), 1e3 * used / len(frames)


def alone(frames: list[Frame], badge: Badge) -> NDArray[np.float64]:
    """Milliseconds of each push without verdicts, the best of some rounds, (T,)."""
    rounds = []
    for _ in range(ROUNDS):
        verifier = Verifier(Claim(badge, badge.id), running=False)
        clocks = [time.perf_counter()]
        for frame in frames:
            verifier.push(frame)
            clocks.append(time.perf_counter())
        rounds.append(np.diff(clocks))
    return 1e3 * np.min(rounds, axis=0)


def line(label: str, took_ms: NDArray[np.float64]) -> None:
    """Percentiles, leaving out the first second, in which the badge is found."""
    middle, most, tail = np.percentile(took_ms[round(FPS) :], (50, 90, 99))
    print(f"{label:<44}{middle:>8.1f}{most:>8.1f}{tail:>8.1f}{took_ms[round(FPS) :].max():>8.1f}", flush=True)


def main() -> None:
    """Print four lines a picture size."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--film", type=Path, help="instead of a simulated one; 1080p or larger")
    parser.add_argument("--badge", type=Path, help="the badge.json of that film")
    given = parser.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, OpenCV {cv2.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        film, path = (given.film, given.badge) if given.film else simulated(Path(folder))
        print(f"{'ms a frame':<44}{'p50':>8}{'p90':>8}{'p99':>8}{'most':>8}")
        badge = load_badge(path)
        for height in HEIGHTS:
            frames = pictures(film, height)
            both, cpu_ms = live(to_and_fro(frames), badge)
            line(f"{height}p, live, on the clock", both[:, 0])
            line(f"{height}p, live, less waits for a processor", both[:, 1])
            print(f"{height}p, CPU of all threads, verdicts too: {cpu_ms:.1f} ms a frame")
            line(f"{height}p, following alone, best of {ROUNDS}", alone(frames, badge))


if __name__ == "__main__":
    main()
