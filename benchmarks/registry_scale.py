"""The registry with many records: run `.venv/bin/python benchmarks/registry_scale.py`, with --full for a million.

Every record goes the normal way: designed layout, JSON, signature, log entry, transaction.  Badges are made by putting
other ids, names and spacings into a designed one, because designing 100,000 takes longer than all else; the time that
this takes is measured apart and left out.  A cold look-up is a new process's first: opening and `by_id` are timed in
it, imports apart; once with the file in the system's cache, and once after asking the system to forget it.
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
from collections.abc import Iterator
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.registry import import_registry, open_registry

QUICK = {"batch": 20_000, "lookup": 20_000}
FULL = {"batch": 100_000, "lookup": 1_000_000}
RUNS = 7

COLD = """
import json, sys, time
begun = time.perf_counter()
import jsonschema
import sqlalchemy.dialects.sqlite
from moireid.registry import open_registry
imported = time.perf_counter()
registry = open_registry(sys.argv[1], create=False)
opened = time.perf_counter()
record = registry.by_id(sys.argv[2])
found = time.perf_counter()
record.badge
read = time.perf_counter()
assert record.id == sys.argv[2]
print(json.dumps([imported - begun, opened - imported, found - opened, found - imported, read - found]))
"""


class People:
    """Badges of one layout, each with its own id, name and spacings; `made_s` adds up the time that making takes."""

    def __init__(self, first: Badge, count: int) -> None:
        self._first, self._count = first, count
        self.made_s = 0.0

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Badge]:
        for number in range(self._count):
            begun = time.process_time()
            badge = self._badge(number)
            self.made_s += time.process_time() - begun
            yield badge

    def _badge(self, number: int) -> Badge:
        digest = sha256(f"person {number}".encode()).digest()
        grating = self._first.gratings[0]
        stretch = [1.0 + 0.01 * byte / 255 for byte in digest]
        cells = tuple(replace(c, pitch_mm=c.pitch_mm * stretch[k % 32]) for k, c in enumerate(grating.cells))
        gratings = (replace(grating, cells=cells),)
        return replace(self._first, id=id_of(number), name=f"Person {number}", gratings=gratings)


def id_of(number: int) -> str:
    """A 64-bit id that looks random, like true ids."""
    return sha256(f"person {number}".encode()).hexdigest()[:16]


def progress(done: int, total: int | None) -> None:
    """Say how far a long run is, if someone watches."""
    if sys.stderr.isatty():
        print(f"\r{done:>10,} of {total or 0:,}", end="", file=sys.stderr)


class Clock:
    """Wall and processor seconds since it was made; on a shared machine, wall seconds include the others' work."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def line(self, label: str, count: int, left_out_s: float = 0.0) -> None:
        """One line of the first table; `left_out_s` is taken off."""
        wall = time.perf_counter() - self._wall - left_out_s
        cpu = time.process_time() - self._cpu - left_out_s
        print(f"{label:<52}{count:>10,}{wall:>10.1f}{cpu:>10.1f}{1e3 * wall / count:>10.3f}", flush=True)


def batch(folder: Path, label: str, first: Badge, count: int) -> None:
    """Enroll a batch, run it again, audit, export and import."""
    url = f"sqlite:///{folder}/{label.split()[0]}.sqlite3"
    people = People(first, count)
    with open_registry(url, create=True) as registry:
        clock = Clock()
        assert registry.enroll_many(people, progress).enrolled == count
        clock.line(f"enroll_many, {label}", count, people.made_s)
        people.made_s, clock = 0.0, Clock()
        assert registry.enroll_many(people, progress).unchanged == count
        clock.line("  the same batch again", count, people.made_s)
        clock = Clock()
        assert registry.audit(progress=progress).sound
        clock.line("  audit", count)
        clock = Clock()
        registry.export_json(folder / "export.json", overwrite=True)
        clock.line("  export", count)
    clock = Clock()
    assert import_registry(folder / "export.json", f"sqlite:///{folder}/copy.sqlite3").added == count
    clock.line("  import, audit of the copy included", count)
    size_kb = [(folder / name).stat().st_size / count / 1e3 for name in (f"{label.split()[0]}.sqlite3", "export.json")]
    print(f"  {size_kb[0]:.2f} kB a record in SQLite, {size_kb[1]:.2f} kB in the export")
    for name in ("copy.sqlite3", "export.json"):
        (folder / name).unlink()


def lookup(folder: Path, first: Badge, count: int) -> None:
    """Build a registry of `count` and look up one record in new processes."""
    path = folder / "lookup.sqlite3"
    url = f"sqlite:///{path}"
    people = People(first, count)
    with open_registry(url, create=True) as registry:
        clock = Clock()
        registry.enroll_many(people, progress)
        clock.line("\nbuilt for look-ups", count, people.made_s)
    print(f"\n{'cold process, ms: median (least to most)':<42}{'imports':>18}{'open':>18}{'by_id':>18}{'both':>18}")
    for label, forget in (("file in the cache", False), ("file not in the cache", True)):
        runs = [cold(url, path, id_of(k * count // RUNS), forget=forget) for k in range(RUNS)]
        cells = [f"{statistics.median(c):.1f} ({min(c):.1f}-{max(c):.1f})" for c in zip(*runs, strict=True)]
        print(f"{label:<42}" + "".join(f"{cell:>18}" for cell in cells[:4]) + f"   badge from its JSON: {cells[4]}")
    with open_registry(url, create=False) as registry:
        asked = {
            "find by name": lambda: registry.find("Person 7"),
            "look-alikes of a name": lambda: registry.look_alikes(["PERSON 7"]),
            "layouts": registry.layouts,
        }
        for label, query in asked.items():
            begun = time.perf_counter()
            query()
            print(f"{label}: {1e3 * (time.perf_counter() - begun):.1f} ms")


def cold(url: str, path: Path, badge_id: str, *, forget: bool) -> list[float]:
    """Milliseconds that a new process takes to import, open, look up, both of these, and make the Badge."""
    if forget:
        handle = os.open(path, os.O_RDONLY)
        os.fsync(handle)
        os.posix_fadvise(handle, 0, 0, os.POSIX_FADV_DONTNEED)
        os.close(handle)
    done = subprocess.run([sys.executable, "-c", COLD, url, badge_id], check=True, capture_output=True, text=True)
    return [1e3 * seconds for seconds in json.loads(done.stdout)]


def main() -> None:
    """Print what batches and look-ups take."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="batches of 100,000, and a look-up among 1,000,000")
    parser.add_argument("--folder", type=Path, help="where the databases lie for the time being")
    given = parser.parse_args()
    counts = FULL if given.full else QUICK
    ada = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    large = design_badge(Request("Ada Lovelace"), bytes(16))
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}\n")
    print(f"{'':<52}{'records':>10}{'wall s':>10}{'CPU s':>10}{'ms each':>10}")
    with tempfile.TemporaryDirectory(dir=given.folder) as folder:
        os.environ["MOIREID_KEYS"] = f"{folder}/keys"
        for label, first in (("small badges", ada), ("large badges", large)):
            kilobytes = len(first.to_json()) / 1e3
            of = f"{label} ({len(first.gratings[0].cells)} cells, {kilobytes:.0f} kB)"
            batch(Path(folder), of, first, counts["batch"])
        lookup(Path(folder), ada, counts["lookup"])


if __name__ == "__main__":
    main()
