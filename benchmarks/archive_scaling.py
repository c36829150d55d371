"""Two workers against one, and workers that are killed: run `.venv/bin/python benchmarks/archive_scaling.py`.

films: short clips, 60 frames cut from the films in tests/data/films without coding them again, each listed under
    so many names; scored by `evaluation.collect` with our pipeline, as `moireid evaluate --pipeline moireid` does.
ratio: films a second of two workers over those of one, from the first row to the last, cluster start apart; with it
    the mean number of workers that were scoring, from the first film to the last row.  The difference of this number
    to 1 or 2 is the engine's time between films.
kills: while two workers score, one is killed (SIGKILL) at random moments; rows lost, and films begun more than once.
"""

from __future__ import annotations

import os
import random
import signal
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import av
import psutil

from moireid.sandbox.process import ONE_THREAD
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script
from moireid_lab.evaluation.collect import ScoredFilm, collect
from moireid_lab.evaluation.film_rows import Job, score_film
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


def scored(manifest: Path, folder: Path, workers: int) -> Row:
    """Score a collection; films a second, seconds to the first row and in all, and how many workers were scoring."""
    folder.mkdir(exist_ok=True)
    os.environ[NOTES] = str(folder / f"begun-{workers}")
    ends: list[float] = []
    begun = time.time()
    rows = collect(
        read_manifest(manifest).entries,
        ("moireid",),
        kept=folder / f"results-{workers}",
        workers=workers,
        scheduler="local",
        progress=lambda *_: ends.append(time.time()),
        work=noted,
    )
    total = time.time() - begun
    first = float(Path(os.environ[NOTES]).read_text().split()[2])
    return {
        "workers": workers,
        "rows": rows,
        "total_s": total,
        "rate": (len(ends) - 1) / (ends[-1] - ends[0]),
        "start_s": ends[0] - begun,
        "busy": sum(one.row["seconds"] for one in rows) / (ends[-1] - first),
    }


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


def rows(wish: Wish) -> Iterator[Row]:
    """One and two workers by turns, then a run whose workers are killed."""
    films, rounds = wish.clips or (20 if wish.quick else 200), 1 if wish.quick else 2
    os.environ |= ONE_THREAD
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        manifest, plain = collection(folder, films), list[ScoredFilm]()
        for count in range(rounds):
            one, two = (scored(manifest, folder / f"round-{count}", workers) for workers in (1, 2))
            plain = two["rows"]
            for run in (one, two):
                found = {"times as fast": run["rate"] / one["rate"], "same rows": same(one["rows"], run["rows"])}
                yield {name: value for name, value in run.items() if name != "rows"} | found
        kills, stop, log = list[str](), threading.Event(), folder / "killed" / "begun-2"
        killer = threading.Thread(target=killing, args=(log, kills, stop, wish.own.kills))
        killer.start()
        found = scored(manifest, folder / "killed", 2)["rows"]
        stop.set()
        killer.join()
        begun = log.read_text().split()[::3]
        again = {name: begun.count(name) - 1 for name in set(begun) if begun.count(name) > 1}
        yield {
            "workers killed": len(kills),
            "rows lost": films - len(found),
            "failed": sum(one.row["verdict"] == "failed" for one in found),
            "begun again": sum(again.values()),
            "of no killed one": len(set(again) - set(kills)),
            "same rows": same(plain, found),
        }


COLUMNS = {"workers": ">7", "films/s": "rate >7.2f", "first row s": "start_s >11.1f", "all s": "total_s >7.1f"}
COLUMNS |= {"scoring": "busy >7.3f", "times as fast": ">13.2f", "workers killed": ">14", "rows lost": ">9"}
COLUMNS |= {"failed": ">6", "begun again": ">11", "of no killed one": ">16", "same rows": ">9"}
BENCH = Bench(rows, COLUMNS, options={"--kills": {"type": int, "default": 8}})

if __name__ == "__main__":
    run_script(__file__)
