"""A claim among many: `moireid lab bench registry`; what `identify` takes among them is in `moireid lab cost`.

A registry of 100,000 (`--clips N`: of N) is built the normal way, unless `--keep` has it; a million take ten minutes of
processor time and 5 GB.

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
from pathlib import Path

from moireid.designer import Order, design_badge, payload_from_hex
from moireid.idcodes import specimen_of
from moireid.registry import open_registry
from moireid_lab.bench.many_people import People
from moireid_lab.bench.part import OWN, Asked, Part, Row

BADGE = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_from_hex("7097c67b0fafc59b"))
#: What a claim may take, s.
MANY, RUNS, CLAIM_S = 100_000, 3, 5.0
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


def asked_of(program: str, *words: str) -> str:
    """What a new process prints."""
    return subprocess.run([sys.executable, "-c", program, *words], check=True, capture_output=True, text=True).stdout


def claims(folder: Path, count: int) -> Row:
    """Publish a bundle, and look a claim up by both."""
    url, path = built(folder, count), folder / f"people_{count}.bundle"
    begun = time.perf_counter()
    with open_registry(url, create=False) as registry:
        registry.publish(path, specimen_of, days=7, overwrite=True)
    row: Row = {"kind": f"{count:,} people", "publishing s": time.perf_counter() - begun}
    row |= {
        "bundle MB": path.stat().st_size / 1e6,
        "registry MB": (folder / f"people_{count}.sqlite3").stat().st_size / 1e6,
    }
    took = []
    # In turn, so that what else the machine does falls on both.
    for _ in range(RUNS):
        for look, source in ((ONLINE, url), (OFFLINE, str(path))):
            took.append(float(asked_of(CLAIM.format(look=look), source, f"Person {count - 1}")))
    row |= {"by registry s": statistics.median(took[::2]), "by bundle s": statistics.median(took[1::2])}
    late = sum(seconds > CLAIM_S for seconds in took)
    return row | {"answers": {"claim": (len(took) - late, 0, late)}}


def judged(count: int, folder: Path) -> Row:
    """Claims among so many."""
    os.environ |= {"MOIREID_KEYS": f"{folder}/keys", "MOIREID_SEEN": f"{folder}/seen.sqlite3"}
    return claims(folder, count)


def cases(asked: Asked) -> dict[str, int]:
    """One registry."""
    return {"claims": asked.clips or MANY}


QUESTIONS = {
    "claim": "Is a claimed badge found within 5 s from a cold start, among 100,000 people, by registry and by bundle?"
}
SOURCES = ("moireid.cli.main", "moireid.registry.bundle.held")
PART = Part(QUESTIONS, OWN, cases, judged, sources=SOURCES)
