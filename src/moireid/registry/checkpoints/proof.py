"""A proof that a badge's newest record is in the log that a checkpoint signs, for a person without the registry.

It holds the checkpoint, the log's entry, the record as it was signed, and the hashes that lead from the entry to the
checkpoint's root (RFC 6962).  It shows that the record was entered, and cannot show that no later entry followed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from sqlalchemy import select

from moireid.errors import RegistryError
from moireid.registry.canonical import canonical_json, sha256_hex
from moireid.registry.checkpoints.checkpoint import Checkpoint, checkpoint_from, entry_hashes, leaf_of, sign_checkpoint
from moireid.registry.checkpoints.merkle import Tree, included, inclusion_proof, leaf_hash
from moireid.registry.checkpoints.seen import check_newest
from moireid.registry.keys import Authority
from moireid.registry.ledger import Ledger
from moireid.registry.log import entry_hash
from moireid.registry.record import Fault, Record, storable
from moireid.registry.schema import log

FORMAT, KIND = 1, "moireid registry proof"
#: What is not part of an entry's content.
OUTSIDE = ("hash", "signature")


@dataclass(frozen=True)
class ProofResult:
    """What a proof says.

    Attributes
    ----------
    name, badge_id : str
        Whose badge, and its id.
    entry : int
        The number of the log's entry; the first is 1.
    at : str
        When it was entered; UTC, ISO 8601.
    revoked_at, revoked_reason, suspended_at, suspended_reason, expires : str or None
        Of the record in that entry.
    checkpoint : Checkpoint
        Its signature holds.
    """

    name: str
    badge_id: str
    entry: int
    at: str
    revoked_at: str | None
    revoked_reason: str | None
    suspended_at: str | None
    suspended_reason: str | None
    expires: str | None
    checkpoint: Checkpoint


def proof_of(ledger: Ledger, record: Record) -> str:
    """The proof of a record under a checkpoint that is signed now, as JSON.

    Raises: RegistryError if the record is not the newest one, or the private key is not on this machine.
    """
    check_newest(ledger, record)
    signer = ledger.signer()
    with ledger.snapshot() as connection:
        leaves = [leaf_hash(content) for content in entry_hashes(ledger, connection)]
        row = connection.execute(select(log).where(log.c.subject == record.id).order_by(log.c.seq.desc())).first()
    if row is None:
        raise RegistryError(f"the record of id {record.id} was erased from registry {ledger.shown} meanwhile")
    tree = Tree()
    for leaf in leaves:
        tree.add(leaf)
    document = {
        "format": FORMAT,
        "kind": KIND,
        "public_key": signer.authority.public_hex,
        "checkpoint": sign_checkpoint(tree, signer).note,
        "entry": {name: value for name, value in row._mapping.items() if name not in OUTSIDE},
        "record": json.loads(bytes(record.signed_text)),
        "proof": [step.hex() for step in inclusion_proof(leaves, row.seq - 1)],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def check_proof(text: str, source: str) -> ProofResult:
    """What a proof says, if all of it holds; `source` names it in messages.

    Convention: the caller compares the authority with a fingerprint that was obtained in some other way.
    Raises: RegistryError if the text is no proof; Fault if it is one, and a part of it was changed.
    """
    try:
        document = json.loads(text, parse_constant=_no_number)
        if (document["format"], document["kind"]) != (FORMAT, KIND):
            raise ValueError("another format")
        entry, record = dict(document["entry"]), dict(document["record"])
        steps = [bytes.fromhex(step) for step in document["proof"]]
        authority, place = Authority(str(document["public_key"])), _number(entry["seq"]) - 1
        checkpoint = checkpoint_from(str(document["checkpoint"]), source)
        found = ProofResult(
            _line(record["name"]),
            _line(record["id"]),
            place + 1,
            _line(entry["time"]),
            _line_or_none(record["revoked_at"]),
            _line_or_none(record["revoked_reason"]),
            _line_or_none(record.get("suspended_at")),
            _line_or_none(record.get("suspended_reason")),
            _line_or_none(record.get("expires")),
            checkpoint,
        )
        _line(checkpoint.date)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise RegistryError(
            f"{source} is no proof ({error}); give a file that `moireid registry prove` wrote"
        ) from error
    _check(checkpoint, authority, source)
    if not included(leaf_of(_hash_of(entry)), place, checkpoint.size, steps, checkpoint.root):
        raise Fault("entry", "its log entry is not in the log that the checkpoint signs: entry or proof was changed")
    if entry.get("subject") != found.badge_id or entry.get("record_sha256") != sha256_hex(
        canonical_json(record).encode()
    ):
        raise Fault("record", "its record is not the one that the log entry names: it was changed")
    return found


def _line(value: object) -> str:
    """A text on one line, as registries hold it: a longer one could add false lines to the printed result."""
    if not isinstance(value, str) or not storable(value):
        raise ValueError("a field of it is no line of text")
    return value


def _line_or_none(value: object) -> str | None:
    return None if value is None else _line(value)


def _number(value: object) -> int:
    if type(value) is not int or not 0 < value < 10**18:
        raise ValueError("the number of its entry is none")
    return value


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number of JSON")


def _check(checkpoint: Checkpoint, authority: Authority, source: str) -> None:
    if authority.fingerprint != checkpoint.fingerprint:
        raise Fault("public_key", "its public key is not the one of its checkpoint's authority")
    try:
        checkpoint.check(authority, source)
    except RegistryError as error:
        raise Fault("checkpoint", "its checkpoint does not bear the authority's signature: it was changed") from error


def _hash_of(entry: Mapping[str, Any]) -> str:
    try:
        return entry_hash(entry)
    except (TypeError, ValueError, KeyError) as error:
        raise Fault("entry", f"its log entry is damaged ({error})") from error
