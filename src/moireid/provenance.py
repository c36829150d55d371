"""Where a claim comes from: a registry vouches for a name, a file vouches for nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge

Source = Literal["registry", "file"]


@dataclass(frozen=True)
class Provenance:
    """Where the claimed badge and its name come from.

    source: "registry" where an authority signed them, "file" where somebody handed them over; file_name: the name in
    such a file, where the registry holds its identity under another one; alike: name and id of enrolled people whose
    names are others and look like the claimed one.
    """

    source: Source
    file_name: str | None = None
    alike: tuple[str, ...] = ()


#: What is known of a badge.json that somebody hands over.
FROM_FILE = Provenance("file")


@dataclass(frozen=True)
class Holder:
    """Who holds a badge, as a registry says: the name; when (UTC, ISO 8601) and why it was revoked, or None."""

    name: str
    revoked_at: str | None = None
    revoked_reason: str | None = None


@dataclass(frozen=True)
class Claimed:
    """A claimed badge, with what a check needs of it.

    Attributes
    ----------
    badge : Badge
        As it was issued.
    as_built : AsBuilt or None
        Its figures as measured at enrolment; None where it was never measured.
    revoked : str or None
        Why it was revoked; None where it was not.
    provenance : Provenance
        Whether the registry vouches for it, or a file names it.
    revoked_at : str or None
        When it was revoked, UTC, ISO 8601; None where it was not.
    """

    badge: Badge
    as_built: AsBuilt | None = None
    revoked: str | None = None
    provenance: Provenance = FROM_FILE
    revoked_at: str | None = None
