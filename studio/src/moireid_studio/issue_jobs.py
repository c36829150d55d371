"""Orders handed to the studio's jobs, and what became of them."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from starlette.responses import FileResponse

from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.enrolment import compare_with_record, keep_figures
from moireid.registry import Record
from moireid.registry.canonical import canonical_json
from moireid.verifier.session.known_figures import CaptureComparison
from moireid_studio.auth.guard import Visitor
from moireid_studio.jobs.orders import ORDERS, VisitorOrder
from moireid_studio.jobs.task import ORDER, PACKAGE, PEOPLE
from moireid_studio.pictures import kept_pictures, pack
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job
from moireid_studio.store.stored_pictures import StoredPicture
from moireid_studio.studio import Studio


def pictures_of(studio: Studio, order: VisitorOrder, visitor: Visitor) -> dict[str, StoredPicture]:
    """The pictures that an order names, by "logo" and "portrait".  Raises: SpecError where one is not kept."""
    named = {"logo": order.logo, "portrait": order.portrait}
    return {
        what: next(iter(kept_pictures(studio, visitor, kept, f"the {what}").values()))
        for what, kept in named.items()
        if kept is not None
    }


def start_badge(studio: Studio, order: VisitorOrder, visitor: Visitor, pictures: Mapping[str, StoredPicture]) -> Job:
    """A job that makes one badge's package; pictures: by "logo" and "portrait".

    Raises: Refusal 503 where too many wait, or it cannot be stored.
    """
    return _start(studio, "badge", visitor, order.name, ORDER, ORDERS.dump_json(order, exclude_defaults=True), pictures)


def start_event(
    studio: Studio, people_csv: bytes, order: VisitorOrder, visitor: Visitor, pictures: Mapping[str, StoredPicture]
) -> Job:
    """A job that makes an event's package; pictures: as for `lists.plan_list`.

    Raises: Refusal 503 where too many wait, or it cannot be stored.
    """
    return _start(
        studio,
        "event",
        visitor,
        "an event",
        PEOPLE,
        people_csv,
        pictures,
        order=ORDERS.dump_python(order, mode="json", exclude_defaults=True),
    )


def start_capture(studio: Studio, job: Job, video: Path, record: Record) -> Job:
    """Let the job that holds an uploaded film measure the badge of `record`."""
    job.label = record.name
    studio.jobs.submit(job, video, {"badge_json": record.badge.to_json()})
    return job


def _start(
    studio: Studio,
    kind: str,
    visitor: Visitor,
    label: str,
    name: str,
    content: bytes,
    pictures: Mapping[str, StoredPicture],
    **arguments: Any,
) -> Job:
    """Start a job from an archive with the order; the file is removed at the job's end, like an uploaded film."""
    with studio.jobs.receiving(kind, visitor.id, visitor.role) as job:
        job.label = label
        pack(studio, job, "order", pictures, {name: content})
        studio.jobs.submit(job, job.folder / "order", {"actor": visitor.actor} | arguments)
    return job


def package_of(job: Job) -> FileResponse:
    """A finished job's archive, as a download.  Raises: Refusal 404 where there is none (yet)."""
    path = _package(job)
    assert job.result is not None
    name = f"badge-{job.result['id']}.zip" if job.kind == "badge" else "event.zip"
    return FileResponse(path, media_type="application/zip", filename=name)


def file_of(job: Job, name: str) -> bytes:
    """A file of the badge that a finished job has made.  Raises: Refusal 404 where there is none (yet)."""
    with zipfile.ZipFile(_package(job)) as packed:
        if job.kind != "badge" or job.result is None or name not in job.result["files"]:
            raise _gone()
        return packed.read(f"badge-{job.result['id']}/{name}")


def _package(job: Job) -> Path:
    """A finished job's archive.  Raises: Refusal 404 where there is none (yet)."""
    path = job.folder / PACKAGE
    if job.state != "done" or not path.is_file():
        raise _gone()
    return path


def _gone() -> Refusal:
    return Refusal(404, "no_package", "This package is not made yet, or was removed already; issue the badge again.")


def as_built_of(job: Job) -> AsBuilt:
    """What a finished job measured.  Raises: Refusal 409 where it measured nothing (yet)."""
    if job.state != "done" or job.result is None:
        raise Refusal(409, "not_measured", "This capture is not measured; wait for it, or film the badge again.")
    return as_built_from_json(canonical_json(job.result["as_built"]))


def compared_of(studio: Studio, job: Job) -> tuple[Record, CaptureComparison]:
    """The badge of a finished job, and what it measured next to the figures in use.

    Raises: Refusal 404 where the badge is gone, 409 where nothing was measured.
    """
    found = as_built_of(job)
    record = studio.registry.by_id(found.badge_id)
    if record is None:
        raise Refusal(404, "no_badge", "This badge is in the registry no longer.")
    return record, compare_with_record(record, found, record.badge)


def keep(studio: Studio, job: Job, visitor: Visitor, reason: str | None = None) -> Record:
    """Keep what a job measured; again changes nothing.

    Parameters: reason: why it takes the place of the figures in use, which only an admin may decide: else all who may
        film a badge could turn its enrolment against its holder.
    Raises: Refusal 403, 404 or 409; RegistryError.
    """
    # In a registry that was put back to a day before its figures, any capture would be the first.
    studio.registry.standing()
    record, compared = compared_of(studio, job)
    if reason is not None and not visitor.may():
        raise Refusal(403, "role", "Only an admin may put figures in the place of others; ask one.")
    if compared.refused and reason is None:
        text = f"These figures are not kept: {compared.text}. An admin may keep them for a reason."
        raise Refusal(409, "figures_differ", text)
    return keep_figures(studio.registry.by(visitor.actor), record, as_built_of(job), reason)
