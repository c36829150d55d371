"""A bundle of many people: run `.venv/bin/python benchmarks/bundle_scale.py`, with --full for 100,000.

Prints what publishing takes, the file's size, and the time from nothing to a claimed badge: in a new process each, by
the registry (as `verify --registry` does, its state and look-alikes included) and by the bundle (as `verify --bundle`).
Imports are in it, as they are in what a user waits for.  What follows, the judging of the film, is the same for both;
with --film FILE whole verifications of that film are timed as well, a registry's and a bundle's in turn.
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

from moireid.badge import Badge, load_badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.idcodes import specimen_of
from moireid.registry import open_registry

RUNS = 9
CLAIM = """
import sys, time
begun = time.perf_counter()
{look}
print(time.perf_counter() - begun)
"""
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


def people(first: Badge, count: int) -> Iterator[Badge]:
    """The first badge as it is, and copies of it under other names and ids."""
    yield first
    for number in range(1, count):
        badge_id = sha256(f"person {number}".encode()).hexdigest()[:16]
        yield replace(first, id=badge_id, name=f"Person {number}")


def looked_up(look: str, source: str, claim: str) -> float:
    """Seconds that a new process takes from its first import to the badge of a claim."""
    program = CLAIM.format(look=look.strip())
    done = subprocess.run([sys.executable, "-c", program, source, claim], check=True, capture_output=True, text=True)
    return float(done.stdout)


def verified(film: Path, claim: str, *source: str) -> float:
    """Seconds of a whole `moireid verify` of a film."""
    begun = time.perf_counter()
    program = "from moireid.cli.main import main; main()"
    command = [sys.executable, "-c", program, "verify", str(film), "--claim", claim, *source, "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert json.loads(done.stdout)["verdict"] == "accept", done.stderr
    return time.perf_counter() - begun


def line(label: str, online: list[float], offline: list[float]) -> None:
    """Medians and ranges of both, and the difference of the medians."""
    cells = [f"{statistics.median(one):.3f} ({min(one):.3f}-{max(one):.3f})" for one in (online, offline)]
    more = statistics.median(offline) - statistics.median(online)
    print(f"{label:<28}{cells[0]:>26}{cells[1]:>26}{more:>+14.3f}", flush=True)


def main() -> None:
    """Print what a bundle takes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="100,000 people instead of 10,000")
    parser.add_argument("--film", type=Path, help="a film of the badge that --badge names")
    parser.add_argument("--badge", type=Path, help="its badge.json")
    given = parser.parse_args()
    count = 100_000 if given.full else 10_000
    ada = load_badge(given.badge) if given.badge else None
    ada = ada or design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}\n")
    with tempfile.TemporaryDirectory() as folder:
        os.environ |= {"MOIREID_KEYS": f"{folder}/keys", "MOIREID_SEEN": f"{folder}/seen.sqlite3"}
        url, path = f"sqlite:///{folder}/people.sqlite3", Path(folder) / "people.bundle"
        with open_registry(url, create=True) as registry:
            registry.enroll_many(people(ada, count))
            begun = time.perf_counter()
            registry.publish(path, specimen_of, days=7)
            took_s = time.perf_counter() - begun
            sizes_mb = [one.stat().st_size / 1e6 for one in (path, Path(folder) / "people.sqlite3")]
            print(f"publishing {count:,} people: {took_s:.0f} s; {sizes_mb[0]:.1f} MB, registry {sizes_mb[1]:.1f} MB")
            last = f"Person {count - 1}"
        print(f"\n{'seconds: median (least-most)':<28}{'registry':>26}{'bundle':>26}{'bundle more':>14}")
        # In turn, so that what else the machine does falls on both.
        pairs = [(looked_up(ONLINE, url, last), looked_up(OFFLINE, str(path), last)) for _ in range(RUNS)]
        line("to a claimed badge", *map(list, zip(*pairs, strict=True)))
        if given.film:
            sources = (("--registry", url), ("--bundle", str(path)))
            films = [[verified(given.film, ada.name, *source) for source in sources] for _ in range(RUNS)]
            line("whole verification", *map(list, zip(*films, strict=True)))


if __name__ == "__main__":
    main()
