"""Hostile films: run `.venv/bin/python benchmarks/hostile_files.py [COUNT]`; prints what became of each kind.

Small films of a badge, in several codecs and containers, are cut off, overwritten, given other headers or glued,
and verified by worker processes of limited memory and time.  A right outcome is a verdict, or one `MoireIdError`; wrong
are any other exception, a crash, a hang, or more memory than a gigabyte.
"""

from __future__ import annotations

import multiprocessing
import queue
import random
import resource
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from moireid.designer import Request, design_badge, payload_for_name

COUNT, WORKERS = 10_000, 2
LIMIT_S, LIMIT_BYTES = 30.0, 1 << 30
FILMS = {"a.mp4": "h264", "b.mkv": "h264", "c.mp4": "h265", "d.mkv": "av1"}
KINDS = ("cut", "flipped", "zeroed", "header", "swapped", "glued", "repeated")


def seeds(folder: Path) -> list[bytes]:
    """A small film in each container and codec."""
    from moireid.simulate.camera import Camera
    from moireid.simulate.film import film
    from moireid.simulate.motion import motion_named
    from moireid.simulate.scene import Build, Scene

    badge = design_badge(Request("Hostile"), payload_for_name("Hostile"))
    (folder / "badge.json").write_text(badge.to_json())
    scene = Scene(badge, Build.typical(1), Camera(width=480, height=270, focal_px=360.0))
    motion = motion_named("sway", distance_mm=900.0, seed=1)
    found = []
    for name, codec in FILMS.items():
        film(scene, motion, folder / name, frames=20, fps=30.0, codec=codec)
        found.append((folder / name).read_bytes())
    return found


def mutated(films: list[bytes], number: int) -> tuple[str, bytes]:
    """The hostile film of that number, and how it was made; the same every time."""
    rng = random.Random(number)
    kind, data = KINDS[number % len(KINDS)], bytearray(rng.choice(films))
    place = rng.randrange(len(data))
    if kind == "cut":
        return kind, bytes(data[:place])
    if kind == "flipped":
        for _ in range(rng.choice((1, 4, 64, 1024))):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif kind == "zeroed":
        data[place : place + rng.choice((16, 256, 4096))] = bytes(rng.choice((16, 256, 4096)))
    elif kind == "header":
        # The boxes and elements that say sizes and places lie at the two ends.
        for _ in range(rng.choice((1, 2, 8))):
            at = rng.randrange(min(1024, len(data) - 4)) if rng.random() < 0.5 else rng.randrange(
                max(len(data) - 2048, 0), len(data) - 4)  # fmt: skip
            data[at : at + 4] = rng.choice((b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", bytes(4), rng.randbytes(4)))
    elif kind == "swapped":
        other = rng.randrange(len(data))
        size = rng.choice((64, 1024, 8192))
        one, two = bytes(data[place : place + size]), bytes(data[other : other + size])
        data[place : place + size], data[other : other + size] = two, one
    elif kind == "glued":
        data += rng.choice(films)[rng.randrange(1000) :]
    else:
        size = rng.choice((512, 4096))
        data[place:place] = bytes(data[place : place + size]) * rng.choice((2, 50))
    return kind, bytes(data)


def work(folder: str, films: list[bytes], asked: multiprocessing.Queue, told: multiprocessing.Queue) -> None:
    """Verify the films of the numbers asked for, until None."""
    from moireid.badge import load_badge
    from moireid.errors import MoireIdError
    from moireid.verifier import verify

    badge = load_badge(Path(folder) / "badge.json")
    while (number := asked.get()) is not None:
        told.put(("begun", number, ""))
        data = mutated(films, number)[1]
        path = Path(folder) / f"hostile-{multiprocessing.current_process().pid}.mp4"
        path.write_bytes(data)
        try:
            outcome = verify(path, badge, claimed_id=badge.id).verdict
        except MoireIdError:
            outcome = "refused"
        except Exception as error:  # noqa: BLE001 - this is what is looked for
            outcome = f"WRONG: {type(error).__name__}: {str(error)[:80]}"
        peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        told.put(("done", number, f"WRONG: {peak >> 20} MB" if peak > LIMIT_BYTES else outcome))
    told.put(("left", -1, ""))


def main() -> None:
    """Run all, and print a table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    context = multiprocessing.get_context("spawn")
    table: dict[str, Counter[str]] = {kind: Counter() for kind in KINDS}
    with tempfile.TemporaryDirectory() as folder:
        films = seeds(Path(folder))
        asked, told = context.Queue(), context.Queue()
        for number in range(count):
            asked.put(number)
        for _ in range(WORKERS):
            asked.put(None)
        begun: dict[int, float] = {}
        workers = [context.Process(target=work, args=(folder, films, asked, told), daemon=True) for _ in range(WORKERS)]
        for worker in workers:
            worker.start()
        left, clock = 0, time.monotonic()
        while left < len(workers):
            try:
                what, number, outcome = told.get(timeout=1.0)
            except queue.Empty:
                late = [n for n, since in begun.items() if time.monotonic() - since > LIMIT_S]
                dead = [worker for worker in workers if not worker.is_alive() and worker.exitcode]
                if late or dead:
                    print(f"a worker hung or died; films under way: {sorted(begun)}", file=sys.stderr)
                    table["cut"]["WRONG: hang or crash"] += 1
                    break
                continue
            if what == "left":
                left += 1
            elif what == "begun":
                begun[number] = time.monotonic()
            else:
                begun.pop(number, None)
                table[KINDS[number % len(KINDS)]][outcome] += 1
                if outcome.startswith("WRONG"):
                    print(f"film {number}: {outcome}", file=sys.stderr)
        for worker in workers:
            worker.terminate()
        print(f"{count} films in {time.monotonic() - clock:.0f} s, {WORKERS} workers")
    for kind, outcomes in table.items():
        print(f"{kind:<10}" + ", ".join(f"{name} {number}" for name, number in sorted(outcomes.items())))
    sys.exit(any(name.startswith("WRONG") for outcomes in table.values() for name in outcomes))


if __name__ == "__main__":
    main()
