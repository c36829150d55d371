"""The studio under load: run `.venv/bin/python benchmarks/studio_load.py [--pairs 15] [--hostile 1000] [--film FILM]`.

Starts the studio by its command, asks it over HTTP on this machine, and prints

- what the API adds to the library's own time, on a film of 70 small frames of an enrolled badge: the answer's wall time
  less the time that the report itself states (`timing.total_s`: from opening the film to the verdict), and less that
  of a verify in this process, in turn with it, in wall and in processor time; both know the badge's law by then;
- whether 16 uploads at once are all answered;
- what hostile uploads (`benchmarks/hostile_files.py`) do: answers by status, memory of the server and of the process
  that others are forked from, and files left, before, meanwhile and after.

On a busy machine all wall times are longer, so the load average is printed with them.
"""

from __future__ import annotations

import argparse
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx
import psutil
from hostile_files import hostile, spoilt_from

from moireid.badge import load_badge
from moireid.registry import open_registry
from moireid.verifier import Claim, verify
from moireid_studio.auth.tokens import open_tokens

FILMS = Path(__file__).parents[1] / "tests" / "data" / "films"
AT_ONCE, ASKERS, STEPS = 16, 4, 10


@contextmanager
def served(folder: Path) -> Iterator[tuple[httpx.Client, psutil.Process]]:
    """A studio started by its command, in whose registry one badge is, a client with a token, and its process.

    Films of that badge lie in `folder/films`.
    """
    os.environ["MOIREID_KEYS"] = str(folder / "keys")
    url = f"sqlite:///{folder}/registry.sqlite3"
    (folder / "films").mkdir()
    spoilt_from(folder / "films")
    with open_registry(url, create=True) as registry:
        registry.enroll(load_badge(folder / "films" / "badge.json"))
    with open_tokens(folder / "studio") as tokens:
        secret, _ = tokens.create("verifier")
    code = "import sys; from moireid.cli.main import main; sys.argv[0] = 'moireid'; main()"
    command = [sys.executable, "-c", code, "serve", "--port", "0", "--registry", url, "--data", str(folder / "studio")]
    command += ["--uploads-per-minute", "60000"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        home = server.stderr.readline().split()[4]
        bearer = {"Authorization": f"Bearer {secret}"}
        with httpx.Client(base_url=home, headers=bearer, timeout=600) as client:
            yield client, psutil.Process(server.pid)
        server.send_signal(signal.SIGINT)
        server.wait(60)


def upload(client: httpx.Client, film: bytes, **fields: str) -> httpx.Response:
    """One film, verified."""
    return client.post("/api/verify", files={"video": ("film.mp4", film)}, data=fields)


def processor_s(server: psutil.Process) -> float:
    """Processor time of the server and of all processes that it has had."""
    return sum(sum(process.cpu_times()[:4]) for process in (server, *server.children()))


def overhead(client: httpx.Client, server: psutil.Process, films: Path, pairs: int) -> None:
    """What the API adds, in pairs of one verify by the API and one by the library."""
    film, badge = films / "long.mp4", load_badge(films / "badge.json")
    content, claim = film.read_bytes(), {"claim": badge.name}
    verify(film, Claim(badge, badge.id))
    upload(client, content, **claim).raise_for_status()
    stated, in_process, cpu = [], [], []
    for _ in range(pairs):
        begun, cpu_s = time.perf_counter(), processor_s(server)
        answer = upload(client, content, **claim)
        api_s = time.perf_counter() - begun
        stated.append(1000 * (api_s - answer.raise_for_status().json()["timing"]["total_s"]))
        # The forked process's time is counted only after the server has waited for it.
        time.sleep(0.1)
        cpu_s = processor_s(server) - cpu_s
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
        print(f"API less {name}: median {middle:.0f} ms, quartiles {low:.0f} to {high:.0f}, {pairs} pairs")


def at_once(client: httpx.Client, film: Path) -> None:
    """Many uploads at the same time."""
    text, content = (FILMS / "badge.json").read_text(), film.read_bytes()
    begun = time.perf_counter()
    with ThreadPoolExecutor(AT_ONCE) as pool:
        answers = list(pool.map(lambda _: upload(client, content, badge=text), range(AT_ONCE)))
    counts = Counter((answer.status_code, answer.json().get("verdict")) for answer in answers)
    print(f"{AT_ONCE} uploads at once in {time.perf_counter() - begun:.1f} s: {dict(counts)}")


def memory(server: psutil.Process) -> str:
    """Resident memory of the server, and of the process of its own that others are forked from, and its helper."""
    lasting = {"server": server}
    lasting |= {f"process {k + 1} of its own": child for k, child in enumerate(server.children())}
    return ", ".join(f"{name} {process.memory_info().rss / 1e6:.0f} MB" for name, process in lasting.items())


def attacked(client: httpx.Client, server: psutil.Process, folder: Path, count: int) -> None:
    """Hostile uploads, some at a time."""
    films, text = spoilt_from(folder / "films"), (folder / "films" / "badge.json").read_text()
    jobs, answered = folder / "studio" / "jobs", Counter[str]()
    print(f"before: {memory(server)}; {len(list(jobs.iterdir()))} folders of jobs")
    with ThreadPoolExecutor(ASKERS) as pool:
        for step in range(STEPS):
            numbers = range(step * count // STEPS, (step + 1) * count // STEPS)
            for answer in pool.map(lambda number: upload(client, hostile(films, number), badge=text), numbers):
                body = answer.json()
                answered[f"{answer.status_code} {body.get('verdict') or body['code']}"] += 1
            print(f"after {numbers.stop}: {memory(server)}", flush=True)
    print(f"answers: {', '.join(f'{name} {number}' for name, number in sorted(answered.items()))}")
    left = list(jobs.rglob("*"))
    print(f"after: {len(left)} files or folders of jobs; health {client.get('/api/health').json()['status']}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--hostile", type=int, default=1000)
    parser.add_argument("--film", type=Path, default=FILMS / "genuine_1.0m.mp4")
    given = parser.parse_args()
    print(f"{os.cpu_count()} processors, load average {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as scratch, served(Path(scratch)) as (client, server):
        if given.pairs > 1:
            overhead(client, server, Path(scratch) / "films", given.pairs)
            at_once(client, given.film)
        if given.hostile:
            attacked(client, server, Path(scratch), given.hostile)
    print(f"load average {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
