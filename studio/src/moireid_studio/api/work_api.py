"""What the workers of a cluster ask: the film of a job, and where what its process says goes (`jobs.cluster`)."""

from __future__ import annotations

import json

from fastapi import APIRouter, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import FileResponse

from moireid.sandbox.seal import ProcessLimits
from moireid_studio.auth.guard import anyone
from moireid_studio.forms import within
from moireid_studio.jobs.cluster import Run
from moireid_studio.problems import Refusal
from moireid_studio.studio import studio_of

#: Not for visitors: a worker has a token for its one job, and no other opens anything here.
router = APIRouter(prefix="/work", include_in_schema=False, dependencies=[anyone])
#: Of a message, as written by a worker; a film's process may say no more.
MOST_BYTES = 6 * ProcessLimits(0).answer_bytes


def _run_of(request: Request) -> Run:
    """The job of the worker's token.  Raises: Refusal 404 where there is none (any more)."""
    cluster, token = studio_of(request).jobs.doer.cluster, request.headers.get("authorization", "").partition(" ")[2]
    run = None if cluster is None else cluster.run_of(token)
    if run is None:
        raise Refusal(404, "no_work", "There is no such work, or it was taken back.")
    return run


@router.get("/film")
def film(request: Request) -> FileResponse:
    """The film; who fetches it begins with it."""
    run = _run_of(request)
    with run.lock:
        run.begin()
    return FileResponse(run.film)


@router.post("/message")
async def message(request: Request) -> None:
    """Take what a film's process says."""
    run = _run_of(request)
    body = await within(request, MOST_BYTES).body()
    await run_in_threadpool(taken, run, body)


def taken(run: Run, body: bytes) -> None:
    """Take a message.  Raises: Refusal 410 where it ends the job."""
    with run.lock:
        try:
            run.handle(json.loads(body))
        # Whatever is wrong with it ends the job, in the thread that waits for it.
        except Exception as error:
            run.fault = error
            raise Refusal(410, "no_work", "This work was taken back.") from error
