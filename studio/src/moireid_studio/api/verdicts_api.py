"""The verdicts that this studio gave, for admins."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from pydantic import BaseModel, Field

from moireid_studio.auth.guard import Visitor, require
from moireid_studio.problems import problem_responses
from moireid_studio.studio import studio_of

router = APIRouter(prefix="/api/verdicts")
Admin = Annotated[Visitor, require("admin")]
MOST = 500


class Verdict(BaseModel):
    """One verdict; neither film nor names are kept."""

    number: int
    at: str
    token: str = Field(description="The id of the token that asked.")
    kind: str = Field(description="verify, identify, live, call or link.")
    film_sha256: str | None = Field(description="Of the film as it came; null of live pictures.")
    claim: str | None = Field(description="The id of the claimed badge.")
    claim_source: str | None
    verdict: str
    read: str | None = Field(description="The id that the film was found to show.")
    registry: str | None = Field(description="Fingerprint and head of the registry that was asked.")
    moireid: str


class VerdictList(BaseModel):
    """Verdicts, the newest first; `keep_days`: so long each is kept."""

    keep_days: float
    verdicts: list[Verdict]


@router.get("", responses=problem_responses(401, 403, 422))
def given(
    request: Request,
    visitor: Admin,
    limit: Annotated[int, Query(ge=1, le=MOST)] = 100,
    before: Annotated[int | None, Query(ge=1, description="Only those of a lower number: the next page.")] = None,
) -> VerdictList:
    """Who asked, of which film, with which claim, and what came out."""
    studio = studio_of(request)
    found = [Verdict(**one.to_json()) for one in studio.verdicts.given(limit, before)]
    return VerdictList(keep_days=studio.settings.keep_verdicts_days, verdicts=found)
