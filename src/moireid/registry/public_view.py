"""What a registry gives to outsiders so that they can check it: its standing, checkpoints, proofs and bundles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from moireid.badge import Badge
from moireid.provenance import Standing
from moireid.registry.bundle.publish import Progress, PublishResult, publish
from moireid.registry.checkpoints.checkpoint import ORIGIN, Checkpoint, signed_state
from moireid.registry.checkpoints.cosignature import Quorum
from moireid.registry.checkpoints.coverage import WitnessedPart, witnessed_part
from moireid.registry.checkpoints.newest import check_newest
from moireid.registry.checkpoints.note import authority_key
from moireid.registry.checkpoints.proof import proof_of
from moireid.registry.keys import as_fingerprint
from moireid.registry.queries import RegistryQueries
from moireid.registry.record import Record


class PublicView(RegistryQueries):
    """The methods of a registry with which outsiders can check it."""

    def standing(self, trust: str | None = None) -> Standing:
        """Compare the registry with what this user saw of it before, and remember its present state.

        Parameters
        ----------
        trust : str, optional
            The fingerprint of the one authority that counts from now on, as long as the registry is open; None for the
            one that was seen here first.

        Returns
        -------
        Standing
            Its authority and head.

        Raises
        ------
        RegistryError
            If its key was replaced, or it was rolled back or forked; `error.details["code"]` says which.
        SpecError
            If `trust` is no fingerprint.
        """
        self._ledger.trust = None if trust is None else as_fingerprint(trust)
        return self._ledger.standing()

    @property
    def log_key(self) -> str:
        """The public key of its log, as witnesses are given it (C2SP signed-note)."""
        authority = self._ledger.authority
        return str(authority_key(ORIGIN + authority.fingerprint, authority))

    def check_head(self) -> None:
        """Raise RegistryError as `standing`: for those who are about to do long work before they read or write."""
        self._ledger.standing()

    def check_newest(self, record: Record) -> None:
        """Check a record that the user relies on against the log, entry by entry, up to the signed head.

        Parameters
        ----------
        record : Record
            As this registry gave it.

        Raises
        ------
        RegistryError
            If the log was changed since that version was entered: the badge may have been revoked.
        """
        check_newest(self._ledger, record)

    def prove(self, record: Record) -> str:
        """Prove to a person without the registry that a record's newest version is in the log.

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
            If the record is not the newest one, or the private key is not on this machine.
        """
        return proof_of(self._ledger, record)

    def checkpoint(self, older: Sequence[Checkpoint] = ()) -> tuple[Checkpoint, list[tuple[int, list[bytes]]]]:
        """Sign the log as it is now, for others to keep.

        Parameters
        ----------
        older : sequence of Checkpoint
            Earlier checkpoints, which the log must still extend.

        Returns
        -------
        tuple
            The checkpoint; and for each older one its size, and the proof of `merkle.consistent`.

        Raises
        ------
        RegistryError
            If the registry was put back to an earlier state, or does not begin as an older checkpoint says: a log
            signs nothing that contradicts what it signed before.
        """
        return signed_state(self._ledger, older)

    def require_witnesses(self, checkpoint: Checkpoint, quorum: Quorum, source: str = "") -> WitnessedPart:
        """From now on rely only on badges that witnesses have seen, in this registry as it is open.

        Parameters
        ----------
        checkpoint : Checkpoint
            One of this registry that the witnesses signed.
        quorum : Quorum
            The witnesses, and how many must have signed.
        source : str
            Names the checkpoint in messages.

        Returns
        -------
        WitnessedPart
            How many entries they have seen, who signed, and when.

        Raises
        ------
        RegistryError
            If the checkpoint is another registry's, too few witnesses signed it, or the log does not begin as it says;
            `error.details["code"]` says which.  From then on, `check_newest` raises it, with code "not_witnessed", for
            a badge that counts and whose newest entry is later than the checkpoint.
        """
        return witnessed_part(self._ledger, checkpoint, quorum, source or f"of {checkpoint.date}")

    def publish(
        self,
        path: Path | str,
        specimen: Callable[[Badge], Badge],
        *,
        days: float,
        overwrite: bool = False,
        progress: Progress | None = None,
        checkpoint: Checkpoint | None = None,
    ) -> PublishResult:
        """Write a trust bundle, whole or not at all.

        Parameters
        ----------
        path : Path or str
            The file.
        specimen : callable
            Makes a badge without a person from one of the same layout: `moireid.idcodes.specimen_of`.
        days : float
            How long the bundle counts.
        overwrite : bool
            Whether an older file may be replaced.
        progress : callable, optional
            Called with people done and in all.
        checkpoint : Checkpoint, optional
            Of the log as it is now, to which witnesses may have added their signatures; None for one that is signed
            now.

        Returns
        -------
        PublishResult
            How many people it holds, and until when it counts.

        Raises
        ------
        RegistryError
            If something in the registry is not as signed, it was put back, its private key is absent, or the checkpoint
            is of another state of the log.
        SpecError
            If the file exists and `overwrite` is false, or cannot be written.
        """
        return publish(
            self._ledger,
            Path(path),
            specimen,
            days=days,
            overwrite=overwrite,
            progress=progress,
            checkpoint=checkpoint,
        )
