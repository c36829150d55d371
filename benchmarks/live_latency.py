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

import math
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, load_badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.filming import FilmOptions, filmed, scene_of
from moireid.verifier import Claim, Film, Frame, Verifier
from moireid.verifier.session.chapters import CHAPTER_FRAMES
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

HEIGHTS = (720, 1080)
#: Of the film that is simulated, and rounds of the last figure.
FRAMES, FPS, ROUNDS = 600, 60.0, 4
WAITED = Path("/proc/thread-self/schedstat")


def simulated(folder: Path) -> tuple[Path, Path]:
    """A film of a badge in a hand by the project's own simulator, and the badge's file."""
    film, path = folder / "film.mp4", folder / "badge.json"
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    path.write_text(badge.to_json())
    wish = FilmOptions(frames=FRAMES, fps=FPS)
    filmed(scene_of(badge, wish), wish, film)
    return film, path


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


def percentiles(took_ms: NDArray[np.float64]) -> Row:
    """Percentiles, leaving out the first second, in which the badge is found."""
    middle, most, tail = np.percentile(took_ms[round(FPS) :], (50, 90, 99)).tolist()
    return {"p50": middle, "p90": most, "p99": tail, "most": float(took_ms[round(FPS) :].max())}


def rows(wish: Wish) -> Iterator[Row]:
    """Three rows a picture size, and the processor time."""
    with wish.kept_folder() as folder:
        film, path = (wish.own.film, wish.own.badge) if wish.own.film else simulated(folder)
        badge = load_badge(path)
        for height in HEIGHTS:
            frames = pictures(film, height)
            both, cpu_ms = live(to_and_fro(frames), badge)
            yield {"ms a frame": f"{height}p, live, on the clock"} | percentiles(both[:, 0])
            yield {"ms a frame": f"{height}p, live, less waits for a processor"} | percentiles(both[:, 1])
            yield {"ms a frame": f"{height}p, following alone, best of {ROUNDS}"} | percentiles(alone(frames, badge))
            yield {"ms a frame": f"{height}p, CPU of all threads, verdicts too", "CPU": cpu_ms}


OPTIONS = {
    "--film": {"type": Path, "help": "instead of a simulated one; 1080p or larger"},
    "--badge": {"type": Path, "help": "the badge.json of that film"},
}
COLUMNS = {"ms a frame": "<43", "p50": ">7.1f", "p90": ">7.1f", "p99": ">7.1f", "most": ">7.1f", "CPU": ">7.1f"}
BENCH = Bench(rows, COLUMNS, options=OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
