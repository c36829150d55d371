"""Claims and look-ups among many: `moireid lab bench registry`.

Registries of ten and of 100,000 (`--clips N`: of N) are built the normal way, unless `--keep` has them; a million take
ten minutes and 5 GB.  Badges are made by putting other ids, names and spacings into a designed
one, because designing takes longer than all else.

claim: what publishing a bundle of all people takes, its size, and the seconds from nothing to a claimed badge, in a new
process each, by the registry (as `verify --registry` does, its state and look-alikes included) and by the bundle (as
`verify --bundle`).  Imports are in it, as they are in what a user waits for.
identify: in turn, cold processes identify a film of 4 s, 1080p at 30 frames a second, of an enrolled badge, and of one
that is not enrolled: is it the right one, and no one; CPU seconds over those among ten people, and peak of memory.
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
from moireid_lab.bench.part import OWN, RIGHT, WRONG, Asked, Part, Row

SEED, FRAMES, FPS = 3, 120, 30.0
BADGE = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_from_hex("7097c67b0fafc59b"))
OTHER = design_badge(Order("Grace Hopper", lens="50lpi"), payload_from_hex("0123456789abcdef"))
FEW, MANY, RUNS = 10, 100_000, 3
#: Exit codes of `identify`: someone found, no one.  What a claim may take, s.
FOUND, NO_ONE, CLAIM_S = 0, 1, 5.0
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


def identified(folder: Path, count: int) -> Row:
    """Cold processes among few and among many."""
    program = str(Path(sys.executable).with_name("moireid"))
    row: Row = {"kind": f"{count:,} people"}
    counts = [0, 0, 0]
    for what, badge, exit_code in (("enrolled", BADGE, FOUND), ("not enrolled", OTHER, NO_ONE)):
        path, least = filmed(badge, folder), dict[int, float]()
        for people in (FEW, count):
            words = (program, "identify", str(path), "--registry", built(folder, people), "--json")
            runs = [[float(word) for word in asked_of(COLD, *words).split()] for _ in range(RUNS)]
            least[people] = min(cpu_s for _, cpu_s, _ in runs)
            row[f"{what}: MB among {people:,}"] = statistics.median(kilobytes / 1e3 for *_, kilobytes in runs)
            for exit_found, *_ in runs:
                answer = RIGHT if exit_found == exit_code else WRONG
                counts = [total + one for total, one in zip(counts, answer, strict=True)]
        row[f"{what}: CPU over that among {FEW}"] = least[count] / least[FEW]
    return row | {"answers": {"identify": counts}}


def judged(count: int, folder: Path) -> Row:
    """Both, as both are of one registry."""
    os.environ |= {"MOIREID_KEYS": f"{folder}/keys", "MOIREID_SEEN": f"{folder}/seen.sqlite3"}
    claim, identify = claims(folder, count), identified(folder, count)
    return claim | identify | {"answers": claim["answers"] | identify["answers"]}


def cases(asked: Asked) -> dict[str, int]:
    """One registry."""
    return {"claim and identify": asked.clips or MANY}


QUESTIONS = {
    "claim": "Is a claimed badge found within 5 s from a cold start, among 100,000 people, by registry and by bundle?",
    "identify": "Is the right one found among 100,000 people, and no one where the badge is not enrolled?",
}
SOURCES = ("moireid.cli.main", "moireid.registry.bundle.held")
PART = Part(QUESTIONS, OWN, cases, judged, sources=SOURCES)
