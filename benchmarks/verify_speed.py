"""Processor time of a verify over that of decoding: run `.venv/bin/python benchmarks/verify_speed.py [--only REGEX]`.

Measured as the time that four more loops of a film cost: a verify of 5 loops less one of 1, over the decoding of 5
loops less that of 1.  So start, camera and verdict of a short film do not count, but frames do.  Packets are copied one
loop after another with their times moved on, so nothing is coded again, and where a loop ends the badge jumps.
CPU seconds are those of all threads.  Each film has a process of its own, whose peak of memory is printed.

The films are those of `speed_films.py`; the low bit rate of the outside films is the hard case here, as decoding costs
least.  Where the time goes comes last: wall seconds of each stage over the CPU seconds of decoding.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import av
from one_verify import memory_mb
from speed_films import SpeedFilm, speed_films

from moireid.badge import Badge
from moireid.verifier import Claim, Report, verify
from moireid.verifier.video import Film
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script
from moireid_lab.bench.bench_rows import Where

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


def measured(job: tuple[str, str, str, int]) -> Row:
    """What more loops of a film cost, and what they give; in a process of its own, whose memory counts."""
    name, once, loops, repeats = job[0], Path(job[1]), Path(job[2]), job[3]
    film = next(film for film in speed_films() if film.name == name)
    verify_cpu_s(once, film.badge)
    decoding, verifying = [], []
    for _ in range(repeats):
        decoding.append(decode_cpu_s(loops) - decode_cpu_s(once))
        short, report = verify_cpu_s(once, film.badge)
        long, whole = verify_cpu_s(loops, film.badge)
        verifying.append(long - short)
    stages = Counter(whole.timing["stages"])
    stages.subtract(report.timing["stages"])
    decode_s, verify_s = statistics.median(decoding), statistics.median(verifying)
    frames = whole.frames["read"] - report.frames["read"]
    shares = {stage: seconds / decode_s for stage, seconds in stages.items()}
    return {
        "film": name,
        "frames": frames,
        "decode ms": 1e3 * decode_s / frames,
        "verify ms": 1e3 * verify_s / frames,
        "ratio": verify_s / decode_s,
        "tracked": whole.frames["tracked"] / whole.frames["read"],
        "peak MB": memory_mb("VmHWM"),
        "verdict": report.verdict,
        "gain": report.invariant.gain_ratio,
        "stages": [f"{stage} {share:.2f}" for stage, share in shares.items() if share >= LEAST_SHARE],
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film, one at a time."""
    with wish.kept_folder() as folder, tempfile.TemporaryDirectory() as temporary:
        films = {film.name: film for film in speed_films()}
        for name in wish.chosen(films):
            once = made(films[name], folder)
            loops = looped(once, LOOPS, Path(temporary) / "loops.mp4")
            job = (name, str(once), str(loops), wish.clips or 1)
            yield from replace(wish, only=None, where=Where(workers=1)).each(measured, {name: job})


def worst(found: list[Row]) -> Iterator[str]:
    """Median and worst of the ratios."""
    ratios = [row["ratio"] for row in found]
    yield f"median {statistics.median(ratios):.2f}, worst {max(ratios):.2f}"


COLUMNS = {"film": "<27", "frames": ">6", "decode ms": ">10.2f", "verify ms": ">10.2f", "ratio": ">7.2f"}
COLUMNS |= {"tracked": ">8.3f", "peak MB": ">8.0f", "verdict": "<12", "gain": ">7.4f", "stages": "<1"}
BENCH = Bench(rows, COLUMNS, worst)

if __name__ == "__main__":
    run_script(__file__)
