"""The Issue pages: one person, or everybody at an event."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request
from fastapi.responses import RedirectResponse, Response

from moireid.designer.lists import decoded
from moireid.errors import MoireIdError
from moireid.web.auth.roles import Visitor, require
from moireid.web.forms import Fields, form_fields
from moireid.web.issue_jobs import package_of, start_badge, start_event
from moireid.web.jobs.issue_work import MOST_AT_AN_EVENT, understood
from moireid.web.jobs.orders import Order, Wish, checked, read_fields
from moireid.web.pages.issue_words import sentences
from moireid.web.pages.preview_law import preview_law
from moireid.web.pages.render import render
from moireid.web.studio import studio_of

router = APIRouter(include_in_schema=False)
Sent = Annotated[Fields, Depends(form_fields)]
Issuer = Annotated[Visitor, require("issuer")]


@router.get("/issue")
def issue_page(request: Request, visitor: Issuer) -> Response:
    """The empty form."""
    return _page(request, {})


@router.post("/issue")
def issue(request: Request, sent: Sent, visitor: Issuer) -> Response:
    """Show what would be made; or make it, if the visitor need not see a warning first."""
    studio = studio_of(request)
    try:
        order: Order = read_fields(Order, sent.texts)
        # What was drawn to be shown is what is issued then.
        order = order if order.payload else order.model_copy(update={"payload": sent.texts.get("drawn", "")})
        found = checked(order, studio.registry)
        told = found.to_read is None or sent.texts.get("told") == found.to_read
        if sent.texts.get("do") == "issue" and told:
            return RedirectResponse(f"/issue/jobs/{start_badge(studio, order.of(found.badge), visitor).id}", 303)
    except MoireIdError as error:
        return _page(request, sent.texts, status=422, problem=studio.sentence(error))
    return _page(request, sent.texts, checked=found, law=preview_law(found.badge), sentences=sentences(found))


@router.get("/issue/event")
def event_page(request: Request, visitor: Issuer) -> Response:
    """The empty form."""
    return _event(request, {}, "")


@router.post("/issue/event")
def event(request: Request, sent: Sent, visitor: Issuer) -> Response:
    """Show how the list was understood; or issue all badges, if no row has a fault."""
    studio = studio_of(request)
    data = sent.files.get("people_file") or sent.texts.get("people", "").encode("utf-8", "replace")
    text = ""
    try:
        text, _ = decoded(data)
        wish: Wish = read_fields(Wish, sent.texts)
        rows, guessed = understood(data, wish, studio.registry)
        faults = sum(row["fault"] is not None for row in rows)
        if sent.texts.get("do") == "issue" and not faults:
            return RedirectResponse(f"/issue/jobs/{start_event(studio, data, wish, visitor).id}", 303)
    except MoireIdError as error:
        return _event(request, sent.texts, text, status=422, problem=studio.sentence(error))
    return _event(
        request,
        sent.texts,
        text,
        status=422 if faults else 200,
        rows=rows,
        faults=faults,
        guessed=guessed,
        sound=not faults,
    )


@router.get("/issue/jobs/{job_id}")
def issue_job(request: Request, job_id: str, visitor: Issuer) -> Response:
    """Progress, then the package."""
    studio = studio_of(request)
    job = studio.jobs.find(job_id, visitor.id, "badge", "event")
    if job.state != "done":
        again = "/issue" if job.kind == "badge" else "/issue/event"
        problem = studio.sentence(job.problem[1]) if job.problem else None
        return render(request, "making.html.j2", job=job, again=again, problem=problem)
    minutes = round(studio.settings.limits.keep_s / 60)
    return render(request, "issued.html.j2", job=job, made=job.result, minutes=minutes)


@router.get("/issue/jobs/{job_id}/package.zip")
def issue_package(request: Request, job_id: str, visitor: Issuer) -> Response:
    """Everything as one download."""
    return package_of(studio_of(request).jobs.find(job_id, visitor.id, "badge", "event"))


def _page(request: Request, given: dict[str, str], *, status: int = 200, **shown: object) -> Response:
    context = {"checked": None, "problem": None, "mount_default": "lanyard"} | shown
    return render(request, "issue.html.j2", status=status, given=given, **context)


def _event(request: Request, given: dict[str, str], people: str, *, status: int = 200, **shown: object) -> Response:
    context = {
        "rows": [],
        "faults": 0,
        "guessed": None,
        "sound": False,
        "problem": None,
        "mount_default": "none",
    } | shown
    return render(request, "event.html.j2", status=status, given=given, people=people, most=MOST_AT_AN_EVENT, **context)
