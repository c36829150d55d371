"""The Enroll pages: a film of a finished badge, what was measured of it, and keeping that."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import RedirectResponse, Response

from moireid.errors import MoireIdError
from moireid.registry import Record
from moireid_studio.auth.roles import Visitor, require
from moireid_studio.checks import received
from moireid_studio.issue_jobs import as_built_of, keep, start_capture
from moireid_studio.pages.built_words import measured_words
from moireid_studio.pages.render import render
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job
from moireid_studio.studio import studio_of

router = APIRouter(include_in_schema=False)
Issuer = Annotated[Visitor, require("issuer")]


@router.get("/enroll")
def enroll_page(request: Request, visitor: Issuer, badge: str = "") -> Response:
    """The empty form, or one for the badge that a link names."""
    return _form(request, badge[:200])


@router.post("/enroll")
async def enroll(request: Request, visitor: Issuer) -> Response:
    """Take a film in, and let it be measured."""
    studio = studio_of(request)
    claim = ""
    try:
        async with studio.jobs.coming("capture", visitor.id, visitor.role) as job:
            form = await received(studio, request, job, ("claim",))
            claim = form.fields.get("claim", "").strip()
            if form.video is None:
                raise Refusal(422, "no_film", "No film was sent; choose one, or record one.")
            record = await run_in_threadpool(studio.registry.find, claim)
            await run_in_threadpool(start_capture, studio, job, form.video, record)
    except MoireIdError as error:
        return _form(request, claim, problem=studio.sentence(error), status=422)
    except Refusal as refusal:
        return _form(request, claim, problem=refusal.text, status=refusal.status)
    return RedirectResponse(f"/enroll/{job.id}", 303)


@router.get("/enroll/{job_id}")
def enroll_job(request: Request, job_id: str, visitor: Issuer) -> Response:
    """Progress, then what was measured."""
    studio = studio_of(request)
    job = studio.jobs.find(job_id, visitor.id, "capture")
    if job.state != "done":
        problem = studio.sentence(job.problem[1]) if job.problem else None
        return render(request, "making.html.j2", job=job, again="/enroll", problem=problem)
    record = studio.registry.by_id(as_built_of(job).badge_id)
    if record is None:
        raise Refusal(404, "no_badge", "This badge is in the registry no longer.")
    return _measured(request, job, record, kept=False)


@router.post("/enroll/{job_id}/keep")
def enroll_keep(request: Request, job_id: str, visitor: Issuer) -> Response:
    """Store what was measured."""
    studio = studio_of(request)
    job = studio.jobs.find(job_id, visitor.id, "capture")
    return _measured(request, job, keep(studio, job, visitor), kept=True)


def _form(request: Request, claim: str, *, problem: str | None = None, status: int = 200) -> Response:
    most_mb = studio_of(request).settings.limits.upload_bytes >> 20
    return render(request, "enroll.html.j2", status=status, claim=claim, problem=problem, most_mb=most_mb)


def _measured(request: Request, job: Job, record: Record, *, kept: bool) -> Response:
    figures = measured_words(as_built_of(job), record.badge)
    return render(request, "enrolled.html.j2", job=job.id, record=record, figures=figures, kept=kept)
