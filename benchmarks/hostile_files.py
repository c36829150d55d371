"""Hostile films: run `.venv/bin/python benchmarks/hostile_files.py [--clips COUNT] [--keep DIR]`.

Films of a badge, in several codecs and containers, are cut off, overwritten, given other headers or glued; others are
headers alone that ask for huge pictures.  Processes of their own verify them.  A right outcome is a verdict, or one
`MoireIdError`; wrong are any other exception, a crash, a hang, or a gigabyte of memory.

With `--keep` the films to damage are kept, so each number is the same hostile film in every run, and those with wrong
outcomes lie there too.  Where a run was interrupted, `--first NUMBER` goes on.
"""

from __future__ import annotations

import random
import struct
import sys
import zlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from moireid.designer import Request, design_badge, payload_from_hex
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import Limits, LostJob
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

COUNT = 10_000
#: A film of 20 small frames takes a tenth of a second of CPU, one of 70 half of one.
LIMITS = Limits(seconds=60.0, memory_mb=1024)
#: Container and codec, and frames: every eighth hostile film is spoilt from one that is long enough to be judged.
SHORT = {"a.mp4": "h264", "b.mkv": "h264", "c.mp4": "h265", "d.mkv": "av1"}
LONG, LONG_EVERY, LONG_FRAMES = {"long.mp4": "h264", "long.mkv": "h264"}, 8, 70
KINDS = ("cut", "flipped", "zeroed", "header", "swapped", "glued", "repeated", "huge")


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


def outcome_of(job: tuple[str, int]) -> str:
    """What becomes of the hostile film of a number."""
    from moireid.badge import load_badge
    from moireid.errors import MoireIdError
    from moireid.verifier import Claim, verify

    folder, number = Path(job[0]), job[1]
    path, badge = folder / f"hostile-{number}.mp4", load_badge(folder / "badge.json")
    path.write_bytes(hostile(spoilt_from(folder), number))
    try:
        outcome = verify(path, Claim(badge, badge.id)).verdict
    except MoireIdError:
        outcome = "refused"
    except (Exception, MemoryError) as error:  # noqa: BLE001 - this is what is looked for
        return f"WRONG: {type(error).__name__}: {' '.join(str(error).split())[:80]}"
    path.unlink()
    return outcome


def rows(wish: Wish) -> Iterator[Row]:
    """One row a kind."""
    numbers = range(wish.own.first, wish.own.first + (wish.clips or (80 if wish.quick else COUNT)))
    outcomes: dict[str, Counter[str]] = {kind: Counter() for kind in KINDS}
    with wish.kept_folder() as folder:
        spoilt_from(folder)
        tasks = [Task(((str(folder), number),)) for number in numbers]
        for count, (place, done) in enumerate(run_tasks(outcome_of, tasks, workers=wish.where.workers, limits=LIMITS)):
            (found,) = done.outcomes
            outcome = f"WRONG: {found.fault}" if isinstance(found, LostJob) else found
            outcomes[KINDS[numbers[place] % len(KINDS)]][outcome] += 1
            if outcome.startswith("WRONG"):
                print(f"film {numbers[place]}: {outcome}", file=sys.stderr, flush=True)
            wish.progress(count + 1, len(numbers))
    for kind, found in outcomes.items():
        yield {"kind": kind, "outcomes": [f"{name} {number}" for name, number in sorted(found.items())]}


def check(found: list[Row]) -> Iterator[str]:
    """Exit code 1 where an outcome is wrong."""
    yield f"wrong: {sum(one.startswith('WRONG') for row in found for one in row['outcomes'])}"
    if any(one.startswith("WRONG") for row in found for one in row["outcomes"]):
        raise SystemExit(1)


OPTIONS = {"--first": {"type": int, "default": 0, "metavar": "NUMBER", "help": "of the first hostile film"}}
BENCH = Bench(rows, {"kind": "<10", "outcomes": "<1"}, check, OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
