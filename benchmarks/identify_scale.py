"""One `moireid identify` among many people: run `.venv/bin/python benchmarks/identify_scale.py`, --full for a million.

Registries of ten and of many are built the normal way (`registry_scale.py`), unless they lie in `--folder`; a million
take ten minutes of processor time and 5 GB.  Then, in turn, cold processes identify a film of 4 s, 1080p at 30 frames a
second, of an enrolled badge, and of one that is not enrolled: CPU seconds, peak of memory, and their ratios to ten
people.  Last the three look-ups alone, in processes that have loaded all else: the layouts, an id, and the people whose
ids share a part with a broken reading.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from registry_scale import People, id_of
from verify_cost import BADGE, SEED, Kind, filmed

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.registry import open_registry
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene

OTHER = design_badge(Request("Grace Hopper"), payload_from_hex("0123456789abcdef"))
FEW, MANY, FULL, RUNS = 10, 100_000, 1_000_000, 3
#: A command of its own, with its CPU seconds and peak of memory, KB, as the system counts them.
COLD = """
import os, subprocess, sys
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, used = os.wait4(child.pid, 0)
print(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss)
"""


def built(folder: Path, count: int) -> str:
    """The URL of a registry of so many people and the holder of `BADGE`; built unless it is there."""
    path = folder / f"people_{count}.sqlite3"
    url = f"sqlite:///{path}"
    if not path.exists():
        with open_registry(url, create=True) as registry:
            registry.enroll_many(People(BADGE, count))
            registry.enroll(BADGE)
    return url


def filmed_other(folder: Path) -> Path:
    """A film of a badge of the same layout that is not enrolled there."""
    path, kind = folder / "other.mp4", Kind()
    if not path.exists():
        scene = Scene(OTHER, Build(), kind.camera())
        motion = motion_named("sway", distance_mm=1000.0, seed=SEED)
        film(scene, motion, path, frames=round(kind.fps * kind.length_s), fps=float(kind.fps), seed=SEED)
    return path


def cold(film: Path, url: str) -> tuple[int, float, float]:
    """Exit code, CPU seconds and peak of memory, MB, of one command."""
    program = str(Path(sys.executable).with_name("moireid"))
    asked = [sys.executable, "-c", COLD, program, "identify", str(film), "--registry", url, "--json"]
    code, cpu_s, kilobytes = subprocess.run(asked, check=True, capture_output=True, text=True).stdout.split()
    return int(code), float(cpu_s), int(kilobytes) / 1e3


@contextmanager
def print_time(label: str) -> Iterator[None]:
    """Print the milliseconds that the body takes, on the clock and of the processor."""
    wall, cpu = time.perf_counter(), time.process_time()
    yield
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"  {label:<40}{1e3 * wall:>10.1f}{1e3 * cpu:>10.1f}")


def look_ups(url: str) -> None:
    """What a reading asks a registry, each by itself."""
    with open_registry(url, create=False) as registry:
        registry.standing()
        with print_time("layouts"):
            registry.layouts()
        with print_time("an id"):
            registry.by_id(str(BADGE.id))
        with print_time("ids that share a part"):
            registry.ids_alike({place: id_of(7)[4 * place : 4 * place + 4] for place in range(4)})


def main() -> None:
    """Print what identification takes among few and among many."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--full", action="store_true", help=f"{FULL:,} people in place of {MANY:,}")
    parser.add_argument("--folder", type=Path, help="keep registries and film here, and use those that lie here")
    given = parser.parse_args()
    many = FULL if given.full else MANY
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        os.environ["MOIREID_KEYS"] = str(folder / "keys")
        urls = {count: built(folder, count) for count in (FEW, many)}
        films = {"enrolled": filmed(Kind(), folder), "not enrolled": filmed_other(folder)}
        print(f"{'':<34}{'exit':>6}{'CPU s':>8}{'MB':>8}{'CPU ratio':>11}")
        for what, film_path in films.items():
            runs: dict[int, list[tuple[int, float, float]]] = {count: [] for count in urls}
            for _ in range(RUNS):
                for count, url in urls.items():
                    runs[count].append(cold(film_path, url))
            least = {count: min(cpu for _, cpu, _ in own) for count, own in runs.items()}
            for count, own in runs.items():
                words = f"{count:,} people, badge {what}"
                peak, ratio = statistics.median(mb for _, _, mb in own), least[count] / least[FEW]
                print(f"{words:<34}{own[0][0]:>6}{least[count]:>8.2f}{peak:>8.0f}{ratio:>11.2f}", flush=True)
        print(f"{'look-ups, ms':<42}{'clock':>10}{'CPU':>10}")
        for count, url in urls.items():
            print(f"{count:,} people")
            look_ups(url)


if __name__ == "__main__":
    main()
