"""What a report shows besides the film: when and by which claim it was checked, and what the registry says.

The process that shows a report fills this in.  Films of strangers are decoded in another process, which never learns
who holds the badge that was read: the holder is looked up after the film is judged.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from moireid.names import name_with_line
from moireid.provenance import BadgeHolder, Revocation, Standing

#: Not by the system's locale: the report is in one language.
MONTHS = (
    *("January", "February", "March", "April", "May", "June"),
    *("July", "August", "September", "October", "November", "December"),
)


@dataclass(frozen=True)
class Circumstances:
    """How a check was made.

    Parameters
    ----------
    checked_at : datetime
        When, with its time zone.
    film_name : str, optional
        The film's name as people know it; None for the name in the report.
    claim : str, optional
        The claim as it was made, if one was.
    barred : Revocation, optional
        Why the claimed badge does not count; None if it does, or if that is not known.
    read : BadgeHolder, optional
        Who holds the badge that was read in the film, according to the registry; None if no one does.
    standing : Standing, optional
        Authority and head of the registry, or of its bundle, that was asked; None if none was.
    registry : str, optional
        Name of the registry or bundle, without its place; None if it is not to be shown.
    """

    checked_at: datetime
    film_name: str | None = None
    claim: str | None = None
    barred: Revocation | None = None
    read: BadgeHolder | None = None
    standing: Standing | None = None
    registry: str | None = None

    @property
    def bundle(self) -> str | None:
        """The last day on which the bundle that was asked counts, in words; None if no bundle was asked."""
        expires = self.standing.expires if self.standing else None
        return None if expires is None else day(expires, self.checked_at)


def read_id(document: Mapping[str, Any]) -> object:
    """The badge whose holder is to be looked up for a report: the one found, or else the one read in the film."""
    return document.get("found_id") or (document.get("identity") or {}).get("decoded_id")


def day(moment: str, now: datetime) -> str:
    """A date in words, such as 3 May; with its year if that is not the present one.

    Parameters: moment: a time in ISO 8601.  Any other text is returned as it is.
    """
    try:
        own = datetime.fromisoformat(moment).astimezone(UTC)
    except ValueError:
        return moment
    year = "" if own.year == now.astimezone(UTC).year else f" {own.year}"
    return f"{own.day} {MONTHS[own.month - 1]}{year}"


def moment_words(moment: datetime) -> str:
    """A time to the minute in UTC, such as 3 May 2026, 14:05 UTC."""
    own = moment.astimezone(UTC)
    return f"{own.day} {MONTHS[own.month - 1]} {own.year}, {own:%H:%M} UTC"


@dataclass(frozen=True)
class ClaimNote:
    """Whose badge is claimed: the name, the id, and whether a registry vouches for that name.

    sealed: the id is not known: a bundle, or a studio for a visitor who may not issue, keeps it sealed until that badge
    is read; line: below the name, which distinguishes people of one name, None where there is none or it is not known.
    """

    name: str
    badge_id: str | None
    vouched: bool
    sealed: bool = False
    line: str | None = None

    @property
    def with_line(self) -> str:
        """The name and the line."""
        return name_with_line(self.name, self.line)

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
        """Whose badge is claimed, and who vouches for the name."""
        if self.sealed:
            return f"{self.name} (identity sealed)"
        if self.badge_id is None:
            return f"{self.name or 'unnamed board'} (no identity)"
        if not self.vouched:
            return f"a badge named {self.name!r} (from a file, not from a registry)"
        return self.name


def claimed_in(document: Mapping[str, Any]) -> ClaimNote:
    """The claim of a report, as in its JSON.

    Convention: no one vouches for a name in a file, so with a file a badge is accepted, and never a person.
    """
    badge, identity = document.get("badge") or {}, document.get("identity") or {}
    source, claimed_id = document.get("claim_source"), identity.get("claimed_id")
    sealed = source in ("bundle", "registry") and claimed_id is None
    return ClaimNote(badge.get("name") or "", claimed_id, source != "file", sealed, badge.get("line"))
