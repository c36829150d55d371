"""The registry for checks: the badge that a claim means, and whom identification may find.

The command line and the studio both use this, so that a claim has the same meaning in both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.badge import Badge
from moireid.registry.store import Registry


@dataclass(frozen=True)
class Claimed:
    """A claimed badge, its figures as enrolled (None: never measured), and why it was revoked (None: it was not)."""

    badge: Badge
    as_built: AsBuilt | None = None
    revoked: str | None = None


def claimed(registry: Registry, claim: str) -> Claimed:
    """The badge that a claim means.

    Parameters
    ----------
    registry : Registry
    claim : str
        A name, matched exactly after Unicode NFC, or an id.

    Returns
    -------
    Claimed

    Raises
    ------
    RegistryError
        As `Registry.find`: nobody, or several people.
    """
    record = registry.find(claim)
    as_built = as_built_from_json(record.as_built) if record.as_built else None
    return Claimed(record.badge, as_built, record.revoked_reason)


@dataclass(frozen=True)
class People:
    """A registry as identification sees it."""

    registry: Registry

    def holds(self, badge_id: str) -> bool:
        """Whether that id is enrolled and not revoked."""
        found = self.registry.by_id(badge_id)
        return found is not None and found.revoked_at is None

    def alike(self, parts: Mapping[int, str]) -> list[str]:
        """The ids of which a part reads so, revoked or not."""
        return self.registry.ids_alike(parts)

    def name(self, badge_id: str | None) -> str | None:
        """Who holds that id, if anybody."""
        record = self.registry.by_id(badge_id) if badge_id else None
        return record.name if record else None
