"""The registry by API: who holds which badge.  To read, and no more."""

from __future__ import annotations

import json
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi import Path as InPath
from pydantic import BaseModel

from moireid.registry import Record
from moireid.web.problems import Refusal, problem_responses
from moireid.web.roles import Visitor, require
from moireid.web.studio import studio_of

router = APIRouter(prefix="/api/registry")

Reader = Annotated[Visitor, require("issuer", "verifier")]
BadgeId = Annotated[str, InPath(pattern="^[0-9a-fA-F]{4,64}$")]
MOST = 100


class Held(BaseModel):
    """One record, as `moireid registry list --json` tells it."""

    id: str
    name: str
    issued_at: str
    revoked_at: str | None
    revoked_reason: str | None


class Holders(BaseModel):
    """Those that were found, by name."""

    badges: list[Held]


class Shown(Held):
    """One record whole, as `moireid registry show --json` tells it."""

    fingerprint: str
    badge: dict[str, Any]
    as_built_at: str | None
    as_built: dict[str, Any] | None


def _held(record: Record) -> dict[str, Any]:
    return {
        "id": record.id, "name": record.name, "issued_at": record.issued_at, "revoked_at": record.revoked_at,
        "revoked_reason": record.revoked_reason,
    }  # fmt: skip


@router.get("", responses=problem_responses(401, 403, 422))
def search(
    request: Request, visitor: Reader, search: Annotated[str, Query(max_length=200)] = "",
    limit: Annotated[int, Query(ge=1, le=MOST)] = 20,
) -> Holders:  # fmt: skip
    """Whose name holds a text, or whose id begins with it; by name."""
    found = studio_of(request).registry.search(search, limit)
    return Holders(badges=[Held(**_held(record)) for record in found])


@router.get("/{badge_id}", responses=problem_responses(401, 403, 404, 422))
def show(request: Request, badge_id: BadgeId, visitor: Reader) -> Shown:
    """The record of one badge, by id."""
    registry = studio_of(request).registry
    record = registry.by_id(badge_id)
    if record is None:
        raise Refusal(404, "no_badge", "No badge of this id is in the registry.")
    return Shown(
        **_held(record), fingerprint=registry.fingerprint, badge=json.loads(record.badge.to_json()),
        as_built_at=record.as_built_at, as_built=None if record.as_built is None else json.loads(record.as_built),
    )  # fmt: skip
