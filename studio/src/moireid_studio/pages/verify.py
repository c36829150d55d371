"""Verify: a film and a claim in, progress, then the verdict with its reasons, plots and the report to keep.

All of it works without JavaScript: the form is posted, and the page of a job reloads until the job has ended.

`course_of` gives what the page's script draws below the film as it plays: the fringes as the law predicts them and as
they were measured, from the signals that a job's process left.  The studio keeps no film.  The visitor's own copy is
played, on the visitor's machine; it is not sent again.

`install` lets the application answer every error with one sentence, on a page or, under /api, as JSON.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, FastAPI, Form, Request
from fastapi import Path as InPath
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, RedirectResponse, Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from moireid.errors import MoireIdError, RegistryError
from moireid.names import CLAIM_LIMIT
from moireid.registry.rollback import CODES
from moireid.verifier.camera.stretches import longest_step_s
from moireid.verifier.report.report_page import KINDS as KINDS_OF
from moireid.verifier.report.report_page import NAME, page_context
from moireid.verifier.report.seconds import Seconds
from moireid_studio.auth.guard import HEADERS, Visitor, require
from moireid_studio.checks import KINDS, Sample, start_job, start_sample
from moireid_studio.jobs.task import SIGNALS
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.receipts import links_about, with_live_checks
from moireid_studio.reports import circumstances_of, kept_file, list_pictures
from moireid_studio.store.database import is_away
from moireid_studio.store.job import Job
from moireid_studio.studio import studio_of

#: Frames that are drawn at most, and digits of their times and places.
MOST_FRAMES, DIGITS = 5000, 4
Row = tuple[float, float, float]


@dataclass(frozen=True)
class Course:
    """What is drawn; times in s of the film's own clock, which begins at `from_s`.

    sha256: of the film as the server received it; frames: time, and where the law puts the fringes and where they
    were seen, in fringe widths; None where they were not seen, and in all three where frames are missing.
    """

    sha256: str
    from_s: float
    to_s: float
    frames: list[list[float | None]]

    def to_json(self) -> dict[str, Any]:
        return {"from_s": self.from_s, "to_s": self.to_s, "frames": self.frames}


def course_of(job: Job, seconds: Seconds | None) -> Course | None:
    """The fringes of a job's film over time; None where its process left none, or none that can be read."""
    result: dict[str, Any] = job.result or {}
    if seconds is None or not job.kept or job.film_sha256 is None:
        return None
    try:
        rows = list(islice(_rows(kept_file(job, SIGNALS).decode()), MOST_FRAMES))
        film = result["cover"]["film_s"]
        first, last = float(film[0]), float(film[1])
    except (Refusal, ValueError, KeyError, TypeError, csv.Error):
        return None
    return Course(job.film_sha256, first, last, _with_gaps(rows)) if len(rows) > 1 else None


def _rows(text: str) -> Iterator[Row]:
    """Time, law and fringes as seen (NaN where they were not seen) of each line.  Raises: ValueError, KeyError."""
    for line in csv.DictReader(io.StringIO(text)):
        row = (float(line["time_s"]), float(line["predicted_rad_0"]), float(line["measured_rad_0"]))
        if not (math.isfinite(row[0]) and math.isfinite(row[1])):
            raise ValueError("a frame has no time, or no place")
        known = math.isfinite(float(line["phase_sd_rad_0"]))
        yield row if known else (row[0], row[1], math.nan)


def _with_gaps(rows: list[Row]) -> list[list[float | None]]:
    """The rows in fringe widths, with an empty one wherever frames are missing."""
    longest, found, before = longest_step_s(np.array([row[0] for row in rows])), list[list[float | None]](), rows[0][0]
    for time_s, law, seen in rows:
        if time_s - before > longest:
            found.append([None, None, None])
        before = time_s
        widths = [round(value / (2 * math.pi), DIGITS) if math.isfinite(value) else None for value in (law, seen)]
        found.append([round(time_s, DIGITS), *widths])
    return found


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
    report = with_live_checks(studio_of(request), job)
    shown = page_context(report, list_pictures(job), known, lambda name: f"/verify/{job.id}/picture/{name}")
    about = links_about(studio_of(request), job)
    shown |= {"ask_about": job.claim_source == "registry" and job.film_sha256 is not None}
    shown |= {"waiting": sum(link.state in ("waiting", "opened", "running") for link in about)}
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


#: Sentences for a status where the framework gives none.
WORDS = {
    404: ("not_found", "There is nothing at this address."),
    405: ("method", "This address does not take such a request."),
    400: ("bad_request", "This request cannot be read."),
}


def install(app: FastAPI) -> None:
    """Let the application answer every error in our words."""
    for kind in (Refusal, MoireIdError, RequestValidationError, HTTPException, ClientDisconnect, Exception):
        app.add_exception_handler(kind, _answered)


async def _answered(request: Request, error: Exception) -> Response:
    return answer(request, refusal_of(request, error))


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


def answer(request: Request, error: Refusal) -> Response:
    """The answer to a request that was refused."""
    if request.url.path.startswith("/api/") or request.url.path == "/openapi.json":
        return JSONResponse({"code": error.code, "text": error.text}, error.status, headers=error.headers)
    template = "login.html.j2" if error.status == 401 else "problem.html.j2"
    response = render(request, template, status=error.status, problem=error)
    response.headers.update(error.headers or {})
    return response
