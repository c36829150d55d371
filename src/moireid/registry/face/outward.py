"""What a registry shows to those outside it: its standing, checkpoints, and bundles.

Days that people give with a badge: until when it counts, and since when it is compromised.

Convention: ISO 8601, such as 2027-05-03, in UTC.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path

from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.provenance import Standing
from moireid.registry.bundle.publish import Progress, PublishResult, publish
from moireid.registry.canonical import utc_now
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.proof import proof_of
from moireid.registry.checkpoints.seen import check_newest
from moireid.registry.checkpoints.witness import check_head, checkpoint_of, standing_of
from moireid.registry.ledger import Ledger
from moireid.registry.record import Record


class Outward:
    """The part of a registry that others hold it by.

    Parameters
    ----------
    ledger : Ledger
        Tables and log.
    """

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger

    def standing(self, trust: str | None = None) -> Standing:
        """Hold the registry against what this user saw of it before, and remember it as it is now.

        Parameters
        ----------
        trust : str, optional
            The fingerprint of the one authority that counts; None for the one that was seen here first.

        Returns
        -------
        Standing
            Its authority and head.

        Raises
        ------
        RegistryError
            Where its key was replaced, or it was rolled back or forked; `error.details["code"]` says which.
        SpecError
            Where `trust` is no fingerprint.
        """
        return standing_of(self._ledger, trust)

    def check_head(self) -> None:
        """Raise RegistryError if the log was further before: whoever wrote to an earlier state would fork it."""
        check_head(self._ledger)

    def check_newest(self, record: Record) -> None:
        """Hold a record that somebody relies on against the log, entry by entry, up to its signed head.

        Parameters
        ----------
        record : Record
            As this registry gave it.

        Raises
        ------
        RegistryError
            Where the log was changed since that version was entered: it may have been revoked.
        """
        check_newest(self._ledger, record)

    def prove(self, record: Record) -> str:
        """Prove to somebody without the registry that a record's newest version is in the log.

        Parameters
        ----------
        record : Record
            As this registry gave it.

        Returns
        -------
        str
            JSON, with a checkpoint that is signed now; `checkpoints.proof.check_proof` reads it.

        Raises
        ------
        RegistryError
            Where the record is not the newest one, or the private key is not here.
        """
        return proof_of(self._ledger, record)

    def checkpoint(self, older: Sequence[Checkpoint] = ()) -> tuple[Checkpoint, list[tuple[int, list[bytes]]]]:
        """Sign the log as it is now, for others to keep.

        Parameters
        ----------
        older : sequence of Checkpoint
            Those that the new one must add to.

        Returns
        -------
        tuple
            The checkpoint; and for each older one its size, and the proof of `merkle.consistent`.

        Raises
        ------
        RegistryError
            Where the registry was put back, or does not begin as an older checkpoint says: a log signs nothing that
            contradicts what it signed.
        """
        return checkpoint_of(self._ledger, older)

    def publish(
        self,
        path: Path | str,
        specimen: Callable[[Badge], Badge],
        *,
        days: float,
        overwrite: bool = False,
        progress: Progress | None = None,
    ) -> PublishResult:
        """Write a trust bundle, whole or not at all.

        Parameters
        ----------
        path : Path or str
            The file.
        specimen : callable
            Makes a badge of nobody from one of the same layout: `moireid.idcodes.specimen_of`.
        days : float
            How long the bundle counts.
        overwrite : bool
            Whether an older file may be replaced.
        progress : callable, optional
            Called with people done and in all.

        Returns
        -------
        Published
            How many people it holds, and until when it counts.

        Raises
        ------
        RegistryError
            Where something in the registry is not as signed, it was put back, or its private key is absent.
        SpecError
            Where the file exists and `overwrite` is false, or cannot be written.
        """
        return publish(self._ledger, Path(path), specimen, days=days, overwrite=overwrite, progress=progress)


_DAY = re.compile(r"\d{4}-\d{2}-\d{2}")


def expiry_day(text: str) -> str:
    """The last day on which a badge counts.  Raises: SpecError where it is no day, or in the past."""
    day, today = _day(text, "expiry"), utc_now()[:10]
    if day < today:
        raise SpecError(f"the day of expiry {day} is over (today is {today}); give one to come")
    return day


def compromise_day(text: str) -> str:
    """The day from which on a badge's films count for nothing.  Raises: SpecError where it is no day, or to come."""
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
