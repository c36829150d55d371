"""A studio for tests: an application over a new registry, asked without a network."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import httpx
from fastapi import FastAPI
from sqlalchemy import update

from moireid.badge import Badge
from moireid.reading.film_orders import Order
from moireid.registry import open_registry
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Camera, Scene
from moireid_studio.app import create_app
from moireid_studio.jobs.queue import Jobs
from moireid_studio.jobs.task import Task
from moireid_studio.jobs.workers import Doer
from moireid_studio.settings import Limits, Settings
from moireid_studio.store.database import database_of, jobs
from moireid_studio.store.job import Job
from moireid_studio.store.ledger import Ledger
from moireid_studio.studio import Studio

ROLES = ("issuer", "verifier", "monitor", "admin")
ORIGIN = "http://studio.test"


class Visit:
    """An application, and tokens of every role by which to ask it."""

    def __init__(self, app: FastAPI, folder: Path) -> None:
        self.app, self.folder = app, folder
        self.studio: Studio = app.state.studio
        self.tokens = {role: self.studio.tokens.create(role)[0] for role in ROLES} if self.studio.settings.auth else {}

    def ask(self, method: str, path: str, role: str | None = "admin", **more: Any) -> httpx.Response:
        """The answer to one request."""
        return self.ask_all([(method, path, role, more)])[0]

    def ask_all(self, requests: list[tuple[str, str, str | None, dict[str, Any]]]) -> list[httpx.Response]:
        """The answers to requests that are made at once."""

        async def go() -> list[httpx.Response]:
            transport = httpx.ASGITransport(self.app, raise_app_exceptions=False)
            async with httpx.AsyncClient(transport=transport, base_url=ORIGIN, timeout=300) as client:
                return await asyncio.gather(*(self._one(client, *request) for request in requests))

        return asyncio.run(go())

    async def _one(
        self, client: httpx.AsyncClient, method: str, path: str, role: str | None, more: dict[str, Any]
    ) -> httpx.Response:
        bearer = {"Authorization": f"Bearer {self.tokens[role]}"} if role in self.tokens else {}
        headers = bearer | more.pop("headers", {})
        return await client.request(method, path, headers=headers, **more)

    def job(self, job_id: str) -> Job:
        """A job, by any visitor."""
        found = self.studio.jobs.ledger.find(job_id)
        assert found is not None
        return found

    def rewrite(self, job_id: str, **values: object) -> None:
        """Change what the database has of a job."""
        with self.studio.jobs.ledger.database.writing() as connection:
            connection.execute(update(jobs).where(jobs.c.id == job_id).values(**values))

    def left(self) -> list[str]:
        """What lies in the folders of jobs."""
        return sorted(str(path.relative_to(self.folder)) for path in (self.folder / "jobs").rglob("*"))

    def wait(self, job_id: str, role: str = "admin") -> dict[str, Any]:
        """The job once it is over."""
        begun = time.monotonic()
        while (output := self.ask("GET", f"/api/jobs/{job_id}", role).json())["state"] not in ("done", "failed"):
            assert time.monotonic() - begun < 200
            time.sleep(0.1)
        return output


#: Opens a studio with these badges and settings: `open_studio` of the studio's tests.
OpenStudio = Callable[..., Visit]


@contextmanager
def studio(
    folder: Path,
    *badges: Badge,
    auth: bool = True,
    work: bool = True,
    data: str = "studio",
    state: str | None = None,
    scheduler: str | None = None,
    worker_url: str = "",
    public_url: str | None = None,
    **limits: Any,
) -> Iterator[Visit]:
    """A studio at work (or only open), with these badges enrolled; its keys lie where MOIREID_KEYS says."""
    url = f"sqlite:///{folder}/registry.sqlite3"
    with open_registry(url, create=True) as registry:
        for badge in badges:
            registry.enroll(badge)
    limits = {"stop_s": 0.5} | limits
    more: dict[str, Any] = {"state": state, "scheduler": scheduler, "worker_url": worker_url, "public_url": public_url}
    given = Settings(url, folder / data, auth, replace(Limits(), **limits), **more)
    app = create_app(given)
    visit = Visit(app, folder / data)
    if work:
        visit.studio.jobs.start()
    try:
        yield visit
    finally:
        visit.studio.jobs.stop()
        visit.studio.close()


def task_of(job: Job, order: Order | None = None) -> Task:
    """What the process of a job gets, whatever the job is."""
    return Task(job.kind, job.folder, job.video, order)


def jobs_of(folder: Path, limits: Limits, prepare: Callable[[Job], Task] = task_of) -> Jobs:
    """Jobs without a studio, in a folder of their own."""
    folder.mkdir(parents=True, exist_ok=True)
    ledger = Ledger(database_of(folder.parent, f"{folder.name}.sqlite3", None, log=True), folder)
    return Jobs(folder, Doer(ledger, limits, prepare))


def tiny_film(source: Path, path: Path, *, frames: int = 12, size: tuple[int, int] = (640, 360)) -> Path:
    """The first frames of a film, smaller: quickly judged; so few are never more than "inconclusive"."""
    with av.open(str(source)) as given, av.open(str(path), "w") as made:
        stream = made.add_stream("libx264", rate=60, options={"threads": "2"})
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        for number, frame in enumerate(given.decode(video=0)):
            if number == frames:
                break
            small = frame.reformat(*size)
            small.pts, small.time_base = number, Fraction(1, 60)
            made.mux(stream.encode(small))
        made.mux(stream.encode())
    return path


def badge_film(badge: Badge, path: Path) -> Path:
    """A film of a badge in motion, as few and as small pictures as tell whose it is."""
    camera = Camera(width=960, height=540, focal_px=725.0)
    course = motion_named("handheld", distance_mm=900.0, seed=7)
    film(Scene(badge, camera=camera), course, path, frames=90, fps=30.0, seed=7)
    return path


def film_form(
    film: Path | bytes, badge: Path | str | None = None, name: str = "film.mp4", **fields: str
) -> dict[str, Any]:
    """What to hand to `ask` for an upload."""
    content = film if isinstance(film, bytes) else film.read_bytes()
    text = badge.read_text() if isinstance(badge, Path) else badge
    return {"files": {"video": (name, content)}, "data": fields | ({"badge": text} if text else {})}
