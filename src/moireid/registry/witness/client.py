"""A registry asks witnesses to sign its checkpoint.

It asks all at the same time, and each first what it knows: a witness that knows an earlier checkpoint answers with its
size, and gets the proof that the log goes on from there.  The registry keeps nothing of a witness, so witnesses can be
exchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from moireid.errors import RegistryError
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.cosignature import Quorum, cosigned_at
from moireid.registry.checkpoints.note import DASH, MOST_SIGNATURES, parted
from moireid.registry.checkpoints.web import exchange, together
from moireid.registry.witness.request import PATH, AddRequest, size_of

#: Longest answer, bytes; longest silence of a witness and of all of them together, seconds.
MOST_BYTES, WAIT_S, MOST_S = 16384, 10.0, 30.0
#: How often a witness is asked anew, if another program moves it on meanwhile.
ROUNDS = 4

#: From an earlier size of the log to the proof of its consistency.
Prove = Callable[[int], Sequence[bytes]]


@dataclass(frozen=True)
class WitnessRound:
    """A checkpoint with the signatures of witnesses.

    signers: the names of those that signed it; failures: by address, why a witness did not.
    """

    checkpoint: Checkpoint
    signers: tuple[str, ...]
    failures: Mapping[str, str]


def ask_witnesses(checkpoint: Checkpoint, prove: Prove, addresses: Sequence[str], quorum: Quorum) -> WitnessRound:
    """Have a checkpoint signed by witnesses.

    Parameters
    ----------
    checkpoint : Checkpoint
        Signed by the registry's authority.
    prove : callable
        From an earlier size to the proof of `merkle.consistent`.
    addresses : sequence of str
        Web addresses of the witnesses.
    quorum : Quorum
        Their keys, and how many must sign.

    Returns
    -------
    WitnessRound
        The checkpoint with at least so many signatures.

    Raises
    ------
    RegistryError
        If fewer sign it, with code "not_witnessed"; `details["failures"]` says why, by address.
    """
    calls = {address: lambda address=address: _asked(address, checkpoint, prove, quorum) for address in addresses}
    note, signers, failures = checkpoint.note, list[str](), dict[str, str]()
    for address, found in together(calls, MOST_S).items():
        if isinstance(found, Exception):
            failures[address] = str(found) or type(found).__name__
            continue
        for name, line in found.items():
            if name not in signers:
                signers.append(name)
                note += line
    if len(signers) < quorum.needed:
        why = "; ".join(f"{address}: {reason}" for address, reason in failures.items())
        raise RegistryError(
            f"{len(signers)} of the {quorum.needed} witnesses that are needed signed the checkpoint ({why}), so none "
            "is written; try again, or ask more witnesses",
            code="not_witnessed",
            failures=failures,
        )
    return WitnessRound(replace(checkpoint, note=note), tuple(signers), failures)


def _asked(address: str, checkpoint: Checkpoint, prove: Prove, quorum: Quorum) -> dict[str, str]:
    """The signature lines of one witness's answer by the name of the witness, all checked.

    Raises: OSError if it does not answer; ValueError, with a few words, if it signs nothing.
    """
    old = 0
    for _ in range(ROUNDS):
        request = AddRequest(old, prove(old) if old else [], checkpoint.note)
        answer = exchange(address.rstrip("/") + PATH, MOST_BYTES, WAIT_S, request.to_bytes())
        text = answer.content.decode("utf-8", errors="replace")
        if answer.status == 200:
            return _checked(text, checkpoint.note, quorum)
        if answer.status != 409:
            words = "".join(letter if letter.isprintable() else " " for letter in text[:100]).strip()
            raise ValueError(f"it answers with status {answer.status} ({words})")
        before, old = old, size_of(text.removesuffix("\n"))
        if old > checkpoint.size:
            raise ValueError(
                f"it knows {old} entries of this log, and the registry has {checkpoint.size}: one of them was "
                "rolled back"
            )
        if old == before:
            raise ValueError(f"it knows another log of {old} entries: the registry was forked")
    raise ValueError("it names another size each time")


def _checked(answer: str, note: str, quorum: Quorum) -> dict[str, str]:
    lines = [line for line in answer.split("\n")[:MOST_SIGNATURES] if line.startswith(DASH)]
    text, found = parted(note)[0], {}
    for line in lines:
        for one in quorum.witnesses:
            if cosigned_at(f"{text}\n{line}\n", one) is not None:
                found[one.name] = line + "\n"
    if not found:
        raise ValueError("its answer bears no signature of a witness whose key you gave")
    return found
