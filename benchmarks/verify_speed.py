"""Processor time of a verify over that of decoding: run `moireid lab bench verify --keep DIR`.

The films are those of `speed_films.py`; `--keep` keeps them, as writing them takes half an hour of processor time;
with `--quick` they have 20 s instead of a minute.  The outside films of the tests are too short, and are shown five
times over; their packets are copied, so nothing is coded again, and where a loop ends the badge jumps.

Measured is a whole verify over decoding the whole film by two threads of FFmpeg, once the libraries are loaded: the
least of some runs (`--clips`), in CPU seconds of all threads.  Each film has a process of its own, with the threads of
a usual one.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import av
import cv2
from speed_films import QUICK_SECONDS, SECONDS, SHORT, speed_films

from moireid.verifier import Question, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.bench_rows import Where
from moireid_lab.commands.cost_cmd import looped

LOOPS, RUNS, THREADS = 5, 2, 2


def decode_cpu_s(film: Path) -> float:
    """CPU seconds of decoding and nothing else: no picture is turned into counts."""
    begun = time.process_time()
    with av.open(str(film)) as source:
        stream = source.streams.video[0]
        stream.thread_type, stream.codec_context.thread_count = "AUTO", THREADS
        for _ in source.decode(stream):
            pass
    return time.process_time() - begun


def measured(job: tuple[str, str, int]) -> Row:
    """What a film costs."""
    name, film, runs = job
    # Children of the engine are limited to one thread; a user's process is not.
    cv2.setNumThreads(max(cv2.getNumberOfCPUs(), 2))
    badge = next(film.badge for film in speed_films() if film.name == name)
    verify(SHORT, Question(badge, badge.id))
    decode_s, verify_s = [], []
    for _ in range(runs):
        decode_s.append(decode_cpu_s(Path(film)))
        begun = time.process_time()
        report = verify(Path(film), Question(badge, badge.id))
        verify_s.append(time.process_time() - begun)
    frames = report.frames["read"]
    return {
        "film": name,
        "frames": frames,
        "decode ms": 1e3 * min(decode_s) / frames,
        "verify ms": 1e3 * min(verify_s) / frames,
        "ratio": min(verify_s) / min(decode_s),
        "tracked": report.frames["tracked"] / frames,
        "verdict": report.verdict,
        "gain": report.invariant.gain_ratio,
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film, one at a time."""
    with wish.kept_folder() as folder, tempfile.TemporaryDirectory() as temporary:
        films = {film.name: film for film in speed_films(QUICK_SECONDS if wish.quick else SECONDS)}
        place = folder / "quick" if wish.quick else folder
        place.mkdir(exist_ok=True)
        for name in wish.chosen(films):
            path = films[name].within(place)
            if films[name].write is None:
                path = looped(path, Path(temporary) / path.name, LOOPS)
            job = {name: (name, str(path), wish.clips or RUNS)}
            yield from replace(wish, only=None, where=Where(workers=1)).each(measured, job)


def worst(found: list[Row]) -> Iterator[str]:
    """Median and worst of the ratios."""
    ratios = [row["ratio"] for row in found]
    yield f"over decoding: median {statistics.median(ratios):.2f}, worst {max(ratios):.2f}"


COLUMNS = {"film": "<26", "frames": ">6", "decode ms": ">9.2f", "verify ms": ">9.2f", "ratio": ">5.2f"}
COLUMNS |= {"tracked": ">7.3f", "verdict": "<12", "gain": ">7.4f"}
BENCH = Bench(rows, COLUMNS, worst)
