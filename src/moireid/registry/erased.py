"""Ids whose holders were erased: they are never issued again."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import Connection, select

from moireid.errors import RegistryError
from moireid.registry import schema
from moireid.registry.engine import (
    chunks,
)
from moireid.registry.log import (
    ERASE,
)


def erased_among(connection: Connection, ids: Sequence[str]) -> list[str]:
    """Those of some ids whose holders were erased."""
    found: list[str] = []
    for some in chunks(ids):
        query = select(schema.log.c.subject).where(schema.log.c.subject.in_(some), schema.log.c.action == ERASE)
        found += connection.scalars(query)
    return found


def erased_id(badge_id: str) -> RegistryError:
    """The error for an id that cannot be issued again."""
    return RegistryError(
        f"id {badge_id} was that of a badge whose holder was erased, and is never issued again; print another badge",
        code="erased",
        id=badge_id,
    )
