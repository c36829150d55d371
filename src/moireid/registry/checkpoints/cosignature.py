"""Cosignatures of witnesses on checkpoints.

A witness follows a log, and signs a checkpoint only if the log goes on from all that it signed before.  Its signature
states that at the given time it knew no longer log of that origin than this one.  All that a reader names must have
signed: the reader can be shown a log of their own only if all of them sign for two logs.

Convention: Ed25519 over "cosignature/v1", the time, and the text of the checkpoint.  The name of a witness is not
signed, so one key must not count under two names.
Source: C2SP tlog-cosignature v1, https://c2sp.org/tlog-cosignature.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from moireid.errors import RegistryError, SpecError
from moireid.files import read_regular
from moireid.registry.checkpoints.note import COSIGNATURE, VerifierKey, parted, signatures_of

#: How far a witness's clock may be ahead of this one, seconds.
MOST_AHEAD_S = 300
#: For so many days a cosignature counts.
DAYS = 7
#: Longest file of keys that is read, bytes.
MOST_BYTES = 65536


def cosigned_at(note: str, witness: VerifierKey) -> int | None:
    """When a witness signed a checkpoint, seconds since 1970; None if it did not.

    Raises: ValueError if the note is none, or a signature that names the witness does not fit it.
    """
    text, lines = parted(note)
    times = [_time_of(text, one, witness) for one in signatures_of(witness, lines)]
    return max(times, default=None)


def _time_of(text: str, signature: bytes, witness: VerifierKey) -> int:
    at = int.from_bytes(signature[:8], "big")
    try:
        if len(signature) != 72 or at >= 1 << 63:
            raise ValueError
        signed = f"cosignature/v1\ntime {at}\n{text}".encode()
        Ed25519PublicKey.from_public_bytes(witness.public).verify(signature[8:], signed)
    except (InvalidSignature, ValueError) as error:
        raise ValueError(f"the signature of witness {witness.name} does not fit it") from error
    return at


def witness_keys(given: Sequence[str]) -> tuple[VerifierKey, ...]:
    """The keys of witnesses, each written as NAME+ID+KEY, or lines of them in a file.

    Raises: SpecError if one is none or is given twice, or a file cannot be read.
    """
    found = [VerifierKey.parse(line) for text in given for line in _lines(text)]
    if given and not found:
        raise SpecError("no witness is named; give the key of each (witness_keys)")
    for one in found:
        if one.kind != COSIGNATURE:
            raise SpecError(
                f"the key of {one.name} is no key of a witness; give the one that its operator shows for that"
            )
    if len({one.public for one in found}) < len(found) or len({one.name for one in found}) < len(found):
        raise SpecError("two of the witnesses have one key or one name, and would count as one; give each key once")
    return tuple(found)


def _lines(text: str) -> list[str]:
    """The keys in a text; if it has no plus sign, or a file of that name is there, in the file."""
    path = Path(text)
    try:
        if "+" in text and not path.is_file():
            return [text]
        content = read_regular(path, MOST_BYTES).decode("utf-8", errors="replace")
    except OSError as error:
        reason = error.strerror or error
        raise SpecError(
            f"key {text[:80]!r} of a witness is no NAME+ID+KEY, and no file with some ({reason})"
        ) from error
    lines = [line.strip() for line in content.splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


def signers(witnesses: Sequence[VerifierKey], note: str, source: str) -> dict[str, str]:
    """When each of the witnesses signed a checkpoint, the newest first.

    Raises: RegistryError with code "not_witnessed" if one of them did not, or too long ago.
    """
    times: dict[str, int] = {}
    faults: list[str] = []
    now = time.time()
    for one in witnesses:
        try:
            at = cosigned_at(note, one)
        except ValueError as error:
            faults.append(str(error))
            continue
        if at is None:
            faults.append(f"{one.name} did not sign it")
        elif at > now + MOST_AHEAD_S:
            faults.append(f"{one.name} signed it at a time to come, so one of the two clocks is wrong")
        elif at < now - DAYS * 86400:
            faults.append(f"{one.name} signed it more than {DAYS:g} days ago")
        else:
            times[one.name] = at
    if faults:
        raise RegistryError(
            f"checkpoint {source} is signed by {len(times)} of {len(witnesses)} witnesses ({'; '.join(faults)}); get a "
            "newer one from those who run the registry",
            code="not_witnessed",
        )
    newest = sorted(times.items(), key=lambda pair: -pair[1])
    return {name: f"{datetime.fromtimestamp(at, UTC):%Y-%m-%dT%H:%M:%SZ}" for name, at in newest}
