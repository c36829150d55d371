"""Verify: a film and a claim in, progress, then the verdict with its reasons, plots and the report to keep.

All of it works without JavaScript: the form is posted, and the page of a job reloads until the job has ended.
"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Request
from fastapi import Path as InPath
from fastapi.responses import FileResponse, RedirectResponse, Response

from moireid.verifier.report.page import SAYS, SAYS_NOT, words_of
from moireid.web.auth.roles import Visitor, require
from moireid.web.checks import KINDS, start_job
from moireid.web.jobs.queue import Job
from moireid.web.pages.render import render
from moireid.web.problems import Refusal
from moireid.web.studio import studio_of

router = APIRouter(prefix="/verify", include_in_schema=False)

Verifier = Annotated[Visitor, require("verifier")]
#: A plot has its own style; it is shown as a picture, and may run and load nothing.
PICTURE_POLICY = {"Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; sandbox"}
MOST_PLOTS = 16
FINDINGS = {
    "found": "The fringes moved as only a real badge's do, and the badge is enrolled.",
    "nobody": "This is nobody's badge, as far as this registry knows.",
    "inconclusive": "This film does not show enough to find out whose badge it is.",
}


@router.get("")
def form(request: Request, visitor: Verifier, claim: str = "") -> Response:
    """Choose a film, and say whose badge it shows."""
    return render(request, "verify.html.j2", limits=studio_of(request).settings.limits, claim=claim[:200])


@router.post("")
async def begin(request: Request, visitor: Verifier) -> Response:
    """Take the film, and go to the page of its job."""
    job = await start_job(request, visitor, report=True)
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
    colour, title, words = _headline(job)
    return render(
        request,
        "verdict.html.j2",
        job=job,
        result=job.result,
        kept_for=kept,
        says=SAYS,
        says_not=SAYS_NOT,
        colour=colour,
        title=title,
        words=words,
    )


def _headline(job: Job) -> tuple[str, str, str]:
    """Colour, title and sentence of a verdict or a finding."""
    result = job.result or {}
    if "finding" in result:
        finding = result["finding"]
        colour = {"found": "accept", "nobody": "reject"}.get(finding, "inconclusive")
        title = {"found": f"✓ {result['found_name']}", "nobody": "✗ Nobody", "inconclusive": "? Inconclusive"}[finding]
        return colour, title, FINDINGS[finding]
    verdict = result["verdict"]
    title = {"accept": "✓ Accepted", "reject": "✗ Rejected", "inconclusive": "? Inconclusive"}[verdict]
    law, identity = (result[part]["verdict"] for part in ("invariant", "identity"))
    return verdict, title, words_of(verdict, law, identity, result["claim_source"])


@router.get("/{job_id}/plot/{number}")
def plot(
    request: Request, job_id: str, number: Annotated[int, InPath(ge=0, lt=MOST_PLOTS)], visitor: Verifier
) -> Response:
    """One plot of the report."""
    return _file(studio_of(request).jobs.find(job_id, visitor.id, *KINDS), f"plot{number}.svg", "image/svg+xml")


@router.get("/{job_id}/badge")
def badge(request: Request, job_id: str, visitor: Verifier) -> Response:
    """The badge as the film shows it."""
    return _file(studio_of(request).jobs.find(job_id, visitor.id, *KINDS), "badge.png", "image/png")


def _file(job: Job, name: str, kind: str) -> Response:
    path = job.folder / name
    if not job.over or not path.is_file():
        raise Refusal(404, "no_picture", "There is no such picture.")
    return FileResponse(path, media_type=kind, headers=PICTURE_POLICY)
