"""Registry: look a person up, see the record, revoke it with a reason, audit the whole."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Form, Query, Request
from fastapi.responses import RedirectResponse, Response

from moireid_studio.auth.guard import Visitor, require
from moireid_studio.forms import ShortRoute
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.studio import studio_of

router = APIRouter(prefix="/registry", include_in_schema=False, route_class=ShortRoute)
Reader = Annotated[Visitor, require("issuer", "verifier")]
Issuer = Annotated[Visitor, require("issuer")]
SHOWN = 50
#: Log entries of a record that are shown, the newest.
ENTRIES = 20


@router.get("")
def search(request: Request, visitor: Reader, search: Annotated[str, Query(max_length=200)] = "") -> Response:
    """Who holds a badge: all, or those that the text finds."""
    registry = studio_of(request).registry
    # A visitor who only verifies learns no id: name and id are all that a copy of the badge takes.
    ids = visitor.may("issuer")
    found = registry.search(search, SHOWN + 1, ids=ids)
    more, count = len(found) > SHOWN, registry.count()
    return render(request, "registry.html.j2", search=search, found=found[:SHOWN], more=more, count=count, ids=ids)


@router.get("/audit")
def audit_form(request: Request, visitor: Issuer) -> Response:
    """What an audit is, and the button that begins one."""
    return render(request, "audit.html.j2", seen=None)


@router.post("/audit")
def audit(request: Request, visitor: Issuer) -> Response:
    """Hold every signature and the whole log against each other."""
    return render(request, "audit.html.j2", seen=studio_of(request).audit())


@router.get("/{badge_id}")
def show(request: Request, badge_id: str, visitor: Reader) -> Response:
    """One record."""
    studio = studio_of(request)
    record, registry = studio.record(badge_id), studio.registry
    return render(
        request,
        "record.html.j2",
        record=record,
        fingerprint=registry.fingerprint,
        may_revoke=visitor.may("issuer"),
        # A visitor who only verifies need not know who works here.
        entries=registry.entries(record.id, ENTRIES) if visitor.may("issuer") else [],
        may_verify=visitor.may("verifier"),
    )


@router.post("/{badge_id}/revoke")
def revoke(
    request: Request,
    badge_id: str,
    visitor: Issuer,
    reason: Annotated[str, Form(max_length=1000)],
    sure: Annotated[bool, Form()] = False,
) -> Response:
    """Revoke a badge for good, and show the record."""
    studio = studio_of(request)
    record = studio.record(badge_id)
    if not sure:
        raise Refusal(422, "not_sure", "Tick that you are sure: a revocation cannot be taken back.")
    studio.registry.by(visitor.actor).revoke(record.id, reason)
    return RedirectResponse(f"/registry/{record.id}", 303)
