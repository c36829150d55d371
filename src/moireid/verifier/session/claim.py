"""What a film is checked against."""

from __future__ import annotations

from dataclasses import dataclass

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge


@dataclass(frozen=True)
class Claim:
    """What is held against the film: the badge, the id that must be read, and the badge as it was enrolled.

    badge: of the claim, or any badge of the same layout; badge_id: None where no identity is claimed; focal_px: where
    it is known; require_original: reject a copy, and leave open what cannot be told from one.
    """

    badge: Badge
    badge_id: str | None = None
    focal_px: float | None = None
    as_built: AsBuilt | None = None
    require_original: bool = False
