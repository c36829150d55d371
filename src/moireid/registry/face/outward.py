"""What a registry shows to those outside it: its standing, checkpoints, and bundles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from moireid.badge import Badge
from moireid.provenance import Standing
from moireid.registry.bundle.publish import Progress, Published, publish
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.newest import check_newest
from moireid.registry.checkpoints.proof import proof_of
from moireid.registry.checkpoints.standing import check_head, checkpoint_of, standing_of
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
    ) -> Published:
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
