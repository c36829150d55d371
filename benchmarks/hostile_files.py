"""Hostile films: run `.venv/bin/python benchmarks/hostile_files.py [COUNT] [--out DIR] [--workers N]`.

Films of a badge, in several codecs and containers, are cut off, overwritten, given other headers or glued; others are
headers alone that ask for huge pictures.  Worker processes verify them.  A right outcome is a verdict, or one
`MoireIdError`; wrong are any other exception, a crash, a hang, or a gigabyte of memory.

Peak memory is measured for each film (Linux; elsewhere it is the worker's peak so far).  A hang is measured in CPU
seconds, so a busy machine does not count as one.  A worker with a wrong outcome is ended and another one started.  With
`--out`, every outcome is a row of `DIR/outcomes.csv`, films with wrong outcomes are kept there, and an interrupted run
goes on where it stopped.  The films to damage are kept too, so each number is the same hostile film in every run.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import os
import random
import resource
import struct
import sys
import tempfile
import time
import zlib
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path

import psutil

from moireid.designer import Request, design_badge, payload_from_hex

COUNT = 10_000
#: A film of 20 small frames takes a tenth of a second of CPU, one of 70 half of one.
LIMIT_CPU_S, LIMIT_WALL_S, LIMIT_BYTES = 30.0, 600.0, 1 << 30
#: The system gives a worker no more memory than this; it protects the machine, and is not the limit that is tested.
GUARD_BYTES = 3 << 30
#: Container and codec, and frames: every eighth hostile film is spoilt from one that is long enough to be judged.
SHORT = {"a.mp4": "h264", "b.mkv": "h264", "c.mp4": "h265", "d.mkv": "av1"}
LONG, LONG_EVERY, LONG_FRAMES = {"long.mp4": "h264", "long.mkv": "h264"}, 8, 70
KINDS = ("cut", "flipped", "zeroed", "header", "swapped", "glued", "repeated", "huge")
COLUMNS = ("number", "kind", "outcome", "cpu_s", "peak_mb")


def spoilt_from(folder: Path) -> dict[bool, list[bytes]]:
    """Small films in each container and codec, short and long; made once a folder, because encoders may vary."""
    from moireid.simulate.cameras import Camera
    from moireid.simulate.filming import film
    from moireid.simulate.motion import motion_named
    from moireid.simulate.scene import Build, Scene

    badge = design_badge(Request("Hostile"), payload_from_hex("9462169501aab579"))
    (folder / "badge.json").write_text(badge.to_json())
    scene = Scene(badge, Build.typical(1), Camera(width=480, height=270, focal_px=360.0))
    motion = motion_named("sway", distance_mm=900.0, seed=1)
    for names, frames in ((SHORT, 20), (LONG, LONG_FRAMES)):
        for name, codec in names.items():
            if not (folder / name).exists():
                film(scene, motion, folder / name, frames=frames, fps=30.0, codec=codec)
    return {
        is_long: [(folder / name).read_bytes() for name in names] for is_long, names in ((False, SHORT), (True, LONG))
    }


def hostile(films: dict[bool, list[bytes]], number: int) -> bytes:
    """The hostile film of that number, the same every time."""
    rng = random.Random(number)
    kind = KINDS[number % len(KINDS)]
    films_now = films[number // len(KINDS) % LONG_EVERY == 0]
    data = bytearray(rng.choice(films_now))
    place = rng.randrange(len(data))
    if kind == "cut":
        return bytes(data[:place])
    if kind == "huge":
        return huge(rng)
    if kind == "flipped":
        for _ in range(rng.choice((1, 4, 64, 1024))):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif kind == "zeroed":
        data[place : place + rng.choice((16, 256, 4096))] = bytes(rng.choice((16, 256, 4096)))
    elif kind == "header":
        # The boxes and elements that say sizes and places lie at the two ends.
        for _ in range(rng.choice((1, 2, 8))):
            first, last = rng.choice(((0, min(1024, len(data) - 4)), (max(len(data) - 2048, 0), len(data) - 4)))
            at = rng.randrange(first, last)
            data[at : at + 4] = rng.choice((b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", bytes(4), rng.randbytes(4)))
    elif kind == "swapped":
        other = rng.randrange(len(data))
        size = rng.choice((64, 1024, 8192))
        one, two = bytes(data[place : place + size]), bytes(data[other : other + size])
        data[place : place + size], data[other : other + size] = two, one
    elif kind == "glued":
        data += rng.choice(films_now)[rng.randrange(1000) :]
    else:
        size = rng.choice((512, 4096))
        data[place:place] = bytes(data[place : place + size]) * rng.choice((2, 50))
    return bytes(data)


def huge(rng: random.Random) -> bytes:
    """A film of a few bytes whose header asks for pictures of any size, thin ones too."""
    width, height = (rng.choice((1, 2, 7, 100, 3000, 4096, 15_000, 16_384, 33_000, 65_535)) for _ in range(2))
    kind = rng.choice(("gif", "apng", "y4m"))
    if kind == "y4m":
        return b"YUV4MPEG2 W%d H%d F30:1 C420jpeg\n" % (width, height) + (b"FRAME\n" + rng.randbytes(500)) * 40
    if kind == "gif":
        drawn = (
            b"\x21\xf9\x04\x00\x05\x00\x00\x00\x2c" + struct.pack("<HHHHB", 0, 0, 4, 4, 0) + b"\x02\x03\x84\x8f\x09\x00"
        )
        return b"GIF89a" + struct.pack("<HHBBB", width, height, 0x80, 0, 0) + bytes(6) + drawn * 40 + b"\x3b"

    def chunk(tag: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + tag + body + struct.pack(">I", zlib.crc32(tag + body))

    depth, colour = rng.choice(((8, 0), (8, 6), (16, 6), (8, 2)))
    rows = zlib.compress(bytes(min(width, 20_000) * 8))
    frames = b"".join(
        chunk(b"fcTL", struct.pack(">IIIIIHHBB", 2 * k, width, height, 0, 0, 1, 30, 0, 0))
        + (chunk(b"fdAT", struct.pack(">I", 2 * k + 1) + rows) if k else chunk(b"IDAT", rows))
        for k in range(40)
    )
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"acTL", struct.pack(">II", 40, 0)) + frames + chunk(b"IEND", b"")


def work(badge_json: Path, pipe: Connection) -> None:
    """Verify the films whose paths come through the pipe, until None; send outcome and peak memory, bytes."""
    resource.setrlimit(resource.RLIMIT_DATA, (GUARD_BYTES, GUARD_BYTES))
    from moireid.badge import load_badge
    from moireid.errors import MoireIdError
    from moireid.verifier import Claim, verify

    badge = load_badge(badge_json)
    while (path := pipe.recv()) is not None:
        forget_peak()
        try:
            outcome = verify(path, Claim(badge, badge.id)).verdict
        except MoireIdError:
            outcome = "refused"
        except (Exception, MemoryError) as error:  # noqa: BLE001 - this is what is looked for
            outcome = f"WRONG: {type(error).__name__}: {' '.join(str(error).split())[:80]}"
        pipe.send((outcome, peak_bytes()))


def forget_peak() -> None:
    """Reset the system's count of this process's peak memory, where it can."""
    if sys.platform == "linux":
        Path("/proc/self/clear_refs").write_text("5")


def peak_bytes() -> int:
    """Peak of resident memory since it was last forgotten."""
    if sys.platform == "linux":
        line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) << 10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


class Worker:
    """A process that verifies one film after another."""

    def __init__(self, folder: Path) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=work, args=(folder / "badge.json", theirs), daemon=True)
        self._process.start()
        theirs.close()
        self.path = folder / f"hostile-{self._process.pid}.mp4"
        self.number: int | None = None
        self._cpu_s, self._wall_s = 0.0, 0.0

    def give(self, number: int, data: bytes) -> None:
        """Let it verify a film."""
        self.path.write_bytes(data)
        self.number, self._cpu_s, self._wall_s = number, self._used_s(), time.monotonic()
        self._pipe.send(self.path)

    def outcome(self) -> tuple[str, float, float] | None:
        """Outcome, CPU seconds and peak MB of the film that it was given; None while it is at work."""
        if not self._pipe.poll(0.02):
            if not self._process.is_alive():
                return f"WRONG: crash {self._process.exitcode}", 0.0, 0.0
            used = self._used_s() - self._cpu_s
            if used > LIMIT_CPU_S or time.monotonic() - self._wall_s > LIMIT_WALL_S:
                return "WRONG: hang", used, 0.0
            return None
        try:
            outcome, peak = self._pipe.recv()
        except EOFError:
            self._process.join(5)
            return f"WRONG: crash {self._process.exitcode}", 0.0, 0.0
        if peak > LIMIT_BYTES and not outcome.startswith("WRONG"):
            outcome = "WRONG: memory"
        return outcome, self._used_s() - self._cpu_s, peak / 1e6

    def end(self) -> None:
        """End it, whatever it does."""
        self._process.kill()
        self._process.join()
        self.path.unlink(missing_ok=True)

    def _used_s(self) -> float:
        try:
            times = psutil.Process(self._process.pid).cpu_times()
        except psutil.NoSuchProcess:
            return self._cpu_s
        return float(times.user + times.system)


def run(folder: Path, numbers: list[int], workers: int) -> None:
    """Verify the hostile films of these numbers, a row of `outcomes.csv` each."""
    films = spoilt_from(folder)
    busy = [Worker(folder) for _ in range(min(workers, len(numbers)))]
    waiting = iter(numbers)
    try:
        with (folder / "outcomes.csv").open("a", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            for worker in busy:
                number = next(waiting)
                worker.give(number, hostile(films, number))
            while busy:
                for place, worker in enumerate(busy):
                    outcomes = worker.outcome()
                    if outcomes is None or worker.number is None:
                        continue
                    outcome, cpu_s, peak_mb = outcomes
                    number, kind = worker.number, KINDS[worker.number % len(KINDS)]
                    writer.writerow([number, kind, outcome, f"{cpu_s:.3f}", f"{peak_mb:.0f}"])
                    stream.flush()
                    if outcome.startswith("WRONG"):
                        print(f"film {number}, {kind}: {outcome}", file=sys.stderr, flush=True)
                        (folder / f"wrong-{number}").write_bytes(hostile(films, number))
                        worker.end()
                        busy[place] = worker = Worker(folder)
                    after = next(waiting, None)
                    if after is None:
                        worker.end()
                        busy.pop(place)
                        break
                    worker.give(after, hostile(films, after))
    finally:
        for worker in busy:
            worker.end()


def rows_of(folder: Path) -> dict[int, dict[str, str]]:
    """The outcomes so far, by number; a last line that was broken off is not counted."""
    path = folder / "outcomes.csv"
    if not path.exists():
        return {}
    with path.open(newline="") as stream:
        rows = [row for row in csv.DictReader(stream, COLUMNS) if row["peak_mb"]]
    return {int(row["number"]): row for row in rows}


def main() -> None:
    """Run what is missing, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=COUNT)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.out or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        missing = sorted(set(range(given.count)) - rows_of(folder).keys())
        clock = time.monotonic()
        if missing:
            run(folder, missing, given.workers)
        rows = list(rows_of(folder).values())
    print(f"{len(missing)} films in {time.monotonic() - clock:.0f} s, {given.workers} workers; {len(rows)} in all")
    for kind in KINDS:
        own = [row for row in rows if row["kind"] == kind]
        counts = ", ".join(f"{name} {number}" for name, number in sorted(Counter(r["outcome"] for r in own).items()))
        most = max((float(row["peak_mb"]) for row in own), default=0.0)
        slowest = max((float(row["cpu_s"]) for row in own), default=0.0)
        print(f"{kind:<10}{counts}; at most {most:.0f} MB and {slowest:.1f} s of CPU")
    sys.exit(any(row["outcome"].startswith("WRONG") for row in rows))


if __name__ == "__main__":
    main()
