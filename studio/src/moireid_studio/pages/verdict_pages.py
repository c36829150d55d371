"""Verdicts: what this studio gave, for admins."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from moireid.registry import holder_of
from moireid_studio.auth.guard import Visitor, require
from moireid_studio.pages.home import render
from moireid_studio.studio import studio_of

router = APIRouter(prefix="/verdicts", include_in_schema=False)
Admin = Annotated[Visitor, require("admin")]
SHOWN = 50
#: Verdicts as people say them.
WORDS = {
    "accept": "accepted",
    "reject": "rejected",
    "inconclusive": "inconclusive",
    "found": "holder found",
    "nobody": "held by no one",
}


@router.get("")
def given(request: Request, visitor: Admin, before: Annotated[int | None, Query(ge=1)] = None) -> Response:
    """A page of them, the newest first; whose a badge is, the registry says now."""
    studio = studio_of(request)
    found = studio.verdicts.given(SHOWN + 1, before)
    notes = {token.id: token.note for token in studio.tokens.all()}
    holders = {one.claim: holder_of(studio.registry, one.claim) for one in found}
    rows = [(one, notes.get(one.token, ""), holders[one.claim]) for one in found[:SHOWN]]
    more = found[SHOWN - 1].number if len(found) > SHOWN else None
    return render(
        request, "verdicts.html.j2", rows=rows, words=WORDS, more=more, keep_days=studio.settings.keep_verdicts_days
    )
