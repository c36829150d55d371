"""The API: what the commands say, as the same JSON.

Under /api an error is `{"code", "text"}`.  A verdict is not an error: for a rejected film the answer is 200, too.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import AsyncIterator
from typing import Annotated, Any, Literal

import anyio
from fastapi import APIRouter, Query, Request
from fastapi import Path as InPath
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse, Response, StreamingResponse
from pydantic import BaseModel

from moireid.verifier.report.report_page import render_page
from moireid_studio.api.schema import IDENTIFICATION, REPORT, answers, form
from moireid_studio.auth.guard import Visitor, require
from moireid_studio.auth.tokens import Role
from moireid_studio.checks import IDENTIFY_FIELDS, KINDS, VERIFY_FIELDS, start_job
from moireid_studio.jobs.child import STOPPED
from moireid_studio.jobs.queue import Jobs
from moireid_studio.jobs.task import SIGNALS
from moireid_studio.problems import Problem, Refusal, problem_responses
from moireid_studio.receipts import with_live_checks
from moireid_studio.reports import circumstances_of, kept_file, pictures_of_job
from moireid_studio.store.job import Job, State
from moireid_studio.studio import Studio, studio_of

router = APIRouter(prefix="/api")

Verifier = Annotated[Visitor, require("verifier")]
JobId = Annotated[str, InPath(pattern="^[0-9a-f]{32}$", description="As the answer that began the job says.")]
UPLOAD = problem_responses(400, 401, 403, 404, 408, 409, 413, 415, 422, 503)
#: Errors after a film was received: the film's fault, or the machine's.
OUR_FAULT = frozenset({"stopped", "system", "storage", "registry"})


class Frames(BaseModel):
    """Frames read so far, and as many as the film says that it has."""

    read: int
    expected: int | None


class JobStatus(BaseModel):
    """How far a job has come; `result` is what the command prints, `problem` why there is none."""

    id: str
    kind: str
    state: State
    frames: Frames
    result: dict[str, Any] | None
    problem: Problem | None
    report: bool


def status_of(job: Job) -> JobStatus:
    """The state of a job as the API shows it."""
    return JobStatus(
        id=job.id,
        kind=job.kind,
        state=job.state,
        frames=Frames(read=job.frames[0], expected=job.frames[1]),
        result=job.result if job.over else None,
        problem=Problem(code=job.problem[0], text=job.problem[1]) if job.problem else None,
        report=job.over and bool(job.kept),
    )


def add_job_routes(router: APIRouter, role: Role, kinds: tuple[str, ...]) -> None:
    """Routes by which those of a role follow their own jobs of these kinds, in /openapi.json and in browsers."""

    @router.get("/jobs/{job_id}", responses=problem_responses(401, 403, 404, 422))
    async def job_status(request: Request, job_id: JobId, visitor: Visitor = require(role)) -> JobStatus:  # noqa: B008
        """How far a job of yours has come, and its result."""
        return status_of(await run_in_threadpool(studio_of(request).jobs.find, job_id, visitor.id, *kinds))

    @router.get(
        "/jobs/{job_id}/events",
        response_class=StreamingResponse,
        responses=problem_responses(401, 403, 404, 422)
        | {200: {"description": "events `progress`, and one `end`", "content": {"text/event-stream": {}}}},
    )
    async def job_events(
        request: Request,
        job_id: JobId,
        visitor: Visitor = require(role),  # noqa: B008
    ) -> StreamingResponse:
        """Server-sent events: `progress` with state and frames as they change, and `end` once the job is over."""
        jobs = studio_of(request).jobs
        job = await run_in_threadpool(jobs.find, job_id, visitor.id, *kinds)
        return StreamingResponse(events_of(jobs, job), media_type="text/event-stream")


async def events_of(jobs: Jobs, job: Job) -> AsyncIterator[str]:
    """A job's progress as text.  Source: "Server-sent events" of the HTML standard."""
    async for now, last in jobs.changes(job):
        said = json.dumps({"state": now.state, "read": now.frames[0], "expected": now.frames[1]})
        yield f"event: {'end' if last else 'progress'}\ndata: {said}\n\n"


@router.post(
    "/verify",
    openapi_extra=form(*VERIFY_FIELDS),
    responses=UPLOAD | answers(REPORT, "what `moireid verify --json` prints"),
)
async def verify(request: Request, visitor: Verifier) -> Response:
    """Check that a film shows the claimed badge; answers once it is judged."""
    return await _result(request, visitor, "verify")


@router.post(
    "/identify",
    openapi_extra=form(*IDENTIFY_FIELDS),
    responses=UPLOAD | answers(IDENTIFICATION, "what `moireid identify --json` prints"),
)
async def identify(request: Request, visitor: Verifier) -> Response:
    """Say whose badge a film shows, if anyone's in the registry; answers once it is judged."""
    return await _result(request, visitor, "identify")


async def _result(request: Request, visitor: Visitor, kind: str) -> Response:
    """Judge a film while the visitor waits, and leave nothing behind."""
    jobs = studio_of(request).jobs
    job = await start_job(request, visitor, kind=kind, report=False)
    try:
        ended = [now async for now, _ in jobs.changes(job)][-1]
    finally:
        with anyio.CancelScope(shield=True):
            await run_in_threadpool(jobs.remove, job)
    if ended.result is None:
        code, text = ended.problem or STOPPED
        raise Refusal(503 if code in OUR_FAULT else 422, code, text)
    return JSONResponse(ended.result)


@router.post("/jobs", status_code=202, openapi_extra=form("kind", *VERIFY_FIELDS), responses=UPLOAD)
async def create_job(request: Request, response: Response, visitor: Verifier) -> JobStatus:
    """As verify or identify, but answers at once: the job shows its progress, and keeps its report for a while."""
    job = await start_job(request, visitor, report=True)
    response.headers["Location"] = f"/api/jobs/{job.id}"
    return status_of(job)


add_job_routes(router, "verifier", KINDS)


def _report_files(studio: Studio, job: Job) -> dict[str, bytes]:
    """The report of a job by the names of `moireid verify --report`.  Raises: Refusal 404 where it was removed."""
    result = with_live_checks(studio, job)
    page = render_page(result, pictures_of_job(job), circumstances_of(studio, job))
    data = json.dumps(result, indent=1, ensure_ascii=False) + "\n"
    return {"report.html": page.encode(), "report.json": data.encode(), SIGNALS: kept_file(job, SIGNALS)}


@router.get(
    "/jobs/{job_id}/report",
    response_class=Response,
    responses=problem_responses(401, 403, 404, 409, 422)
    | {200: {"description": "a file to keep", "content": {"text/html": {}, "application/zip": {}}}},
)
async def job_report(
    request: Request, job_id: JobId, visitor: Verifier, format: Annotated[Literal["html", "zip"], Query()] = "html"
) -> Response:
    """The report of a film that was verified, to keep: one page, or a zip of page, JSON and signals."""
    job = await run_in_threadpool(studio_of(request).jobs.find, job_id, visitor.id, *KINDS)
    if not job.over:
        raise Refusal(409, "not_ready", "This film is not judged yet.")
    if not job.kept:
        raise Refusal(404, "no_report", "There is no report on this film.")
    files = await run_in_threadpool(_report_files, studio_of(request), job)
    if format == "html":
        content, kind = files["report.html"], "text/html; charset=utf-8"
    else:
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, text in files.items():
                archive.writestr(name, text)
        content, kind = packed.getvalue(), "application/zip"
    name = f'attachment; filename="moireid-{job.id[:8]}.{format}"'
    # The page has its own style.  It may run and load nothing, although we made it.
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'; sandbox"
    headers = {"Content-Disposition": name, "Content-Security-Policy": policy}
    return Response(content, media_type=kind, headers=headers)
