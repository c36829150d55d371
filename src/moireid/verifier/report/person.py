"""Whose badge is claimed, and how to speak of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Claimed:
    """Whose badge is claimed: the name, the id, and whether anybody vouches for that name.

    sealed: the id is not known: a bundle, or a studio whose visitor may not issue, keeps it sealed until the very badge
    is read.
    """

    name: str
    badge_id: str | None
    vouched: bool
    sealed: bool = False

    @property
    def possessive(self) -> str:
        """Such as: Ada Lovelace's."""
        return f"{self.name}'s" if self.vouched else "the badge of the file"

    @property
    def whose(self) -> str:
        """Such as: Ada Lovelace's badge."""
        return f"{self.name}'s badge" if self.vouched else "the badge of the file"

    @property
    def holder(self) -> str:
        """Whose badge is claimed, and on whose word."""
        if self.sealed:
            return f"{self.name} (identity sealed)"
        if self.badge_id is None:
            return f"{self.name or 'unnamed board'} (no identity)"
        if not self.vouched:
            return f"a badge named {self.name!r} (from a file, not from a registry)"
        return self.name


def claimed_in(document: Mapping[str, Any]) -> Claimed:
    """The claim of a report, as in its JSON.

    Convention: nobody vouches for a name in a file, so with a file a badge is accepted and never a person.
    """
    badge, identity = document.get("badge") or {}, document.get("identity") or {}
    source, claimed_id = document.get("claim_source"), identity.get("claimed_id")
    sealed = source in ("bundle", "registry") and claimed_id is None
    return Claimed(badge.get("name") or "", claimed_id, source != "file", sealed)
