"""What a registry gives to outsiders so that they can check it: its standing, checkpoints and bundles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import timedelta
from pathlib import Path

import msgspec

from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid.files import planned, whole_file
from moireid.provenance import Standing
from moireid.registry.bundle.bundle_file import TIME, BundleContent, now, read_bundle_file, sealed_file
from moireid.registry.bundle.publish import Progress, sealed_people, unsealed_people
from moireid.registry.checkpoints.checkpoint import ORIGIN, Checkpoint, sign_checkpoint
from moireid.registry.checkpoints.cosignature import signers
from moireid.registry.checkpoints.note import VerifierKey, authority_key
from moireid.registry.engine import sqlite_file
from moireid.registry.keys import as_fingerprint
from moireid.registry.merkle import consistency_proof
from moireid.registry.queries import RegistryQueries
from moireid.registry.record import Record
from moireid.registry.rollback import check_begins

#: Who knows an earlier state, in messages.
WITNESSES = "what witnesses have seen"


class PublicView(RegistryQueries):
    """The methods of a registry with which outsiders can check it."""

    def standing(self, trust: str | None = None) -> Standing:
        """Compare the registry with what this user saw of it before, and remember its present state.

        Parameters
        ----------
        trust : str, optional
            The fingerprint of the one authority that counts from now on, as long as the registry is open; None for the
            one that was named before, else the one that was seen here first.

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
        if trust is not None:
            self._ledger.trust = as_fingerprint(trust)
        return self._ledger.standing()

    @property
    def log_key(self) -> str:
        """The public key of its log, as witnesses are given it (C2SP signed-note)."""
        authority = self._ledger.authority
        return str(authority_key(ORIGIN + authority.fingerprint, authority))

    def check_newest(self, record: Record) -> None:
        """Check a record that the user relies on against the log, entry by entry, up to the signed head.

        Parameters
        ----------
        record : Record
            As this registry gave it.

        Raises
        ------
        RegistryError
            If an entry on the way was changed or taken out, or is about another version of the record: the badge may
            have been revoked.  Or if witnesses must have seen it (`require_witnesses`), and it is later than they have;
            what bars a badge counts unseen.

        Notes
        -----
        Reading a record compares it with its newest entry among those that are present.  An attacker who can write to
        the database could put back a record from before its revocation, and change the revocation's entry, or take it
        out.  A proof that the older entry is in the tree does not show that.
        Source: the root over all entries is signed; so no signature on the way counts.  100,000 entries take about a
        second.
        """
        ledger = self._ledger
        with ledger.snapshot() as connection:
            tree = ledger.tree_in(connection)
            newest = tree.newest_entry(record.id, record.digest())
            seen = ledger.witnessed
            if seen is not None:
                check_begins(ledger.called, tree.leaves, seen, WITNESSES)
        if seen is not None and newest > seen.seq and record.barred() is None:
            raise RegistryError(
                f"the record of badge {record.id} is of log entry {newest}, and witnesses have seen {seen.seq}; "
                "get a newer checkpoint from those who run the registry",
                code="not_witnessed",
            )

    def checkpoint(self, earlier: Checkpoint | None = None) -> tuple[Checkpoint, list[bytes]]:
        """Sign the log as it is now, for others to keep.

        Parameters
        ----------
        earlier : Checkpoint, optional
            One that was signed before, which the log must still extend.

        Returns
        -------
        tuple
            The checkpoint; and the proof of RFC 6962, section 2.1.2, that it extends the earlier one.

        Raises
        ------
        RegistryError
            If the registry was put back to an earlier state, or does not begin as the earlier checkpoint says: a log
            signs nothing that contradicts what it signed before.
        """
        ledger = self._ledger
        signer = ledger.signer()
        with ledger.snapshot() as connection:
            tree = ledger.tree_in(connection)
            if earlier is None:
                return sign_checkpoint(tree.head, signer), []
            earlier.check(ledger.authority, f"of {earlier.date}")
            check_begins(ledger.called, tree.leaves, earlier.head, f"its checkpoint of {earlier.date}")
            return sign_checkpoint(tree.head, signer), consistency_proof(tree.leaves, earlier.head.seq)

    def require_witnesses(self, witnesses: Sequence[VerifierKey], checkpoint: Checkpoint) -> None:
        """From now on rely only on badges that witnesses have seen, in this registry as it is open.

        Parameters
        ----------
        witnesses : sequence of VerifierKey
            All of them must have signed.
        checkpoint : Checkpoint
            One of this registry.

        Raises
        ------
        RegistryError
            If the checkpoint is another registry's, a witness did not sign it, or the log does not begin as it says;
            `error.details["code"]` says which.  From then on, `check_newest` raises it, with code "not_witnessed", for
            a badge that counts and whose newest entry is later than the checkpoint.

        Notes
        -----
        What the log holds after the checkpoint may be shown to one reader alone, so no record is relied on whose newest
        entry is later.  How long a state from before a revocation can be shown is limited by `cosignature.DAYS`.
        """
        ledger, source = self._ledger, f"of {checkpoint.date}"
        with ledger.snapshot() as connection:
            checkpoint.check(ledger.authority, source)
            signers(witnesses, checkpoint.note, source)
            check_begins(ledger.called, ledger.tree_in(connection).leaves, checkpoint.head, WITNESSES)
        ledger.witnessed = checkpoint.head

    def publish(
        self,
        path: Path | str,
        specimen: Callable[[Badge], Badge],
        *,
        days: float,
        overwrite: bool = False,
        progress: Progress | None = None,
        checkpoint: Checkpoint | None = None,
    ) -> tuple[int, str]:
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
        tuple of int and str
            How many people it holds, and until when it counts.

        Raises
        ------
        RegistryError
            If something in the registry is not as signed, it was put back, its private key is absent, or the checkpoint
            is of another state of the log.
        SpecError
            If the file exists and `overwrite` is false, or cannot be written.
        """
        ledger, path, versions = self._ledger, Path(path), dict[str, str]()
        planned([path], overwrite=overwrite, kept=[sqlite_file(ledger.url)])
        signer, entries = ledger.signer(), []
        with ledger.snapshot() as connection:
            tree = ledger.tree_in(connection)
            for entry in tree.entries():
                entries.append(bytes.fromhex(entry["hash"]))
                versions[entry["subject"]] = entry["record_sha256"]
            if checkpoint is None:
                checkpoint = sign_checkpoint(tree.head, signer)
            checkpoint.check(ledger.authority, f"of {checkpoint.date}")
            if checkpoint.head != tree.head:
                raise RegistryError(
                    f"the checkpoint of {checkpoint.date} is of {checkpoint.head.seq} log entries, and {ledger.called} "
                    f"has another log, of {tree.head.seq}; have a checkpoint of today's log cosigned, and publish "
                    "before it grows"
                )
            unsealed, layouts = unsealed_people(connection, ledger, specimen, versions)
        people = sealed_people(unsealed, progress)
        content = msgspec.json.encode(BundleContent(checkpoint.note, b"".join(entries), layouts, people))
        expires = (now() + timedelta(days=days)).strftime(TIME)
        with whole_file(path) as temporary:
            temporary.write_bytes(sealed_file(signer, expires, content))
            read_bundle_file(temporary)
        return len(people), expires
