"""The queue of films: a limited number waits, two workers judge them, and results are kept for a while.

Every job has its own folder.  The film lies there from its first byte on, and is removed when the job ends.  The rest
of the folder is removed with it, or after `keep_s` where the report is kept.
"""

from __future__ import annotations

import contextlib
import logging
import os
import queue
import re
import secrets
import shutil
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, get_args

from moireid.errors import RegistryError
from moireid.provenance import Barred, Standing
from moireid.registry import People
from moireid.sandbox.limits import ProcessLimits
from moireid.web.auth.tokens import Role
from moireid.web.door.metrics import Metrics
from moireid.web.door.rates import Rates
from moireid.web.door.shares import Held, fits
from moireid.web.jobs.asking import MOST_OF_A_LAYOUT, answer_to, with_name
from moireid.web.jobs.child import Lost, films, run_task
from moireid.web.jobs.heard import Unusable, frames_of, kept_of, result_of
from moireid.web.jobs.task import Task
from moireid.web.problems import Refusal
from moireid.web.settings import Limits

State = Literal["receiving", "waiting", "working", "done", "failed"]
#: How often old results are looked for.
SWEEP_S = 10.0
#: Memory that libraries reserve for each processor: stacks of threads, buffers of linear algebra.
PROCESSOR_BYTES = 64 << 20
#: Greatest size of a file that a job writes.
FILE_BYTES = 256 << 20


@dataclass
class Job:
    """One film: its owner, its progress, and its outcome.

    result: the JSON of the command; kept: what lies in the folder beside it; problem: code and sentence; begun: when it
    was asked for; film_name, claim: as the visitor gave them; barred: why the claimed badge does not count; standing:
    of the registry when the film came; people: whom the film's process may ask about; questions: how often it still
    may; bytes: of its film; film_sha256: of the film as it came; claimed_id, claim_source: the badge that the claim
    means, and who says so.
    """

    id: str
    kind: str
    owner: str
    folder: Path
    role: str = "verifier"
    label: str = ""
    begun: datetime = field(default_factory=lambda: datetime.now(UTC))
    film_name: str = ""
    claim: str = ""
    barred: Barred | None = None
    standing: Standing | None = None
    film_sha256: str | None = None
    claimed_id: str | None = None
    claim_source: str | None = None
    people: People | None = None
    questions: int = 0
    bytes: int = 0
    state: State = "receiving"
    frames: tuple[int, int | None] = (0, None)
    result: dict[str, Any] | None = None
    kept: dict[str, Any] = field(default_factory=dict)
    problem: tuple[str, str] | None = None
    ended_s: float = 0.0
    finished: Future[None] = field(default_factory=Future)

    @property
    def over(self) -> bool:
        """Whether the job has ended."""
        return self.state in ("done", "failed")


class Jobs:
    """The jobs of one studio; safe to use from any thread."""

    def __init__(
        self,
        folder: Path,
        limits: Limits,
        judged: Callable[[Job], None] = lambda job: None,
        metrics: Metrics | None = None,
    ) -> None:
        """judged: told of each job that has a result, before its visitor is; it runs in the thread of the work."""
        self._judged, self._metrics = judged, metrics or Metrics()
        # Made absolute, because a job's process begins in another folder.
        self._folder, self._limits = folder.absolute(), limits
        memory = limits.memory_bytes + PROCESSOR_BYTES * (os.cpu_count() or 1)
        self._of_one = ProcessLimits(memory, cpu_s=int(limits.job_s * 4) + 1, file_bytes=FILE_BYTES)
        self._jobs: dict[str, Job] = {}
        self._lock, self.rates = threading.Lock(), Rates(limits)
        self._queue: queue.Queue[tuple[Job, Task]] = queue.Queue()
        self._stopping = threading.Event()
        self._threads: list[threading.Thread] = []

    def start(self) -> None:
        """Begin to work, after removing what a killed server has left in the folder."""
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self._clear()
        self._stopping.clear()
        films.warm_up()
        works = [self._work] * self._limits.workers
        self._threads = [threading.Thread(target=work, daemon=True) for work in (*works, self._sweep)]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End all work, and remove all films."""
        self._stopping.set()
        for thread in self._threads:
            thread.join()
        for job in list(self._jobs.values()):
            self.remove(job)
        self._clear()
        # A folder with something of somebody else's in it stays.
        with contextlib.suppress(OSError):
            self._folder.rmdir()

    def _clear(self) -> None:
        """Remove the folders of jobs and nothing else, because the folder may hold a user's own files."""
        for entry in self._folder.iterdir() if self._folder.is_dir() else ():
            if re.fullmatch("[0-9a-f]{32}", entry.name):
                shutil.rmtree(entry, ignore_errors=True)

    def admit(self, kind: str, owner: str, role: Role = "verifier") -> Job:
        """A new job, with a folder for its film.

        Raises: Refusal 503 where too many wait already, or the disk is full; 429 where the token sends too many.
        """
        self.rates.upload(owner, role)
        with self._lock:
            if not fits(self._held(), owner, role, self._limits):
                raise Refusal(
                    503,
                    "busy",
                    "Too many films wait to be judged; try again in a minute.",
                    headers={"Retry-After": "60"},
                )
            job_id = secrets.token_hex(16)
            job = self._jobs[job_id] = Job(job_id, kind, owner, self._folder / job_id, role)
        try:
            job.folder.mkdir(mode=0o700)
        except OSError as error:
            self.remove(job)
            raise Refusal(503, "disk", f"The film cannot be stored ({error.strerror}); try again later.") from error
        return job

    @property
    def at_work(self) -> bool:
        """Whether there is somebody to do the work."""
        return bool(self._threads) and not self._stopping.is_set()

    def counts(self) -> dict[str, float]:
        """How many jobs there are in each state."""
        found = Counter(job.state for job in self._jobs.values())
        return {state: found[state] for state in get_args(State)}

    def stored_bytes(self) -> float:
        """How many bytes of films are stored."""
        return sum(job.bytes for job in self._jobs.values())

    def _held(self) -> list[Held]:
        """What the jobs that are not over hold of the places."""
        found = Counter((job.owner, job.role, job.state == "receiving") for job in self._jobs.values() if not job.over)
        return [Held(*key, count) for key, count in found.items()]

    def stored(self, job: Job, size: int) -> None:
        """So many bytes of a job's film are stored.  Raises: Refusal 503 where that is more than the disk's share."""
        job.bytes = size
        every = list(self._jobs.values())
        own = sum(one.bytes for one in every if one.owner == job.owner)
        if sum(one.bytes for one in every) > self._limits.disk_bytes or own > self._limits.disk_bytes // 2:
            raise Refusal(
                503,
                "disk",
                "The place for films is full; try again when others are judged.",
                headers={"Retry-After": "60"},
            )

    @contextlib.contextmanager
    def receiving(self, kind: str, owner: str, role: Role) -> Iterator[Job]:
        """Like `admit`, while the film is received: if anything goes wrong, the received part is removed.

        A visitor who leaves counts too, because the route is cancelled then.
        """
        job = self.admit(kind, owner, role)
        try:
            yield job
        except BaseException:
            self.remove(job)
            raise

    def submit(self, job: Job, video: Path, **arguments: Any) -> None:
        """Let a job begin as soon as a worker is free; the arguments depend on its kind of work."""
        job.state, job.questions = "waiting", MOST_OF_A_LAYOUT * len(arguments.get("layouts", ()))
        self._queue.put((job, Task(job.kind, job.folder, video.name, arguments)))

    def find(self, job_id: str, owner: str, *kinds: str) -> Job:
        """The job with that id, if it belongs to `owner` and is of one of `kinds` (none named: of any kind).

        Raises: Refusal 404 otherwise.
        """
        job = self._jobs.get(job_id)
        if job is None or job.owner != owner or (kinds and job.kind not in kinds):
            raise Refusal(404, "no_job", "There is no such job, or its results were removed already.")
        return job

    def remove(self, job: Job) -> None:
        """Forget a job, with all that lies in its folder."""
        with self._lock:
            self._jobs.pop(job.id, None)
        shutil.rmtree(job.folder, ignore_errors=True)

    def _work(self) -> None:
        while not self._stopping.is_set():
            try:
                job, task = self._queue.get(timeout=0.2)
            except queue.Empty:
                continue
            self._do(job, task)

    def _do(self, job: Job, task: Task) -> None:
        """Do one job; whatever goes wrong ends this job, with a sentence, and nothing else."""
        job.state, begun_s = "working", time.monotonic()
        try:
            problem = self._run(job, task)
            if job.result is not None:
                self._judged(job)
        # The boundary between a stranger's film and all others: an error that nobody thought of must not end the
        # thread, which has the next visitor's film to judge.
        except Exception:
            logging.getLogger(__name__).exception("job %s failed inside moireid", job.id)
            problem = ("system", "Something went wrong inside moireid; the server's log says what.")
        # A finished verdict counts, even if its report could not be drawn.
        if job.result is None:
            job.problem = problem or ("crash", "The process that read this film ended without a result.")
        self._tidy(job, task)
        job.ended_s = time.monotonic()
        self._metrics.working.labels(job.kind).observe(job.ended_s - begun_s)
        self._metrics.ended.labels(job.kind, "failed" if job.problem else "done").inc()
        job.state = "done" if job.result is not None else "failed"
        if not job.finished.done():
            job.finished.set_result(None)

    def _run(self, job: Job, task: Task) -> tuple[str, str] | None:
        """Let a job's process do its work; returns what was wrong, as code and sentence."""
        try:
            run_task(
                task,
                self._of_one,
                lambda said: self._heard(job, said),
                wall_s=self._limits.job_s,
                stopping=self._stopping.is_set,
            )
        except Lost as lost:
            return lost.code, lost.text
        except Unusable as error:
            logging.getLogger(__name__).warning("job %s was ended: its process was not honest (%s)", job.id, error)
            return "crash", "The process that read this film said what cannot be used; the film may be damaged."
        except RegistryError:
            return "registry", "The registry cannot be asked just now; try again later."
        except OSError as error:
            return "system", f"No process could be started ({error.strerror}); try again later."
        return None

    @staticmethod
    def _tidy(job: Job, task: Task) -> None:
        """Remove the film, and without a result all else: the process may have put a folder in the film's place."""
        film = job.folder / task.video
        try:
            film.unlink(missing_ok=True)
        except OSError:
            shutil.rmtree(film, ignore_errors=True)
        if job.result is None:
            shutil.rmtree(job.folder, ignore_errors=True)

    def _heard(self, job: Job, message: dict[str, Any]) -> object:
        """Take a message in; returns the answer to a question.  Raises: Unusable, RegistryError."""
        if "ask" in message:
            job.questions -= 1
            if job.questions < 0:
                raise Unusable("it asked the registry more than a film needs")
            return answer_to(message["ask"], job.people)
        if "progress" in message:
            job.frames = frames_of(message["progress"])
        elif "result" in message:
            result = result_of(job.kind, message["result"])
            # The server's own word, and not that of the process that reads the film.
            if job.standing is not None:
                result["registry"] = job.standing.to_json()
            if job.film_sha256 is not None and isinstance(result.get("input"), dict):
                result["input"]["sha256"] = job.film_sha256
            job.result = result if job.people is None else with_name(result, job.people)
        else:
            job.kept = kept_of(message)
        return None

    def _sweep(self) -> None:
        """Remove results that are too old, and the oldest ones where there are too many."""
        while not self._stopping.wait(SWEEP_S):
            with self._lock:
                over = sorted((job for job in self._jobs.values() if job.over), key=lambda job: -job.ended_s)
            old, seen = time.monotonic() - self._limits.keep_s, Counter[str]()
            for job in over:
                # Counted for each owner, so that one visitor's films never remove another's results.
                seen[job.owner] += 1
                if job.ended_s < old or seen[job.owner] > self._limits.kept:
                    self.remove(job)
