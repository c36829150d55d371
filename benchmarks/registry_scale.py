"""A claim among many: `moireid lab bench registry`; what `identify` takes among them is in `moireid lab cost`.

A registry of 100,000 (`--full`: a million) is built the normal way, unless it lies in `--keep`; a million take ten
minutes of processor time and 5 GB.

Measured is what publishing a bundle of all people takes, its size, and the seconds from nothing to a claimed badge, in
a new process each: by the registry, as `verify --registry` does, its state and look-alikes included, and by the bundle,
as `verify --bundle`.  Imports are in it, as they are in what a user waits for.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from moireid.designer import Order, design_badge, payload_from_hex
from moireid.idcodes import specimen_of
from moireid.registry import open_registry
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.many_people import People

BADGE = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_from_hex("7097c67b0fafc59b"))
QUICK, MANY, FULL = 1_000, 100_000, 1_000_000
#: What a new process does from its first import to the badge of a claim.
ONLINE = """
from moireid.registry import claimed, open_registry
with open_registry(sys.argv[1], create=False) as registry:
    registry.standing()
    claimed(registry, sys.argv[2]).badge
"""
OFFLINE = """
from moireid.registry.bundle.held import Bundle
with Bundle(sys.argv[1]) as bundle:
    bundle.claimed(sys.argv[2]).badge
"""
CLAIM = "import sys, time\nbegun = time.perf_counter(){look}print(time.perf_counter() - begun)"


def built(folder: Path, count: int) -> str:
    """The URL of a registry of so many people and the holder of `BADGE`; built unless it is there."""
    path = folder / f"people_{count}.sqlite3"
    url = f"sqlite:///{path}"
    if not path.exists():
        with open_registry(url, create=True) as registry:
            registry.enroll_many(People(BADGE, count))
            registry.enroll(BADGE)
    return url


def asked(program: str, *words: str) -> str:
    """What a new process prints."""
    return subprocess.run([sys.executable, "-c", program, *words], check=True, capture_output=True, text=True).stdout


def claim_rows(folder: Path, count: int, runs: int) -> Iterator[Row]:
    """Publish a bundle, and look a claim up by both."""
    url, path = built(folder, count), folder / f"people_{count}.bundle"
    begun = time.perf_counter()
    with open_registry(url, create=False) as registry:
        registry.publish(path, specimen_of, days=7, overwrite=True)
    published_s = time.perf_counter() - begun
    sizes_mb = [one.stat().st_size / 1e6 for one in (path, folder / f"people_{count}.sqlite3")]
    yield {"people": count, "publishing s": published_s, "bundle MB": sizes_mb[0], "registry MB": sizes_mb[1]}
    ways = {"registry": (ONLINE, url), "bundle": (OFFLINE, str(path))}
    took: dict[str, list[float]] = {way: [] for way in ways}
    # In turn, so that what else the machine does falls on both.
    for _ in range(runs):
        for way, (look, source) in ways.items():
            took[way].append(float(asked(CLAIM.format(look=look), source, f"Person {count - 1}")))
    for way, seconds in took.items():
        spread = {"least": min(seconds), "most": max(seconds)}
        yield {"to a claimed badge": way, "median s": statistics.median(seconds)} | spread


def rows(wish: Wish) -> Iterator[Row]:
    """The registry's rows."""
    many = FULL if wish.own.full else QUICK if wish.quick else MANY
    with wish.kept_folder() as folder:
        os.environ |= {"MOIREID_KEYS": f"{folder}/keys", "MOIREID_SEEN": f"{folder}/seen.sqlite3"}
        yield from claim_rows(folder, many, wish.clips or 9)


COLUMNS = {"people": ">9,", "publishing s": ">12.0f", "bundle MB": ">9.1f", "registry MB": ">11.1f"}
COLUMNS |= {"to a claimed badge": "<18", "median s": ">8.3f", "least": ">8.3f", "most": ">8.3f"}
BENCH = Bench(
    rows, COLUMNS, options={"--full": {"action": "store_true", "help": f"{FULL:,} people in place of {MANY:,}"}}
)
