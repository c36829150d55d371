"""Processor time of a verify over that of decoding: run `moireid lab bench speed --keep DIR`.

The films are those of `speed_films.py`; `--keep` keeps them, as writing them takes half an hour of processor time;
with `--quick` they have 20 s instead of a minute.
Measured is a whole verify over decoding the whole film, once the libraries are loaded.  The outside films of the tests
are too short for that: of these it is what four more loops cost, a verify of five loops less one of one, over the same
of decoding.  Their packets are copied, so nothing is coded again, and where a loop ends the badge jumps.

CPU seconds are those of all threads, the least of some runs (`--clips`), which take turns.  Decoding is FFmpeg's alone:
by two threads, whose frames wait for one another, and by one, which is cheaper; there is a ratio to each.  Each film
has a process of its own with the threads of a usual one; printed are its peak of memory, and the wall seconds of the
fastest verify.

Where the time goes comes last: processor ms a frame of each stage, by the clock of the thread that it runs in.  "decode
and the rest" is what no stage has.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

import av
import cv2
from speed_films import QUICK_SECONDS, SECONDS, SHORT, SpeedFilm, speed_films

from moireid.badge import Badge
from moireid.verifier import Question, Report, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.bench_rows import Where

#: Threads of FFmpeg in the decoding that a verify is compared with.
THREADS = (2, 1)
LOOPS, RUNS = 5, 2
#: A stage is named if it takes at least so many ms a frame.
LEAST_MS = 0.02


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


def peak_mb() -> float:
    """Peak of this process's resident memory, MB; `resource` would count from its parent's."""
    return int(Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0]) / 1e3


def decode_cpu_s(film: Path, threads: int) -> float:
    """CPU seconds of decoding and nothing else, by so many threads: no picture is turned into counts."""
    begun = time.process_time()
    with av.open(str(film)) as source:
        stream = source.streams.video[0]
        stream.thread_type, stream.codec_context.thread_count = "AUTO", threads
        for _ in source.decode(stream):
            pass
    return time.process_time() - begun


@dataclass(frozen=True)
class FilmCost:
    """CPU seconds of decoding by each of `THREADS` and of a verify, its wall seconds, and its report."""

    decode_s: tuple[float, ...]
    verify_s: float
    wall_s: float
    report: Report

    @classmethod
    def measured(cls, film: Path, badge: Badge) -> FilmCost:
        """Of one run.  The clock of the stages is that of their own threads, as others run at the same time."""
        decoding, begun, clock = tuple(decode_cpu_s(film, count) for count in THREADS), time.process_time(), time.time()
        with patch("time.perf_counter", time.thread_time):
            report = verify(film, Question(badge, badge.id))
        return cls(decoding, time.process_time() - begun, time.time() - clock, report)

    def least(self, other: FilmCost) -> FilmCost:
        """The least of two runs."""
        decoding = tuple(map(min, self.decode_s, other.decode_s))
        return replace(
            min(self, other, key=lambda run: run.verify_s), decode_s=decoding, wall_s=min(self.wall_s, other.wall_s)
        )


def measured(job: tuple[str, list[str], int]) -> Row:
    """What a film costs, less the second one if there are two; in a process of its own, whose memory counts."""
    name, paths, runs = job[0], [Path(path) for path in job[1]], job[2]
    # Children of the engine are limited to one thread; a user's process is not.
    cv2.setNumThreads(max(cv2.getNumberOfCPUs(), 2))
    badge = next(film.badge for film in speed_films() if film.name == name)
    FilmCost.measured(SHORT, badge)
    costs = [FilmCost.measured(path, badge) for path in paths]
    for _ in range(runs - 1):
        costs = [cost.least(FilmCost.measured(path, badge)) for cost, path in zip(costs, paths, strict=True)]
    report = costs[0].report
    return (
        {"film": name}
        | _per_frame(costs[0], costs[1] if costs[1:] else None)
        | {
            "wall s": costs[0].wall_s,
            "tracked": report.frames["tracked"] / report.frames["read"],
            "peak MB": peak_mb(),
            "verdict": report.verdict,
            "gain": report.invariant.gain_ratio,
        }
    )


def _per_frame(whole: FilmCost, less: FilmCost | None) -> Row:
    """Processor ms a frame of decoding, verify and its stages; ratios of verify to decoding."""
    frames = whole.report.frames["read"] - (less.report.frames["read"] if less else 0)
    verify_s = whole.verify_s - (less.verify_s if less else 0.0)
    two, one = (a - b for a, b in zip(whole.decode_s, less.decode_s if less else (0.0, 0.0), strict=True))
    before = less.report.timing["stages"] if less else {}
    stages = {key: seconds - before.get(key, 0.0) for key, seconds in whole.report.timing["stages"].items()}
    stages["decode and the rest"] = verify_s - sum(stages.values())
    ms = {key: 1e3 * seconds / frames for key, seconds in stages.items()}
    return {
        "frames": frames,
        "decode ms": 1e3 * two / frames,
        "by one": 1e3 * one / frames,
        "verify ms": 1e3 * verify_s / frames,
        "ratio": verify_s / two,
        "to one": verify_s / one,
        "stages": ", ".join(f"{key} {value:.2f}" for key, value in ms.items() if value >= LEAST_MS),
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film, one at a time."""
    with wish.kept_folder() as folder, tempfile.TemporaryDirectory() as temporary:
        films = {film.name: film for film in speed_films(QUICK_SECONDS if wish.quick else SECONDS)}
        place = folder / "quick" if wish.quick else folder
        place.mkdir(exist_ok=True)
        for name in wish.chosen(films):
            job = _job(films[name], place, Path(temporary), wish.clips or RUNS)
            yield from replace(wish, only=None, where=Where(workers=1)).each(measured, {name: job})


def _job(film: SpeedFilm, folder: Path, temporary: Path, runs: int) -> tuple[str, list[str], int]:
    """What `measured` is called with."""
    once = film.within(folder)
    paths = [once] if film.write is not None else [looped(once, LOOPS, temporary / once.name), once]
    return film.name, [str(path) for path in paths], runs


def worst(found: list[Row]) -> Iterator[str]:
    """Median and worst of the ratios."""
    for key, words in (("ratio", "two threads"), ("to one", "one thread")):
        ratios = [row[key] for row in found]
        yield f"over decoding by {words}: median {statistics.median(ratios):.2f}, worst {max(ratios):.2f}"


COLUMNS = {"film": "<26", "frames": ">6", "decode ms": ">9.2f", "by one": ">6.2f", "verify ms": ">9.2f"}
COLUMNS |= {"ratio": ">5.2f", "to one": ">6.2f", "wall s": ">6.1f", "tracked": ">7.3f", "peak MB": ">7.0f"}
COLUMNS |= {"verdict": "<12", "gain": ">7.4f", "stages": "<1"}
BENCH = Bench(rows, COLUMNS, worst)
