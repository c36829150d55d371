"""The log: everything done to the registry, each entry signed, and all of them under one signed root.

An entry's hash is SHA-256 of its canonical JSON.  The hashes are the leaves of a Merkle tree (`log_tree.py`).  The head
is the number of entries and the root over them, signed: so no entry can be changed, dropped, inserted or moved without
another root.  The head has its own kind of signature, so the log's end cannot be cut off without a trace.
The table `authority` holds the head; every writer locks that row first, so writers take turns.

An entry names its actor.  What it says of a record is the hash of its signed text, which holds a salt: so a record can
be erased, and the tree stays as it is.

If a whole registry is put back to an earlier state, only a head that was noted elsewhere shows it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from moireid.registry.canonical import canonical_json, sha256_hex, utc_now
from moireid.registry.engine import AnyRow
from moireid.registry.keys import ENTRY, ENTRY_TEXT, ROOT, Authority, Signer
from moireid.registry.merkle import Tree, leaf_hash
from moireid.registry.record import Fault

#: What is hashed of an entry.
HASHED = ("action", "actor", "record_sha256", "seq", "subject", "time")
#: The action of entries that record an erasure.
ERASE = "erase"
#: The actions of entries that put figures in the place of others, which stay on record: for a reason, or as they agree
#: with those and add what those lack.
REPLACED, REFINED = "as_built_replaced", "as_built_refined"
#: Used as the hash of a record that no longer exists.
NO_RECORD = "0" * 64


@dataclass(frozen=True)
class Head:
    """The end of a log, and with it all before: the number of entries, and the root of the tree over them (hex)."""

    seq: int
    hash: str

    def __str__(self) -> str:
        return f"{self.seq}:{self.hash}"

    @classmethod
    def over(cls, leaves: Tree) -> Head:
        """The head of the entries whose leaves a tree has."""
        return cls(leaves.size, leaves.root().hex())


def entry_hash(entry: Mapping[str, Any]) -> str:
    """The hash of an entry, 64 hex digits.  Raises: TypeError or ValueError if a field cannot be JSON."""
    return sha256_hex(ENTRY_TEXT + canonical_json({key: entry[key] for key in HASHED}).encode())


def leaf_of(entry_hash: object) -> bytes:
    """The leaf of an entry, from its hash in hex digits; what is no hash has an empty one, which fits no tree."""
    try:
        return leaf_hash(bytes.fromhex(str(entry_hash)))
    except ValueError:
        return b""


def head_row(signer: Signer, head: Head) -> dict[str, Any]:
    """The columns of `authority` that hold the head, signed."""
    return {"head_seq": head.seq, "head_hash": head.hash, "head_signature": signer.sign(ROOT, str(head).encode())}


def next_rows(signer: Signer, size: int, done: Iterable[tuple[str, str, str]], actor: str) -> list[dict[str, Any]]:
    """Rows of `log` for what was done after the first `size` entries: each (action, subject, SHA-256 of the record).

    Parameters: actor: who did it.
    """
    now, rows = utc_now(), []
    for seq, (action, subject, digest) in enumerate(done, size + 1):
        entry: dict[str, Any] = {
            "seq": seq,
            "time": now,
            "action": action,
            "subject": subject,
            "record_sha256": digest,
            "actor": actor,
        }
        found = entry_hash(entry)
        rows.append(entry | {"hash": found, "signature": signer.sign(ENTRY, found.encode())})
    return rows


def first_rows(signer: Signer, actor: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The row of `authority` and the first row of `log`; that row names the key, so a head confirms the key as well."""
    authority = signer.authority
    (row,) = next_rows(signer, 0, [("init", authority.fingerprint, authority.digest)], actor)
    head = head_row(signer, Head.over(Tree([leaf_of(row["hash"])])))
    return {"one": 1, "public_key": authority.public_hex} | head, row


def check_entry(entry: AnyRow, before: int, authority: Authority) -> None:
    """Check an entry that must follow entry number `before`, and its signature.

    Raises: Fault if its number, hash or signature is wrong, or the first one does not name the key.
    """
    row: dict[str, Any] = dict(entry._mapping)
    if row["seq"] != before + 1:
        raise Fault("entry_missing", f"log entry {row['seq']} does not follow from entry {before}")
    check_signed(row, authority)
    named = (row["action"], row["subject"], row["record_sha256"])
    if before == 0 and named != ("init", authority.fingerprint, authority.digest):
        raise Fault("first_entry", "the log does not begin with this authority's key")


def check_hash(row: Mapping[str, Any]) -> str:
    """The hash of an entry, if it is that of its content.  Raises: Fault if it is not."""
    try:
        right = entry_hash(row)
    except (TypeError, ValueError) as error:
        raise Fault("entry_hash", f"log entry {row['seq']} is damaged ({error})") from error
    if row["hash"] != right:
        raise Fault("entry_hash", f"log entry {row['seq']} was changed: its hash is that of another content")
    return right


def check_signed(row: Mapping[str, Any], authority: Authority) -> None:
    """Check an entry by itself.  Raises: Fault if its hash or signature is wrong."""
    right = check_hash(row)
    if not authority.signed(ENTRY, right.encode(), row["signature"]):
        raise Fault("entry_signature", f"log entry {row['seq']} does not bear the authority's signature")


def check_head(row: AnyRow, last: int | None, authority: Authority) -> Head:
    """The head in the row of `authority`, checked against the number of the log's last entry; None if it is empty.

    The root is not computed here (`log_tree.py`).
    Raises: Fault if its signature is wrong, or the log ends before or after it.
    """
    head = Head(row.head_seq, row.head_hash)
    if not authority.signed(ROOT, str(head).encode(), row.head_signature):
        raise Fault("head_signature", "the log's head does not bear the authority's signature")
    if last is None or last < head.seq:
        ends = "is empty" if last is None else f"ends at entry {last}"
        raise Fault("log_cut", f"the log {ends}, but its signed head is entry {head.seq}: its end was cut off")
    if last > head.seq:
        raise Fault("log_longer", f"the log ends at entry {last}, but its signed head is entry {head.seq}")
    return head
