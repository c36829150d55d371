"""A proof that a badge's newest record is in the log that a checkpoint signs, for a person without the registry.

It holds the checkpoint, the log's entry, the record as it was signed, and the hashes that lead from the entry to the
checkpoint's root (RFC 6962).  It shows that the record was entered, and cannot show that no later entry followed.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import msgspec
from sqlalchemy import select

from moireid.errors import RegistryError
from moireid.registry.canonical import canonical_json, sha256_hex
from moireid.registry.checkpoints.checkpoint import Checkpoint, checkpoint_from, sign_checkpoint
from moireid.registry.keys import Authority
from moireid.registry.ledger import Ledger
from moireid.registry.log import Line, LogEntry, check_hash, entry_hash, leaf_of
from moireid.registry.merkle import included
from moireid.registry.record import Fault, Record
from moireid.registry.schema import log

#: Of the file.
FORMAT, KIND = 2, "moireid registry proof"


class ProvenState(msgspec.Struct):
    """What is shown of the record in a proof."""

    name: Line
    id: Line
    revoked_at: Line | None
    revoked_reason: Line | None
    suspended_at: Line | None = None
    suspended_reason: Line | None = None
    expires: Line | None = None


class ProofFile(msgspec.Struct):
    """A proof as it is written; the record whole, as it was signed, and the checkpoint as its note."""

    format: int
    kind: str
    public_key: str
    checkpoint: str
    entry: LogEntry
    record: dict[str, Any]
    proof: list[str]


@dataclass(frozen=True)
class ProofResult:
    """What a proof says.

    Attributes
    ----------
    record : ProvenState
        Whose badge, and its state in that entry.
    entry : int
        The number of the log's entry; the first is 1.
    at : str
        When it was entered; UTC, ISO 8601.
    checkpoint : Checkpoint
        Its signature holds.
    """

    record: ProvenState
    entry: int
    at: str
    checkpoint: Checkpoint


def proof_of(ledger: Ledger, record: Record) -> str:
    """The proof of a record under a checkpoint that is signed now, as JSON.

    Raises: RegistryError if the record is not the newest one, or the private key is not on this machine.
    """
    ledger.check_newest(record)
    signer = ledger.signer()
    with ledger.snapshot() as connection:
        tree = ledger.tree_in(connection)
        row = connection.execute(select(log).where(log.c.subject == record.id).order_by(log.c.seq.desc())).first()
        if row is None:
            raise RegistryError(f"the record of id {record.id} was erased from registry {ledger.shown} meanwhile")
        steps = tree.inclusion(row.seq, check_hash(dict(row._mapping)))
        if steps is None:
            raise Fault("entry_missing", f"log entry {row.seq} is not in the tree of the signed head")
        checkpoint = sign_checkpoint(tree, signer)
    document = {
        "format": FORMAT,
        "kind": KIND,
        "public_key": signer.authority.public_hex,
        "checkpoint": checkpoint.note,
        "entry": {name: row._mapping[name] for name in LogEntry.__struct_fields__},
        "record": json.loads(bytes(record.signed_text)),
        "proof": [step.hex() for step in steps],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def check_proof(text: str, source: str) -> ProofResult:
    """What a proof says, if all of it holds; `source` names it in messages.

    Convention: the caller compares the authority with a fingerprint that was obtained in some other way.
    Raises: RegistryError if the text is no proof; Fault if it is one, and a part of it was changed.
    """
    try:
        found = msgspec.json.decode(text, type=ProofFile)
        if found.kind != KIND or found.format > FORMAT:
            raise ValueError(f"it is no {KIND} of format {FORMAT}")
        if found.format < FORMAT:
            raise ValueError("an unreleased version made it, so have it made again")
        record = msgspec.convert(found.record, ProvenState)
        steps = [bytes.fromhex(step) for step in found.proof]
        authority, checkpoint = Authority(found.public_key), checkpoint_from(found.checkpoint, source)
        msgspec.convert(checkpoint.date, Line)
    except (ValueError, RecursionError) as error:
        raise RegistryError(
            f"{source} is no proof ({error}); give a file that `moireid registry prove` wrote"
        ) from error
    if authority.fingerprint != checkpoint.fingerprint:
        raise Fault("public_key", "its public key is not the one of its checkpoint's authority")
    try:
        checkpoint.check(authority, source)
    except RegistryError as error:
        raise Fault("checkpoint", "its checkpoint does not bear the authority's signature: it was changed") from error
    entry = found.entry
    leaf = leaf_of(entry_hash(msgspec.structs.asdict(entry)))
    if not included(leaf, entry.seq - 1, checkpoint.size, steps, checkpoint.root):
        raise Fault("entry", "its log entry is not in the log that the checkpoint signs: entry or proof was changed")
    digest = sha256_hex(canonical_json(found.record).encode())
    if (entry.subject, entry.record_sha256) != (record.id, digest):
        raise Fault("record", "its record is not the one that the log entry names: it was changed")
    return ProofResult(record, entry.seq, entry.time, checkpoint)
