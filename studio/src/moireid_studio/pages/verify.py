"""Verify: a film and a claim in, progress, then the verdict with its reasons, plots and the report to keep.

All of it works without JavaScript: the form is posted, and the page of a job reloads until the job has ended.

`install` lets the application answer every error with one sentence, on a page or, under /api, as JSON.
"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, FastAPI, Form, Request
from fastapi import Path as InPath
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, RedirectResponse, Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from moireid.errors import MoireIdError, RegistryError
from moireid.names import NAME_LIMIT
from moireid.registry.rollback import CODES
from moireid.verifier.report.report_page import KINDS as KINDS_OF
from moireid.verifier.report.report_page import NAME, page_context
from moireid_studio.auth.guard import HEADERS, Visitor, require
from moireid_studio.checks import KINDS, Sample, start_job, start_sample
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.receipts import links_about, with_live_checks
from moireid_studio.reports import circumstances_of, kept_file, list_pictures
from moireid_studio.store.database import is_away
from moireid_studio.studio import studio_of

router = APIRouter(prefix="/verify", include_in_schema=False)

Verifier = Annotated[Visitor, require("verifier")]
#: A plot has its own style; it is shown as a picture, and may run and load nothing.
PICTURE_POLICY = {"Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; sandbox"}


@router.get("")
def form(request: Request, visitor: Verifier, claim: str = "") -> Response:
    """Choose a film, and say whose badge it shows."""
    return render(request, "verify.html.j2", limits=studio_of(request).settings.limits, claim=claim[:NAME_LIMIT])


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
    report = with_live_checks(studio_of(request), job)
    shown = page_context(report, list_pictures(job), known, lambda name: f"/verify/{job.id}/picture/{name}")
    about = links_about(studio_of(request), job)
    shown |= {"ask_about": job.claim_source == "registry" and job.film_sha256 is not None}
    shown |= {"waiting": sum(link.state in ("waiting", "opened", "running") for link in about)}
    return render(request, "verdict.html.j2", job=job, kept_for=kept, **shown)


@router.get("/{job_id}/picture/{name}")
def picture(
    request: Request, job_id: str, name: Annotated[str, InPath(pattern=f"^(?:{NAME.pattern})$")], visitor: Verifier
) -> Response:
    """A picture of the report."""
    job = studio_of(request).jobs.find(job_id, visitor.id, *KINDS)
    if not job.over:
        raise Refusal(404, "no_picture", "There is no such picture yet.")
    return Response(kept_file(job, name), media_type=KINDS_OF[name.rpartition(".")[2]], headers=PICTURE_POLICY)


#: Sentences for a status where the framework gives none.
WORDS = {
    404: ("not_found", "There is nothing at this address."),
    405: ("method", "This address does not take such a request."),
    400: ("bad_request", "This request cannot be read."),
}


def install(app: FastAPI) -> None:
    """Let the application answer every error in our words."""
    for kind in (Refusal, MoireIdError, RequestValidationError, HTTPException, ClientDisconnect, Exception):
        app.add_exception_handler(kind, answer)


def refusal_of(request: Request, error: Exception) -> Refusal:
    """Status, code and sentence of an error."""
    match error:
        case Refusal():
            return error
        case MoireIdError() if is_away(error):
            text = "The database cannot be reached just now; try again in a moment."
            return Refusal(503, "database", text, headers={"Retry-After": "10"})
        case RegistryError() if error.details.get("code") in CODES:
            return Refusal(503, "registry", studio_of(request).sentence(error))
        case MoireIdError():
            return Refusal(422, type(error).__name__, studio_of(request).sentence(error))
        case RequestValidationError():
            words = [
                f"{'.'.join(map(str, one['loc'][1:])) or one['loc'][0]}: {one['msg']}" for one in error.errors()[:5]
            ]
            return Refusal(422, "fields", "The request cannot be used: " + "; ".join(words) + ".")
        case HTTPException():
            code, text = WORDS.get(error.status_code, ("refused", str(error.detail)))
            return Refusal(error.status_code, code, text, headers=dict(error.headers or {}))
        case ClientDisconnect():
            # The client does not read this answer, but without one the server would log an error.
            return Refusal(400, "broken_off", "The request was broken off; send it again.")
    # The server raises the error again after this answer, so its log has the whole story.  The answer passes no guard.
    return Refusal(500, "system", "Something went wrong inside moireid; the server's log says what.", headers=HEADERS)


async def answer(request: Request, failed: Exception) -> Response:
    """The answer to a request that was refused, or failed."""
    error = refusal_of(request, failed)
    if request.url.path.startswith("/api/") or request.url.path == "/openapi.json":
        return JSONResponse({"code": error.code, "text": error.text}, error.status, headers=error.headers)
    template = "login.html.j2" if error.status == 401 else "problem.html.j2"
    response = render(request, template, status=error.status, problem=error)
    response.headers.update(error.headers or {})
    return response
