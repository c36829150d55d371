"""Changes to a badge after its issue: it is revoked for good, suspended or reinstated.

Each change is signed, and an entry of the log says who made it.

Convention: days are ISO 8601, such as 2027-05-03, in UTC.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from datetime import date

from moireid.errors import RegistryError, SpecError
from moireid.registry.canonical import utc_now
from moireid.registry.ledger import Transaction
from moireid.registry.queries import RegistryQueries
from moireid.registry.record import Record, storable
from moireid.registry.schema import badges, select_records

#: A reason is shown to everyone who checks the badge, so it must be short.
LONGEST_REASON = 500


class RegistryChanges(RegistryQueries):
    """The methods of a registry by which an issued badge stops counting, or counts again.

    Attributes
    ----------
    actor : str
        The person or account that makes the changes.
    """

    actor: str

    def revoke(self, claim: str, reason: str, since: str | None = None) -> Record:
        """Revoke a badge, for good.

        Parameters
        ----------
        claim : str
            A name or an id, as `find`.
        reason : str
            One line of at most 500 letters.
        since : str, optional
            The first day on which another person may have had it, such as 2026-05-01; None if that is not known.

        Returns
        -------
        Record
            The revoked record.

        Raises
        ------
        RegistryError
            If the claim means no one or several people, the reason is empty, or the badge is revoked already.
        SpecError
            If `since` is no day, or is in the future.

        Notes
        -----
        Films from before that day are rejected too: a film's own date can be forged.
        """
        said, day = _reason(reason), None if since is None else compromise_day(since)

        def revoked(old: Record) -> Record:
            return replace(old, revoked_at=utc_now(), revoked_reason=said, compromised_since=day)

        return self._decide(claim, "revoke", revoked)

    def suspend(self, claim: str, reason: str) -> Record:
        """Suspend a badge: it counts for nothing until it is reinstated.

        Parameters
        ----------
        claim : str
            A name or an id, as `find`.
        reason : str
            One line of at most 500 letters.

        Returns
        -------
        Record
            The suspended record.

        Raises
        ------
        RegistryError
            As `revoke`; also if it is suspended already.
        """
        said = _reason(reason)

        def suspended(old: Record) -> Record:
            if old.suspended_at is not None:
                raise RegistryError(
                    f"badge {old.id} of {old.name!r} was suspended already on {old.suspended_at} "
                    f"({old.suspended_reason}); nothing is changed",
                    id=old.id,
                    suspended_at=old.suspended_at,
                )
            return replace(old, suspended_at=utc_now(), suspended_reason=said)

        return self._decide(claim, "suspend", suspended)

    def reinstate(self, claim: str) -> Record:
        """End the suspension of a badge.

        Parameters
        ----------
        claim : str
            A name or an id, as `find`.

        Returns
        -------
        Record
            The record, as it was before the suspension.

        Raises
        ------
        RegistryError
            If the claim means no one or several people, or the badge is not suspended, or is revoked.
        """

        def reinstated(old: Record) -> Record:
            if old.suspended_at is None:
                raise RegistryError(f"badge {old.id} of {old.name!r} is not suspended; nothing is changed", id=old.id)
            return replace(old, suspended_at=None, suspended_reason=None)

        return self._decide(claim, "reinstate", reinstated)

    def _decide(self, claim: str, action: str, change: Callable[[Record], Record]) -> Record:
        """Change a record in a transaction.  Raises: RegistryError if it is revoked already."""
        found = self.find(claim)
        with self._ledger.writing(self.actor) as transaction:
            record = locked(transaction, found)
            if record.revoked_at is not None:
                raise RegistryError(
                    f"badge {record.id} of {record.name!r} was revoked already on {record.revoked_at} "
                    f"({record.revoked_reason}); nothing is changed",
                    id=record.id,
                    revoked_at=record.revoked_at,
                )
            return transaction.change(change(record), action)


def locked(transaction: Transaction, record: Record) -> Record:
    """The record, read again under the transaction's write lock.  Raises: RegistryError if it was removed meanwhile."""
    holders = transaction.records(select_records().where(badges.c.id == record.id))
    if not holders:
        raise RegistryError(f"badge {record.id} was taken out of registry {transaction.ledger.shown} meanwhile")
    return holders[0]


def _reason(text: str) -> str:
    """A reason as it is recorded.  Raises: RegistryError if it is empty, too long, or not one line of text."""
    if not 0 < len(text.strip()) <= LONGEST_REASON or not storable(text):
        raise RegistryError(
            f"the reason {text[:80]!r} cannot be recorded; give one in plain words on a single line of at most "
            f"{LONGEST_REASON} letters"
        )
    return text.strip()


_DAY = re.compile(r"\d{4}-\d{2}-\d{2}")


def expiry_day(text: str) -> str:
    """The last day on which a badge counts.  Raises: SpecError if it is no day, or in the past."""
    day, today = _day(text, "expiry"), utc_now()[:10]
    if day < today:
        raise SpecError(f"the day of expiry {day} is over (today is {today}); give one to come")
    return day


def compromise_day(text: str) -> str:
    """The day from which a badge's films count for nothing.  Raises: SpecError if it is no day, or in the future."""
    day, today = _day(text, "compromise"), utc_now()[:10]
    if day > today:
        raise SpecError(f"the day of compromise {day} is to come (today is {today}); give the first day of doubt")
    return day


def _day(text: str, what: str) -> str:
    try:
        # `fromisoformat` also reads 20270503 and 2027-W18-1, which do not compare as text.
        if not _DAY.fullmatch(text):
            raise ValueError
        return date.fromisoformat(text).isoformat()
    except ValueError as error:
        raise SpecError(f"the day of {what} {text[:40]!r} is none; give one such as 2027-05-03") from error
