"""What is decided of a badge after its issue: revoked for good, suspended, reinstated.

Each is signed, and an entry of the log says who did it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from moireid.errors import RegistryError
from moireid.registry.canonical import utc_now
from moireid.registry.face.outward import compromise_day
from moireid.registry.face.reading import RegistryQueries
from moireid.registry.ledger import Transaction
from moireid.registry.record import Record, storable
from moireid.registry.schema import badges, select_records

#: A reason is shown to everyone who checks the badge, so it must be short.
LONGEST_REASON = 500


class Deciding(RegistryQueries):
    """The part of a registry by which badges stop to count, and count again.

    Attributes
    ----------
    actor : str
        Who does what is done with it.
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
            The day from which on it may have been in other hands, such as 2026-05-01; None where nobody knows.

        Returns
        -------
        Record
            The revoked record.

        Raises
        ------
        RegistryError
            Where nobody or more than one is meant, the reason is empty, or it is revoked already.
        SpecError
            Where `since` is no day, or one to come.

        Notes
        -----
        Films of before that day are rejected too: a film's own date can be forged.
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
            As `revoke`; also where it is suspended already.
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
            Where nobody or more than one is meant, or it is not suspended, or revoked.
        """

        def reinstated(old: Record) -> Record:
            if old.suspended_at is None:
                raise RegistryError(f"badge {old.id} of {old.name!r} is not suspended; nothing is changed", id=old.id)
            return replace(old, suspended_at=None, suspended_reason=None)

        return self._decide(claim, "reinstate", reinstated)

    def _decide(self, claim: str, action: str, change: Callable[[Record], Record]) -> Record:
        """Change a record where nobody else can write.  Raises: RegistryError where it is revoked already."""
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
    """The record as it is now that nobody else can write.  Raises: RegistryError where it was taken out meanwhile."""
    holders = transaction.records(select_records().where(badges.c.id == record.id))
    if not holders:
        raise RegistryError(f"badge {record.id} was taken out of registry {transaction.ledger.shown} meanwhile")
    return holders[0]


def _reason(text: str) -> str:
    """A reason as it is recorded.  Raises: RegistryError where it cannot be."""
    if not 0 < len(text.strip()) <= LONGEST_REASON or not storable(text):
        raise RegistryError(
            f"the reason {text[:80]!r} cannot be recorded; give one in plain words on a single line of at most "
            f"{LONGEST_REASON} letters"
        )
    return text.strip()
