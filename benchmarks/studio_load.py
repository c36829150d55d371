"""The studio under load: run `.venv/bin/python benchmarks/studio_load.py [--clips 15] [--hostile 1000]`.

Starts the studio by its command, asks it over HTTP on this machine, and prints

- what the API adds to the library's own time, on a film of 70 small frames of an enrolled badge: the answer's wall time
  less the time that the report itself states (`timing.total_s`: from opening the film to the verdict), and less that
  of a verify in this process, in turn with it, in wall and in processor time; both know the badge's law by then;
- whether 16 uploads at once are all answered;
- what hostile uploads (`benchmarks/hostile_files.py`) do: answers by status, memory of the server and of the process
  that others are forked from, and files left, before, meanwhile and after.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import psutil
from hostile_files import hostile, spoilt_from
from studio_server import StudioServer, served

from moireid.badge import load_badge
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

AT_ONCE, ASKERS, STEPS = 16, 4, 10


def upload(client: httpx.Client, film: bytes, **fields: str) -> httpx.Response:
    """One film, verified."""
    return client.post("/api/verify", files={"video": ("film.mp4", film)}, data=fields)


def processor_s(server: psutil.Process) -> float:
    """Processor time of the server and of all processes that it has had."""
    return sum(sum(process.cpu_times()[:4]) for process in (server, *server.children()))


def overhead(client: httpx.Client, studio: StudioServer, pairs: int) -> Iterator[Row]:
    """What the API adds, in pairs of one verify by the API and one by the library."""
    film, badge = studio.films / "long.mp4", load_badge(studio.films / "badge.json")
    content, claim = film.read_bytes(), {"claim": badge.name}
    verify(film, Claim(badge, badge.id))
    upload(client, content, **claim).raise_for_status()
    stated, in_process, cpu = [], [], []
    for _ in range(pairs):
        begun, cpu_s = time.perf_counter(), processor_s(studio.process)
        answer = upload(client, content, **claim)
        api_s = time.perf_counter() - begun
        stated.append(1000 * (api_s - answer.raise_for_status().json()["timing"]["total_s"]))
        # The forked process's time is counted only after the server has waited for it.
        time.sleep(0.1)
        cpu_s = processor_s(studio.process) - cpu_s
        begun, own_s = time.perf_counter(), time.process_time()
        verify(film, Claim(badge, badge.id))
        in_process.append(1000 * (api_s - (time.perf_counter() - begun)))
        cpu.append(1000 * (cpu_s - (time.process_time() - own_s)))
    for name, found in (
        ("the time that the report states", stated),
        ("a verify in this process", in_process),
        ("that, in processor time", cpu),
    ):
        low, middle, high = statistics.quantiles(found, n=4)
        yield {"API less": name, "median ms": middle, "quartile": low, "upper": high, "pairs": pairs}


def at_once(client: httpx.Client, studio: StudioServer) -> Row:
    """Many uploads at the same time."""
    text, content = (studio.films / "badge.json").read_text(), (studio.films / "long.mp4").read_bytes()
    begun = time.perf_counter()
    with ThreadPoolExecutor(AT_ONCE) as pool:
        answers = list(pool.map(lambda _: upload(client, content, badge=text), range(AT_ONCE)))
    counts = Counter(f"{answer.status_code} {answer.json().get('verdict')}" for answer in answers)
    return {"uploads at once": AT_ONCE, "s": time.perf_counter() - begun, "answers": _counted(counts)}


def _counted(counts: Counter[str]) -> list[str]:
    return [f"{number} x {name}" for name, number in sorted(counts.items())]


def memory_mb(server: psutil.Process) -> list[str]:
    """Resident memory of the server, and of the process of its own that others are forked from, and its helper."""
    return [f"{process.memory_info().rss / 1e6:.0f}" for process in (server, *server.children())]


def attacked(client: httpx.Client, studio: StudioServer, count: int) -> Iterator[Row]:
    """Hostile uploads, some at a time."""
    films, text = spoilt_from(studio.films), (studio.films / "badge.json").read_text()
    jobs, answered = studio.log.parent / "studio" / "jobs", Counter[str]()
    yield {"hostile uploads": 0, "memory, MB": memory_mb(studio.process), "files of jobs": len(list(jobs.rglob("*")))}
    with ThreadPoolExecutor(ASKERS) as pool:
        for step in range(STEPS):
            numbers = range(step * count // STEPS, (step + 1) * count // STEPS)
            for answer in pool.map(lambda number: upload(client, hostile(films, number), badge=text), numbers):
                body = answer.json()
                answered[f"{answer.status_code} {body.get('verdict') or body['code']}"] += 1
            left = len(list(jobs.rglob("*")))
            yield {"hostile uploads": numbers.stop, "memory, MB": memory_mb(studio.process), "files of jobs": left}
    yield {"health": client.get("/api/health").json()["status"], "answers": _counted(answered)}


def rows(wish: Wish) -> Iterator[Row]:
    """What the API adds, many uploads at once, hostile ones."""
    with tempfile.TemporaryDirectory() as scratch, served(Path(scratch), "--uploads-per-minute", "60000") as studio:
        bearer = {"Authorization": f"Bearer {studio.tokens[0]}"}
        with httpx.Client(base_url=studio.home, headers=bearer, timeout=600) as client:
            yield from overhead(client, studio, wish.clips or 15)
            yield at_once(client, studio)
            if wish.own.hostile:
                yield from attacked(client, studio, wish.own.hostile)


COLUMNS = {"API less": "<32", "median ms": ">9.0f", "quartile": ">8.0f", "upper": ">6.0f", "pairs": ">5"}
COLUMNS |= {
    "uploads at once": ">15",
    "s": ">6.1f",
    "hostile uploads": ">15",
    "memory, MB": "<20",
    "files of jobs": ">13",
}
COLUMNS |= {"health": "<6", "answers": "<1"}
BENCH = Bench(rows, COLUMNS, options={"--hostile": {"type": int, "default": 1000}})

if __name__ == "__main__":
    run_script(__file__)
