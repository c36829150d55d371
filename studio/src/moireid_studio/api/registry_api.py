"""The registry by API: who holds which badge; issuers revoke and audit."""

from __future__ import annotations

import json
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi import Path as InPath
from pydantic import BaseModel, Field

from moireid_studio.auth.guard import Visitor, require
from moireid_studio.forms import ShortRoute
from moireid_studio.problems import problem_responses
from moireid_studio.studio import studio_of

router = APIRouter(prefix="/api/registry", route_class=ShortRoute)
Reader = Annotated[Visitor, require("issuer", "verifier")]
Issuer = Annotated[Visitor, require("issuer")]
BadgeId = Annotated[str, InPath(pattern="^[0-9a-fA-F]{4,64}$")]
#: Records of one answer.
MOST = 100


class RecordSummary(BaseModel):
    """One record, as `moireid registry list --json` prints it.

    A list gives no id to a visitor who may not issue (null): name and id are all that a copy of the badge takes.
    """

    id: str | None
    name: str
    line: str | None = Field(description="The line below the name on the badge, which distinguishes namesakes.")
    issued_at: str
    revoked_at: str | None
    revoked_reason: str | None


class Holders(BaseModel):
    """Those that were found, by name."""

    badges: list[RecordSummary]


class RecordDetail(RecordSummary):
    """One record, as `moireid registry show --json` prints it.

    A visitor who may not issue gets neither the badge's file nor its measured figures (null), because
    the file is all that a copy takes.
    """

    fingerprint: str
    badge: dict[str, Any] | None
    as_built_at: str | None
    as_built: dict[str, Any] | None


class Reason(BaseModel):
    """Why a badge is revoked, in plain words on a single line."""

    reason: str = Field(min_length=1, max_length=1000)


class Finding(BaseModel):
    """What does not hold, and the id or the entry that it is about."""

    code: str
    text: str
    subject: str | None


class WitnessedPart(BaseModel):
    """The part of the log that witnesses have seen, if an audit asks for witnesses."""

    size: int = Field(description="How many entries.")
    signers: dict[str, str] = Field(description="Which witnesses signed for them, and when (UTC).")


class AuditSummary(BaseModel):
    """What an audit saw, as `moireid registry audit --json` prints it."""

    sound: bool
    fingerprint: str
    badges: int
    revoked: int
    erased: int = Field(description="People who were erased on their wish.")
    entries: int
    head: str | None
    findings: list[Finding]
    found: int
    witnessed: WitnessedPart | None = Field(None, description="Null where none is asked, or one has not signed.")


@router.get("", responses=problem_responses(401, 403, 422))
def search(
    request: Request,
    visitor: Reader,
    search: Annotated[str, Query(max_length=200)] = "",
    limit: Annotated[int, Query(ge=1, le=MOST)] = 20,
) -> Holders:
    """Whose name holds a text, or, for issuers, whose id begins with it; by name."""
    whole = visitor.may("issuer")
    found = studio_of(request).registry.search(search, limit, ids=whole)
    return Holders(badges=[RecordSummary(**record.summary() | ({} if whole else {"id": None})) for record in found])


@router.get("/{badge_id}", responses=problem_responses(401, 403, 404, 422))
def show(request: Request, badge_id: BadgeId, visitor: Reader) -> RecordDetail:
    """The record of one badge, by id."""
    studio = studio_of(request)
    record = studio.record(badge_id)
    whole = visitor.may("issuer")
    return RecordDetail(
        **record.summary(),
        fingerprint=studio.registry.fingerprint,
        badge=json.loads(record.badge.to_json()) if whole else None,
        as_built_at=record.as_built_at,
        as_built=json.loads(record.as_built) if whole and record.as_built else None,
    )


@router.post("/{badge_id}/revoke", responses=problem_responses(400, 401, 403, 404, 408, 413, 422))
def revoke(request: Request, badge_id: BadgeId, why: Reason, visitor: Issuer) -> RecordSummary:
    """Revoke a badge for good."""
    studio = studio_of(request)
    studio.record(badge_id)
    return RecordSummary(**studio.registry.by(visitor.actor).revoke(badge_id, why.reason).summary())


@router.post("/audit", responses=problem_responses(400, 401, 403, 408, 413, 422, 503))
def audit(request: Request, visitor: Issuer) -> AuditSummary:
    """Hold every signature and the whole log against each other."""
    return AuditSummary(**studio_of(request).audit().to_json())
