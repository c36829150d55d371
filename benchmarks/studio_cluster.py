"""Studios, workers and PostgreSQL by the compose file: `.venv/bin/python benchmarks/studio_cluster.py`.

Starts each service of `deploy/compose.yaml` by its own command, as processes of this machine: a host's name becomes
loopback, a volume a folder, and a process that ends is started again, as the file says.  PostgreSQL alone is started by
its own programs, as its command is in its image; and there is no proxy: films are sent to the studios by turns, and
again where none answers.

Sends films, each with bytes of its own at its end, and kills a studio and both workers meanwhile, with all that they
had started, and stops PostgreSQL for `--away` seconds (10); prints what became of each film, how often the record
has it, and what the studios' probes answered while the database was away.  `--no-kills` kills none:

    .venv/bin/python benchmarks/studio_cluster.py --no-kills --away 60     200 uploads, a minute without PostgreSQL
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import yaml
from sqlalchemy import create_engine, text

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from kit.registries import badge_of, running_server  # noqa: E402
from kit.webbing import tiny_film  # noqa: E402
from moireid.registry import open_registry  # noqa: E402
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script  # noqa: E402
from moireid_studio.auth.tokens import open_tokens  # noqa: E402

FILMS = ROOT / "tests" / "data" / "films"
SERVICES = yaml.safe_load((ROOT / "deploy" / "compose.yaml").read_text(encoding="utf-8"))["services"]
DATABASE = "postgresql+psycopg://moireid@database/moireid"
ASKERS, AGAIN_S, AWAY_S = 8, 1.0, 10.0
#: Time between two questions to the probes of a studio, s.
PROBE_S = 0.5

#: States of a job that is over.
ENDED = ("done", "failed", "lost")


class Cluster:
    """The services of the compose file, as processes."""

    def __init__(self, folder: Path, database: str, storage: str, workers: int) -> None:
        self.folder, self.database, self.storage = folder, database, storage
        self.ports = [_free_port(), _free_port()]
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self._wanted: dict[str, tuple[str, int]] = {f"worker {k}": ("worker", k) for k in range(workers)}
        self._wanted |= {f"studio {k}": ("studio", k) for k in range(2)}
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._supervise)

    def command(self, service: str, number: int) -> list[str]:
        """A service's own command with this machine's places."""
        data = self.folder / "data" / f"{service}{number}"
        data.mkdir(parents=True, exist_ok=True)
        places = {
            DATABASE: self.database,
            "${STORAGE:-file:///films}": self.storage,
            "--host=0.0.0.0": "--host=127.0.0.1",
            "--port=8000": f"--port={self.ports[number % len(self.ports)]}",
            "=/data": f"={data}",
        }
        words = []
        for word in SERVICES[service]["command"]:
            for there, here in places.items():
                word = word.replace(there, here)
            # What the file leaves to the environment is as it is without one.
            words.append(re.sub(r"\$\{\w+:-([^}]*)\}", r"\1", word))
        program = Path(sys.executable).parent / words[0]
        # Programs of an environment that was moved or has no script find themselves by its Python.
        return [str(program), *words[1:]]

    def start(self, name: str) -> None:
        """Start a service, with a log of its own."""
        with (self.folder / f"{name}.log").open("ab") as log:
            self.processes[name] = subprocess.Popen(
                self.command(*self._wanted[name]), stdout=log, stderr=log, start_new_session=True
            )

    def kill(self, name: str) -> None:
        """Kill a service with all that it started, as a container is."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.processes[name].pid, signal.SIGKILL)

    def _supervise(self) -> None:
        while not self._ending.wait(AGAIN_S):
            for name, process in list(self.processes.items()):
                if process.poll() is not None and SERVICES[self._wanted[name][0]]["restart"] == "unless-stopped":
                    self.kill(name)
                    self.start(name)

    def __enter__(self) -> Cluster:
        for name in self._wanted:
            self.start(name)
        self._thread.start()
        try:
            for port in self.ports:
                _until(lambda port=port: _ready(port), 120)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()
        for name, process in self.processes.items():
            process.send_signal(signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(20)
            self.kill(name)
            process.wait()


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def _ready(port: int) -> bool:
    try:
        state = httpx.get(f"http://127.0.0.1:{port}/readyz", timeout=10).json()
    except httpx.HTTPError:
        return False
    return bool(state["ready"])


def _until(holds: Any, seconds: float) -> None:
    last = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > last:
            raise SystemExit(f"not there after {seconds} s")
        time.sleep(0.2)


class Visitor:
    """A client that sends films: to one studio after the other, and again if none answers."""

    def __init__(self, ports: Sequence[int], tokens: Sequence[str], film: bytes, claim: str) -> None:
        self._homes = [f"http://127.0.0.1:{port}" for port in ports]
        self._client = httpx.Client(timeout=60)
        # Several, as one may hold half of the places.
        self._bearers = [{"Authorization": f"Bearer {token}"} for token in tokens]
        self._of: dict[str, dict[str, str]] = {}
        self._film, self._claim, self.sent_again = film, claim, 0
        #: Answers to uploads, by status.
        self.answers = Counter[int]()

    def upload(self, number: int) -> str:
        """The id of the job of a film, which ends in an empty box with its number."""
        film = self._film + (12).to_bytes(4) + b"free" + number.to_bytes(4)
        turns = self._turns(number)
        while True:
            home = next(turns)
            try:
                form = {"files": {"video": ("film.mp4", film)}, "data": {"claim": self._claim}}
                bearer = self._bearers[number % len(self._bearers)]
                answer = self._client.post(f"{home}/api/jobs", headers=bearer, **form)
            except httpx.HTTPError:
                # It may have arrived, though no answer came.
                self.sent_again += 1
                continue
            self.answers[answer.status_code] += 1
            if answer.status_code == 202:
                job_id = str(answer.json()["id"])
                self._of[job_id] = bearer
                return job_id
            time.sleep(AGAIN_S)
            if answer.status_code not in (429, 502, 503):
                raise SystemExit(f"{answer.status_code} {answer.text}")

    def look(self, job_id: str) -> dict[str, Any]:
        """A job, as a studio has it."""
        turns = self._turns(0)
        while True:
            home = next(turns)
            with contextlib.suppress(httpx.HTTPError, ValueError):
                answer = self._client.get(f"{home}/api/jobs/{job_id}", headers=self._of[job_id])
                if answer.status_code in (200, 404):
                    return dict(answer.json())

    def _turns(self, number: int) -> Iterator[str]:
        while True:
            yield self._homes[number % len(self._homes)]
            number += 1
            time.sleep(0.2)

    def all_over(self, ids: Sequence[str]) -> dict[str, dict[str, Any]]:
        """Every job's end."""
        ended: dict[str, dict[str, Any]] = {}
        while len(ended) < len(ids):
            for job_id in ids:
                if job_id not in ended and (job := self.look(job_id)).get("state", "lost") in ENDED:
                    ended[job_id] = job
            time.sleep(0.5)
        return ended


def record(database: str) -> list[Any]:
    """The record of verdicts: film and job of each."""
    engine = create_engine(database)
    try:
        with engine.connect() as connection:
            return list(connection.execute(text("SELECT film_sha256, job FROM verdicts")))
    finally:
        engine.dispose()


class Probes:
    """Asks `/healthz` and `/readyz` of each studio again and again; as a context, while it lasts."""

    def __init__(self, ports: Sequence[int]) -> None:
        self._homes = [f"http://127.0.0.1:{port}" for port in ports]
        self.health, self.missing, self.longest_s = Counter[int](), Counter[str](), 0.0
        self._ending, self._threads = threading.Event(), list[threading.Thread]()

    def _ask(self, home: str) -> None:
        with httpx.Client(base_url=home, timeout=30) as client:
            while not self._ending.wait(PROBE_S):
                begun = time.monotonic()
                try:
                    self.health[client.get("/healthz").status_code] += 1
                    self.longest_s = max(self.longest_s, time.monotonic() - begun)
                    needs = client.get("/readyz").json()["needs"]
                except httpx.HTTPError:
                    self.health[0] += 1
                    continue
                self.missing[" and ".join(name for name, there in needs.items() if not there) or "nothing"] += 1

    def __enter__(self) -> Probes:
        self._threads = [threading.Thread(target=self._ask, args=(home,)) for home in self._homes]
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        for thread in self._threads:
            thread.join()


def sent_through(
    cluster: Cluster, visitor: Visitor, count: int, kills: dict[int, str], away: Callable[[], Probes]
) -> dict[str, Any]:
    """Send films, and after so many of them kill what is named, or let the database go `away`; what became of them."""
    begun, lock, sent, down = time.monotonic(), threading.Lock(), Counter[str](), []
    probes: list[Future[Probes]] = []

    def upload(number: int) -> str:
        job_id = visitor.upload(number)
        with lock:
            sent["films"] += 1
            if name := kills.pop(sent["films"], None):
                if name == "database":
                    probes.append(aside.submit(away))
                else:
                    cluster.kill(name)
                down.append(f"{name} after {sent['films']} uploads")
        return job_id

    with ThreadPoolExecutor(ASKERS) as pool, ThreadPoolExecutor(1) as aside:
        ids = list(pool.map(upload, range(count)))
    ended = visitor.all_over(ids)
    seconds = time.monotonic() - begun
    found, probed = record(cluster.database), probes[0].result()
    by_job, by_film = Counter(row.job for row in found), Counter(row.film_sha256 for row in found)
    often = Counter(min(by_job[one], 2) for one in ids)
    return {
        "killed": ", ".join(down),
        "uploads over after, s": f"{count} after {seconds:.0f}",
        "answers to uploads": dict(visitor.answers),
        "healthz while the database was away": dict(probed.health),
        "its longest answer, s": f"{probed.longest_s:.2f}",
        "missing, by readyz": dict(probed.missing),
        "states": dict(Counter(job.get("state", "lost") for job in ended.values())),
        "problems": dict(Counter(str((job.get("problem") or {}).get("code")) for job in ended.values())),
        "in the record": f"{often[1]} of {count} jobs once, {often[2]} more than once, {often[0]} never",
        "films in the record": f"{len(by_film)}, {sum(many > 1 for many in by_film.values())} twice",
        "sent again for want of an answer": visitor.sent_again,
    }


@contextmanager
def signing(folder: Path) -> Iterator[None]:
    """The signer of the compose file, which alone has the keys; the group is this user's, as all run as one user."""
    path, command = folder / "signer", list(SERVICES["signer"]["command"])
    command = command[: command.index("--group")]
    command[command.index("--socket") + 1] = str(path)
    with subprocess.Popen(
        [str(Path(sys.executable).parent / command[0]), *command[1:]],
        env=os.environ | {"MOIREID_KEYS": str(folder / "keys")},
        stderr=subprocess.DEVNULL,
    ) as process:
        try:
            _until(path.is_socket, 60)
            os.environ["MOIREID_SIGNER"] = str(path)
            yield
        finally:
            process.terminate()


def prepared(folder: Path, database: str) -> tuple[list[str], bytes, str]:
    """A registry with a badge; returns tokens, a film, and whose badge it is."""
    os.environ["MOIREID_SEEN"] = str(folder / "seen.sqlite3")
    init = [word.replace(DATABASE, database) for word in SERVICES["init"]["command"]]
    subprocess.run([str(Path(sys.executable).parent / init[0]), *init[1:]], check=True, capture_output=True)
    badge = badge_of("Ada Lovelace")
    with open_registry(database, create=False) as registry:
        registry.enroll(badge)
    with open_tokens(folder / "nowhere", database) as tokens:
        secrets = [tokens.create("verifier")[0] for _ in range(ASKERS // 2)]
    return secrets, tiny_film(FILMS / "genuine_1.0m.mp4", folder / "tiny.mp4").read_bytes(), badge.name


def rows(wish: Wish) -> Iterator[Row]:
    """One row a figure."""
    scratch = Path(tempfile.mkdtemp(prefix="moireid-cluster-"))
    with running_server() as server, signing(scratch):
        try:
            database = server.fresh()
            tokens, film, claim = prepared(scratch, database)
            with Cluster(scratch, database, (scratch / "films").as_uri(), 2) as cluster:
                visitor = Visitor(cluster.ports, tokens, film, claim)
                count = wish.clips or (15 if wish.quick else 200)
                kills = {count // 5: "studio 0", 2 * count // 5: "worker 1", 3 * count // 5: "worker 0"}
                kills = {count // 10: "database"} if wish.own.no_kills else kills | {4 * count // 5: "database"}

                def away() -> Probes:
                    with Probes(cluster.ports) as probes:
                        server.away(wish.own.away)
                    return probes

                found = sent_through(cluster, visitor, count, kills, away)
            yield from ({"figure": name, "value": str(value)} for name, value in found.items())
        finally:
            for log in sorted(scratch.rglob("*.log")) if "MOIREID_LOGS" in os.environ else ():
                print(f"--- {log}\n{log.read_text()[-3000:]}")
            shutil.rmtree(scratch, ignore_errors=True)


OPTIONS = {
    "--away": {"type": float, "default": AWAY_S, "help": "seconds for which PostgreSQL is away"},
    "--no-kills": {"action": "store_true", "help": "kill no studio and no worker"},
}
BENCH = Bench(rows, {"figure": "<36", "value": "<1"}, options=OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
