"""The part of a log that witnesses have seen: what a reader relies on if they ask for witnesses.

The witnesses' checkpoint must be one of this registry, and the log must begin as it says.  What the log holds after it
may be shown to one reader alone, so no record is relied on whose newest entry is later (`newest.py`).  How long a state
from before a revocation can be shown is limited by the age of the signatures (`Quorum.days`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime

from moireid.errors import RegistryError
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.cosignature import Quorum
from moireid.registry.ledger import Ledger
from moireid.registry.log import Head


@dataclass(frozen=True)
class WitnessedPart:
    """The first `size` entries of a log; signers: the witnesses that signed for them, and when, the newest first."""

    size: int
    signers: Mapping[str, datetime]


def witnessed_part(ledger: Ledger, checkpoint: Checkpoint, quorum: Quorum, source: str) -> WitnessedPart:
    """What `Registry.require_witnesses` does."""
    with ledger.snapshot() as connection:
        former = [one.old for one in ledger.rotations(connection)]
        keys = {one.fingerprint: one for one in (*former, ledger.authority)}
        if checkpoint.fingerprint not in keys:
            raise RegistryError(
                f"checkpoint {source} is of authority {checkpoint.fingerprint}, and registry {ledger.shown} of "
                f"{ledger.authority.fingerprint}; get the registry's own one",
                code="key_replaced",
            )
        checkpoint.check(keys[checkpoint.fingerprint], source)
        signers, tree = quorum.signers(checkpoint.note, source), ledger.tree_in(connection)
        goes_on = tree.consistency(checkpoint.size, checkpoint.root) is not None
    if tree.size < checkpoint.size:
        raise RegistryError(
            f"{ledger.called} has {tree.size} log entries, and witnesses have seen {checkpoint.size}: it was rolled "
            "back to an earlier state; get its newest copy from those who run it",
            code="rolled_back",
        )
    if not goes_on:
        raise RegistryError(
            f"{ledger.called} does not begin with the {checkpoint.size} log entries that witnesses have seen: it was "
            "forked; ask those who run it, and look with `moireid registry audit --since`",
            code="forked",
        )
    ledger.witnessed = Head(checkpoint.size, checkpoint.root.hex())
    return WitnessedPart(checkpoint.size, signers)
