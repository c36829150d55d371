"""Claims and look-ups among many: `moireid lab bench registry [--only claim|identify]`.

Registries of ten and of 100,000 (`--full`: a million) are built the normal way, unless they lie in `--keep`; a million
take ten minutes of processor time and 5 GB.  Badges are made by putting other ids, names and spacings into a designed
one, because designing takes longer than all else.

claim: what publishing a bundle of all people takes, its size, and the seconds from nothing to a claimed badge, in a new
process each, by the registry (as `verify --registry` does, its state and look-alikes included) and by the bundle (as
`verify --bundle`).  Imports are in it, as they are in what a user waits for.
identify: in turn, cold processes identify a film of 4 s, 1080p at 30 frames a second, of an enrolled badge, and of one
that is not enrolled: CPU seconds, peak of memory, and their ratios to ten people.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

from moireid.badge import Badge
from moireid.designer import Order, design_badge, payload_from_hex
from moireid.idcodes import specimen_of
from moireid.registry import open_registry
from moireid.simulate.cameras import camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene
from moireid_lab.bench.bench_frame import Bench, Row, Wish

SEED, FRAMES, FPS = 3, 120, 30.0
BADGE = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_from_hex("7097c67b0fafc59b"))
OTHER = design_badge(Order("Grace Hopper", lens="50lpi"), payload_from_hex("0123456789abcdef"))
FEW, QUICK, MANY, FULL = 10, 1_000, 100_000, 1_000_000
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
#: A command of its own, with its CPU seconds and peak of memory, KB, as the system counts them.
COLD = """
import os, subprocess, sys
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, used = os.wait4(child.pid, 0)
print(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss)
"""


class People:
    """Badges of one layout, each with its own id, name and spacings."""

    def __init__(self, first: Badge, count: int) -> None:
        self._first, self._count = first, count

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Badge]:
        grating = self._first.gratings[0]
        for number in range(self._count):
            digest = sha256(f"person {number}".encode()).digest()
            stretch = [1.0 + 0.01 * byte / 255 for byte in digest]
            cells = tuple(replace(c, pitch_mm=c.pitch_mm * stretch[k % 32]) for k, c in enumerate(grating.cells))
            gratings = (replace(grating, cells=cells),)
            yield replace(self._first, id=digest.hex()[:16], name=f"Person {number}", gratings=gratings)


def built(folder: Path, count: int) -> str:
    """The URL of a registry of so many people and the holder of `BADGE`; built unless it is there."""
    path = folder / f"people_{count}.sqlite3"
    url = f"sqlite:///{path}"
    if not path.exists():
        with open_registry(url, create=True) as registry:
            registry.enroll_many(People(BADGE, count))
            registry.enroll(BADGE)
    return url


def filmed(badge: Badge, folder: Path) -> Path:
    """A film of the badge that is enrolled there, or of one of the same layout that is not."""
    path = folder / f"{badge.id}.mp4"
    if not path.exists():
        scene, motion = Scene(badge, Build(), camera_named("phone")), motion_named("sway", distance_mm=1e3, seed=SEED)
        film(scene, motion, path, frames=FRAMES, fps=FPS, seed=SEED)
    return path


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


def identify_rows(folder: Path, counts: tuple[int, int], runs: int) -> Iterator[Row]:
    """Cold processes among few and among many."""
    urls, program = {count: built(folder, count) for count in counts}, str(Path(sys.executable).with_name("moireid"))
    for what, path in (("enrolled", filmed(BADGE, folder)), ("not enrolled", filmed(OTHER, folder))):
        found: dict[int, list[list[str]]] = {count: [] for count in counts}
        for _ in range(runs):
            for count, url in urls.items():
                found[count].append(asked(COLD, program, "identify", str(path), "--registry", url, "--json").split())
        least = {count: min(float(cpu) for _, cpu, _ in own) for count, own in found.items()}
        for count, own in found.items():
            yield {
                "identify among": count,
                "badge": what,
                "exit": int(own[0][0]),
                "CPU s": least[count],
                "MB": statistics.median(int(kilobytes) / 1e3 for _, _, kilobytes in own),
                "CPU ratio": least[count] / least[counts[0]],
            }


def rows(wish: Wish) -> Iterator[Row]:
    """The rows of the parts that are wanted."""
    many = FULL if wish.own.full else QUICK if wish.quick else MANY
    with wish.kept_folder() as folder:
        os.environ |= {"MOIREID_KEYS": f"{folder}/keys", "MOIREID_SEEN": f"{folder}/seen.sqlite3"}
        parts = {
            "claim": lambda: claim_rows(folder, many, wish.clips or 9),
            "identify": lambda: identify_rows(folder, (FEW, many), wish.clips or 3),
        }
        for name in wish.chosen(parts):
            yield from parts[name]()


COLUMNS = {"people": ">9,", "publishing s": ">12.0f", "bundle MB": ">9.1f", "registry MB": ">11.1f"}
COLUMNS |= {"to a claimed badge": "<18", "median s": ">8.3f", "least": ">8.3f", "most": ">8.3f"}
COLUMNS |= {
    "identify among": ">14,",
    "badge": "<12",
    "exit": ">4",
    "CPU s": ">7.2f",
    "MB": ">7.0f",
    "CPU ratio": ">9.2f",
}
BENCH = Bench(
    rows, COLUMNS, options={"--full": {"action": "store_true", "help": f"{FULL:,} people in place of {MANY:,}"}}
)
