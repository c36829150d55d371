"""What a film is checked against."""

from __future__ import annotations

from dataclasses import dataclass

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.verifier.limits import MIN_COVER_SHARE


@dataclass(frozen=True)
class Claim:
    """What is held against a film.

    Parameters
    ----------
    badge : Badge
        The claimed badge, or any badge of the same layout.
    badge_id : str, optional
        The id that must be read, hex digits; None where no identity is claimed.
    focal_px : float, optional
        Focal length of the film's camera, px; None where it is not known, and it is then estimated.
    as_built : AsBuilt, optional
        Figures of the badge as it was measured when it was enrolled.
    require_original : bool
        Reject a copy, and leave open what cannot be told from one.
    cover_share : float
        Share of the film, 0 to 1, that the verdict must be of; with less it is inconclusive.
    """

    badge: Badge
    badge_id: str | None = None
    focal_px: float | None = None
    as_built: AsBuilt | None = None
    require_original: bool = False
    cover_share: float = MIN_COVER_SHARE
