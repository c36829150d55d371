"""Two workers against one, and workers that are killed: run `.venv/bin/python benchmarks/archive_scaling.py`.

films: short clips, 60 frames cut from the films in tests/data/films without coding them again, each listed under
    so many names; scored by `evaluation.collect` with our pipeline, as `moireid evaluate --pipeline moireid` does.
ratio: films a second of two workers over those of one, from the first row to the last, cluster start apart; with it
    figures that other work on the machine hardly changes: CPU seconds for a film, and the mean number of workers that
    were scoring, from the first film to the last row.  The difference of this number to 1 or 2 is the engine's time
    between films.  On free processors, two workers with the same CPU seconds for a film are faster by this number.
plain: the same films by as many plain processes, without the engine: what this machine gives two at once, whatever the
    engine does; processors that share a core or a cache are not twice as fast as one.
kills: while two workers score, one is killed (SIGKILL) at random moments; rows lost, and films begun more than once.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import av
import cv2
import psutil

from moireid.sandbox.process import ONE_THREAD
from moireid_lab.evaluation.collect import ScoredFilm, collect
from moireid_lab.evaluation.film_rows import Job, Row, score_film
from moireid_lab.evaluation.manifest import read_manifest

FRAMES = 60
FILMS = Path(__file__).parent.parent / "tests" / "data" / "films"
CLIPS = {
    "genuine_1.0m.mp4": "genuine",
    "genuine_2.0m.mp4": "genuine",
    "forged_drift_1.0m.mp4": "forged:drift",
    "forged_gain_low_1.0m.mp4": "forged:gain_low",
    "forged_reversed_1.0m.mp4": "forged:reversed",
}
#: Where processes that score note each film that they begin; the environment reaches them all.
NOTES = "ARCHIVE_SCALING_NOTES"


def noted(job: Job, film: str) -> Row:
    """Score a film, and note that it was begun."""
    _note(f"{job.entry.name} {os.getppid()} {time.time()}")
    return score_film(job, film)


def _note(words: str) -> None:
    handle = os.open(os.environ[NOTES], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(handle, f"{words}\n".encode())
    os.close(handle)


def collection(folder: Path, films: int) -> Path:
    """A manifest of this many films, made from the clips in turn; each film has its own few bytes at its end."""
    lines = ["video,label,claim,group"]
    clips = {name: cut(FILMS / name, folder / "clip.mp4").read_bytes() for name in CLIPS}
    (folder / "clip.mp4").unlink()
    for k in range(films):
        name = list(CLIPS)[k % len(CLIPS)]
        # A box of the kind `free`, which players pass over.
        (folder / f"{k:03d}.mp4").write_bytes(clips[name] + (12).to_bytes(4, "big") + b"free" + k.to_bytes(4, "big"))
        lines.append(f"{k:03d}.mp4,{CLIPS[name]},{FILMS / 'badge.json'},")
    (folder / "films.csv").write_text("\n".join(lines), encoding="utf-8")
    return folder / "films.csv"


def cut(source: Path, target: Path) -> Path:
    """The beginning of a film, its pictures as they are coded."""
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        stream = made.add_stream_from_template(given.streams.video[0])
        for packet, _ in zip(given.demux(video=0), range(FRAMES), strict=False):
            packet.stream = stream
            made.mux(packet)
    return target


def scored(manifest: Path, folder: Path, workers: int | None, scheduler: str | None) -> dict[str, Any]:
    """Score a collection; seconds and CPU seconds of all processes, from the first row to the last and in all."""
    # Other processes know this file by its name alone.
    from archive_scaling import noted

    os.environ[NOTES] = str(folder / f"begun-{workers}")
    ends: list[float] = []
    begun, used = time.time(), Used()
    rows = collect(
        read_manifest(manifest).entries,
        ("moireid",),
        kept=folder / f"results-{workers}",
        workers=workers,
        scheduler=scheduler,
        progress=lambda *_: ends.append(time.time()),
        work=noted,
    )
    total = time.time() - begun
    first = float(Path(os.environ[NOTES]).read_text().split()[2])
    return {
        "workers": workers,
        "rows": rows,
        "total_s": total,
        "cpu_s": used.seconds(),
        "rate": (len(ends) - 1) / (ends[-1] - ends[0]),
        "start_s": ends[0] - begun,
        "busy": sum(one.row["seconds"] for one in rows) / (ends[-1] - first),
    }


def plain_rate(manifest: Path, processes: int) -> float:
    """Films a second of processes that score every so-maniest film, each after a first one that does not count."""
    command = [sys.executable, "-c", "import archive_scaling; archive_scaling.plain()", str(manifest)]
    shares = [
        subprocess.Popen([*command, str(k), str(processes)], stdout=subprocess.PIPE, text=True)
        for k in range(processes)
    ]
    return sum(float(share.communicate()[0]) for share in shares)


def plain() -> None:
    """Print films a second of one share of a manifest: arguments path, which, of how many."""
    cv2.setNumThreads(1)
    manifest, share, of = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    jobs = [Job(entry, "moireid") for entry in read_manifest(manifest).entries[share::of]]
    score_film(jobs[0], jobs[0].entry.video)
    begun = time.perf_counter()
    for job in jobs:
        score_film(job, job.entry.video)
    print(len(jobs) / (time.perf_counter() - begun))


class Used:
    """CPU seconds of this process and all that it started, looked at four times a second as they come and go."""

    def __init__(self) -> None:
        self._found: dict[tuple[int, float], float] = {}
        self._stop = threading.Event()
        self._before = self._look()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def seconds(self) -> float:
        """Since this was made; ends the watch."""
        self._stop.set()
        self._thread.join()
        return sum(self._found.values()) - self._before

    def _watch(self) -> None:
        while not self._stop.wait(0.25):
            self._look()

    def _look(self) -> float:
        own = psutil.Process()
        for process in (own, *own.children(recursive=True)):
            with suppress(psutil.Error):
                times = process.cpu_times()
                self._found[process.pid, process.create_time()] = times.user + times.system
        return sum(self._found.values())


def killing(log: Path, kills: list[str], stop: threading.Event, most: int) -> None:
    """Kill the worker that began a film last, at random moments."""
    rng = random.Random(7)
    while not stop.wait(rng.uniform(1, 12)) and len(kills) < most:
        # A process that outlived its worker for a moment names another parent, which is none of ours.
        ours = {process.pid for process in psutil.Process().children(recursive=True)}
        if log.exists() and (lines := log.read_text().split()) and int(lines[-2]) in ours:
            with suppress(ProcessLookupError):
                os.kill(int(lines[-2]), signal.SIGKILL)
                kills.append(lines[-3])


def same(one: list[ScoredFilm], other: list[ScoredFilm]) -> bool:
    """Whether two runs give the same figures of every film."""
    left = ("seconds", "worker")
    return all(
        {name: value for name, value in a.row.items() if name not in left}
        == {name: value for name, value in b.row.items() if name not in left}
        for a, b in zip(one, other, strict=True)
    )


def main() -> None:
    """Print the figures."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--films", type=int, default=200)
    asked.add_argument("--kills", type=int, default=8)
    asked.add_argument("--rounds", type=int, default=2, help="one worker and two by turns, so many times")
    given = asked.parse_args()
    os.environ |= ONE_THREAD | {"PYTHONPATH": str(Path(__file__).parent)}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        manifest = collection(folder, given.films)
        print(f"{given.films} clips of {FRAMES} frames; processors: {os.cpu_count()}, load {os.getloadavg()[0]:.1f}")
        rounds = []
        for count in range(given.rounds):
            (folder / f"round-{count}").mkdir()
            runs = {workers: scored(manifest, folder / f"round-{count}", workers, "local") for workers in (1, 2)}
            rounds.append(runs[2]["rate"] / runs[1]["rate"])
            for workers, run in runs.items():
                print(
                    f"workers: {workers}, {run['rate']:.2f} films/s, first row after {run['start_s']:.1f} s, "
                    f"{run['total_s']:.1f} s in all, {run['cpu_s'] / given.films:.3f} CPU s a film, "
                    f"{run['cpu_s'] / run['total_s']:.2f} processors used, {run['busy']:.3f} workers scoring"
                )
            print(
                f"two against one: {rounds[-1]:.2f} times as fast, "
                f"{runs[2]['busy'] / runs[1]['busy']:.2f} times as many scoring, "
                f"CPU a film {runs[2]['cpu_s'] / runs[1]['cpu_s']:.3f} times, same rows: "
                f"{same(runs[1]['rows'], runs[2]['rows'])}; load {os.getloadavg()[0]:.1f}",
                flush=True,
            )
            plain_rates = [plain_rate(manifest, processes) for processes in (1, 2)]
            print(
                f"plain processes: {plain_rates[0]:.2f} and {plain_rates[1]:.2f} films/s, two against one "
                f"{plain_rates[1] / plain_rates[0]:.2f} times as fast; two workers against two plain processes "
                f"{runs[2]['rate'] / plain_rates[1]:.2f}",
                flush=True,
            )
        print(f"two against one, mean of {given.rounds} rounds: {sum(rounds) / len(rounds):.2f} times as fast")
        kills, stop = list[str](), threading.Event()
        (folder / "killed").mkdir()
        log = folder / "killed" / "begun-2"
        killer = threading.Thread(target=killing, args=(log, kills, stop, given.kills))
        killer.start()
        found = scored(manifest, folder / "killed", 2, "local")["rows"]
        stop.set()
        killer.join()
        begun = log.read_text().split()[::3]
        again = {name: begun.count(name) - 1 for name in set(begun) if begun.count(name) > 1}
        print(
            f"{len(kills)} workers killed: {given.films - len(found)} rows lost, "
            f"{sum(one.row['verdict'] == 'failed' for one in found)} failed, {sum(again.values())} films begun again, "
            f"{len(set(again) - set(kills))} of them not those of a killed worker; same rows: "
            f"{same(runs[1]['rows'], found)}"
        )


if __name__ == "__main__":
    sys.exit(main())
