"""Changes to a badge after its issue: it is revoked or measured, or its holder is erased.

Each change is signed, and an entry of the log says who made it.

Measured figures are only added: those that were in use before stay on record, signed with it, and count too.  So no
set may come in unseen, or any copy would agree with one of them: figures take the place of others only for a reason, or
if the caller found that they agree with those in use (`refines`); a log entry says which.  A badge has at most
`MOST_SETS` sets.

A person is erased on their request: the data are deleted, the log stays, and an entry says so.
The row is deleted: name, badge, reason of a revocation, measured figures, and the salt.  The log keeps
the badge's identity, which is a random number, and hashes against which no one can test names without that salt.  The
signed entry `erase` stays as a marker.  The identity is never issued again.

The data are also removed from the disk, because a database keeps old rows in unused pages.  SQLite overwrites what it
deletes (`secure_delete`, set in engine.py), and VACUUM writes the file anew.
PostgreSQL writes the tables anew, and its statistics, which hold values of columns.  Not removed: copies and backups,
PostgreSQL's write-ahead log until it is recycled, and blocks that a disk keeps by itself.
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from sqlalchemy import delete

from moireid.errors import RegistryError
from moireid.registry.canonical import utc_now
from moireid.registry.engine import clean
from moireid.registry.ledger import Transaction
from moireid.registry.log import ERASE, REFINED, REPLACED
from moireid.registry.queries import RegistryQueries
from moireid.registry.record import Record, storable, storable_json
from moireid.registry.schema import badges, select_records

#: A reason is shown to everyone who checks the badge, so it must be short.
LONGEST_REASON = 500
#: Sets of measured figures that a badge can have; a film may be compared with each of them.
MOST_SETS = 8


class RegistryChanges(RegistryQueries):
    """The methods of a registry that change an issued badge.

    Attributes
    ----------
    actor : str
        The person or account that makes the changes.
    shown_url : str
        The registry's URL, for messages.
    """

    def revoke(self, claim: str, reason: str) -> Record:
        """Revoke a badge, for good.

        Parameters
        ----------
        claim : str
            A name or an id, as `find`.
        reason : str
            One line of at most 500 letters.

        Returns
        -------
        Record
            The revoked record.

        Raises
        ------
        RegistryError
            If the claim means no one or several people, the reason is empty, or the badge is revoked already.

        Notes
        -----
        Films from before that day are rejected too: a film's own date can be forged.
        """
        said, found = checked_reason(reason), self.find(claim)
        with self._ledger.writing(self.actor) as transaction:
            record = locked(transaction, found)
            if record.revoked_at is not None:
                raise RegistryError(
                    f"badge {record.id} of {record.name!r} was revoked already on {record.revoked_at} "
                    f"({record.revoked_reason}); nothing is changed",
                    id=record.id,
                    revoked_at=record.revoked_at,
                )
            return transaction.change(replace(record, revoked_at=utc_now(), revoked_reason=said), "revoke")

    def store_as_built(
        self, badge_id: str, document_json: str, *, reason: str | None = None, refines: str | None = None
    ) -> Record:
        """Store measured figures of a badge; storing the same again changes nothing.

        Parameters
        ----------
        badge_id : str
            Hex digits of any case.
        document_json : str
            A JSON object.
        reason : str, optional
            Why they take the place of figures that are in use: one line of at most 500 letters.
        refines : str, optional
            `Record.as_built` of the figures in use, if these agree with them and add what they lack.

        Returns
        -------
        Record
            The record with these figures; others that were in use are in its `earlier_figures`.

        Raises
        ------
        RegistryError
            If the id is not issued, or the text is no JSON object that can be stored; or if other figures are in use,
            and neither a reason is given, nor `refines` is those.
        """
        said = None if reason is None else checked_reason(reason)
        try:
            document = json.loads(document_json)
        except (json.JSONDecodeError, RecursionError) as error:
            raise RegistryError(f"the measured figures of {badge_id[:40]!r} are not JSON ({error})") from error
        if not isinstance(document, dict):
            raise RegistryError(f"the measured figures of {badge_id[:40]!r} are no JSON object; give one")
        text = storable_json(document, f"the document of measured figures of {badge_id[:40]!r}", "measure anew")
        record = self.by_id(badge_id)
        if record is None:
            raise RegistryError(
                f"no badge of id {badge_id[:40]!r} is in registry {self.shown_url}; enroll it before its figures"
            )
        with self._ledger.writing(self.actor) as transaction:
            record = locked(transaction, record)
            if record.as_built == text:
                return record
            own = {"as_built": json.loads(text), "as_built_at": utc_now(), "as_built_reason": said}
            changed = record.with_figure_sets([*record.figure_sets, own])
            if record.as_built is None:
                return transaction.change(changed, "as_built")
            _check_replaces(record, said, refines)
            return transaction.change(changed, REFINED if said is None else REPLACED)

    def erase(self, claim: str) -> tuple[dict[str, Any], bool]:
        """Erase a person on their request, for good; a second call only cleans the database again.

        Parameters
        ----------
        claim : str
            A name or an id, as `find`.

        Returns
        -------
        tuple of dict and bool
            The log's entry as in `entries`; and whether the database was written anew, so that no page of it holds what
            was erased.

        Raises
        ------
        RegistryError
            If the claim means no one, or several people.
        """
        subject = claim.lower()
        if self.erased_at(claim) is None:
            found = self.find(claim)
            subject = found.id
            with self._ledger.writing(self.actor) as transaction:
                locked(transaction, found)
                transaction.connection.execute(delete(badges).where(badges.c.id == subject))
                transaction.log(ERASE, subject)
        return self.entries(subject, 1)[0], clean(self._ledger.engine)


def locked(transaction: Transaction, record: Record) -> Record:
    """The record, read again under the transaction's write lock.

    Raises: RegistryError if it was removed meanwhile; Fault if it is not its newest version, which a change would sign.
    """
    holders = transaction.records(select_records().where(badges.c.id == record.id))
    if not holders:
        raise RegistryError(f"badge {record.id} was taken out of registry {transaction.ledger.shown} meanwhile")
    transaction.tree.newest_entry(record.id, holders[0].digest())
    return holders[0]


def _check_replaces(record: Record, reason: str | None, refines: str | None) -> None:
    """Raise RegistryError unless other figures may take the place of those in use."""
    if reason is None and refines != record.as_built:
        raise RegistryError(
            f"badge {record.id} of {record.name!r} has measured figures since {record.as_built_at}, which stay in use; "
            "others take their place only for a reason (replace= and reason=)",
            code="figures_known",
            as_built_at=record.as_built_at,
        )
    if len(record.figure_sets) >= MOST_SETS:
        raise RegistryError(
            f"badge {record.id} of {record.name!r} has {MOST_SETS} sets of measured figures, the most that one can "
            "have; print another badge, and revoke this one",
            code="figures_full",
        )


def checked_reason(text: str) -> str:
    """A reason as it is recorded.  Raises: RegistryError if it is empty, too long, or not one line of text."""
    if not 0 < len(text.strip()) <= LONGEST_REASON or not storable(text):
        raise RegistryError(
            f"the reason {text[:80]!r} cannot be recorded; give one in plain words on a single line of at most "
            f"{LONGEST_REASON} letters"
        )
    return text.strip()
