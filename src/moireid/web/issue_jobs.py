"""Orders handed to the studio's jobs, and what became of them."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any

from starlette.background import BackgroundTask
from starlette.responses import FileResponse

from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.registry import Record
from moireid.registry.canonical import canonical_json
from moireid.web.auth.roles import Visitor
from moireid.web.jobs.orders import Order, Wish
from moireid.web.jobs.task import PACKAGE
from moireid.web.problems import Refusal
from moireid.web.store.job import Job
from moireid.web.store.storage import StorageError
from moireid.web.studio import Studio


def start_badge(studio: Studio, order: Order, visitor: Visitor) -> Job:
    """A job that makes one badge's package.  Raises: Refusal 503 where too many wait."""
    return _start(studio, "badge", visitor, order.name, order.model_dump_json().encode())


def start_event(studio: Studio, people_csv: bytes, wish: Wish, visitor: Visitor) -> Job:
    """A job that makes an event's package.  Raises: Refusal 503 where too many wait."""
    return _start(studio, "event", visitor, "an event", people_csv, wish=wish.model_dump())


def start_capture(studio: Studio, job: Job, video: Path, record: Record) -> Job:
    """Let the job that holds an uploaded film measure the badge of `record`."""
    job.label = record.name
    studio.jobs.submit(job, video, {"badge_json": record.badge.to_json()})
    return job


def _start(studio: Studio, kind: str, visitor: Visitor, label: str, order: bytes, **arguments: Any) -> Job:
    """Start a job from a file with the order; the file is removed at the job's end, like an uploaded film."""
    job = studio.jobs.admit(kind, visitor.id, visitor.role)
    job.label = label
    try:
        (job.folder / "order").write_bytes(order)
    except OSError as error:
        studio.jobs.remove(job)
        raise Refusal(503, "disk", f"The order cannot be stored ({error.strerror}); try again later.") from error
    studio.jobs.submit(job, job.folder / "order", {"actor": visitor.actor} | arguments)
    return job


def package_of(job: Job) -> FileResponse:
    """A finished job's archive, as a download.  Raises: Refusal 404 where there is none (yet)."""
    gone = Refusal(404, "no_package", "This package is not made yet, or was removed already; issue the badge again.")
    if job.state != "done" or job.result is None or job.files is None:
        raise gone
    with ExitStack() as held:
        try:
            path = held.enter_context(job.files(PACKAGE))
        except FileNotFoundError as error:
            raise gone from error
        except StorageError as error:
            raise Refusal(503, "storage", "The package cannot be read just now; try again later.") from error
        if not path.is_file():
            raise gone
        name = f"badge-{job.result['id']}.zip" if job.kind == "badge" else "event.zip"
        return FileResponse(
            path, media_type="application/zip", filename=name, background=BackgroundTask(held.pop_all().close)
        )


def as_built_of(job: Job) -> AsBuilt:
    """What a finished job measured.  Raises: Refusal 409 where it measured nothing (yet)."""
    if job.state != "done" or job.result is None:
        raise Refusal(409, "not_measured", "This capture is not measured; wait for it, or film the badge again.")
    return as_built_from_json(canonical_json(job.result["as_built"]))


def keep(studio: Studio, job: Job, visitor: Visitor) -> Record:
    """Store what a job measured as the badge's figures; again changes nothing.  Raises: Refusal 409; RegistryError."""
    found = as_built_of(job)
    return studio.registry.by(visitor.actor).store_as_built(found.badge_id, found.to_json())
