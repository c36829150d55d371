"""Verify: a film and a claim in, progress, then the verdict with its reasons, plots and the report to keep.

All of it works without JavaScript: the form is posted, and the page of a job reloads until the job has ended.
"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Form, Request
from fastapi import Path as InPath
from fastapi.responses import RedirectResponse, Response

from moireid.names import CLAIM_LIMIT
from moireid.verifier.report.page import told
from moireid.verifier.report.pictures import KINDS as KINDS_OF
from moireid.verifier.report.pictures import NAME
from moireid_studio.auth.roles import Visitor, require
from moireid_studio.checks import KINDS, start_job
from moireid_studio.pages.player import course_of
from moireid_studio.pages.render import render
from moireid_studio.problems import Refusal
from moireid_studio.reports import circumstances_of, kept_file, pictures_told
from moireid_studio.samples import Sample, start_sample
from moireid_studio.studio import studio_of

router = APIRouter(prefix="/verify", include_in_schema=False)

Verifier = Annotated[Visitor, require("verifier")]
#: A plot has its own style; it is shown as a picture, and may run and load nothing.
PICTURE_POLICY = {"Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; sandbox"}


@router.get("")
def form(request: Request, visitor: Verifier, claim: str = "") -> Response:
    """Choose a film, and say whose badge it shows."""
    return render(request, "verify.html.j2", limits=studio_of(request).settings.limits, claim=claim[:CLAIM_LIMIT])


@router.post("")
async def begin(request: Request, visitor: Verifier) -> Response:
    """Take the film, and go to the page of its job."""
    job = await start_job(request, visitor, report=True)
    return RedirectResponse(f"/verify/{job.id}", 303)


@router.post("/sample")
def sample(request: Request, visitor: Verifier, which: Annotated[Sample, Form()]) -> Response:
    """Judge a film that comes with moireid, and go to the page of its job."""
    job = start_sample(studio_of(request), visitor, which)
    return RedirectResponse(f"/verify/{job.id}", 303)


@router.get("/{job_id}")
def outcome(request: Request, job_id: str, visitor: Verifier) -> Response:
    """How far it has come, or the verdict."""
    job = studio_of(request).jobs.find(job_id, visitor.id, *KINDS)
    if not job.over:
        return render(request, "verify_wait.html.j2", job=job)
    if job.result is None:
        code, text = job.problem or ("crash", "")
        raise Refusal(503 if code in ("stopped", "system") else 422, code, text)
    keep = int(studio_of(request).settings.limits.keep_s)
    kept = f"{keep // 60} minutes" if keep >= 120 else f"{keep} seconds"
    known = circumstances_of(studio_of(request), job)
    shown = told(job.result, pictures_told(job), known, lambda name: f"/verify/{job.id}/picture/{name}")
    course = course_of(job, shown["seconds"])
    return render(request, "verdict.html.j2", job=job, kept_for=kept, course=course, **shown)


@router.get("/{job_id}/picture/{name}")
def picture(
    request: Request, job_id: str, name: Annotated[str, InPath(pattern=f"^(?:{NAME.pattern})$")], visitor: Verifier
) -> Response:
    """A picture of the report."""
    job = studio_of(request).jobs.find(job_id, visitor.id, *KINDS)
    if not job.over:
        raise Refusal(404, "no_picture", "There is no such picture yet.")
    return Response(kept_file(job, name), media_type=KINDS_OF[name.rpartition(".")[2]], headers=PICTURE_POLICY)
