"""Write a registry's bundle: a snapshot of it, with each record checked and each identity sealed."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path

import msgspec
from sqlalchemy import Connection

from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid.files import planned, whole_file
from moireid.provenance import Seal
from moireid.registry.bundle.bundle_file import (
    TIME,
    BundleContent,
    BundlePerson,
    Header,
    now,
    read_bundle_file,
)
from moireid.registry.canonical import canonical_json, sha256_hex
from moireid.registry.checkpoints.checkpoint import Checkpoint, sign_checkpoint
from moireid.registry.engine import sqlite_file
from moireid.registry.ledger import Ledger
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.record import Fault, Record
from moireid.registry.schema import badges, pages, select_records

Progress = Callable[[int, int | None], None]
SALT_BYTES = 16
#: Seals are made so many at a time, each on one of the processors.
CHUNK = 2000


def publish(
    ledger: Ledger,
    path: Path,
    specimen: Callable[[Badge], Badge],
    *,
    days: float,
    overwrite: bool,
    progress: Progress | None,
    checkpoint: Checkpoint | None,
) -> tuple[int, str]:
    """What `Registry.publish` does."""
    planned([path], overwrite=overwrite, kept=[sqlite_file(ledger.url)])
    signer = ledger.signer()
    with ledger.snapshot() as connection:
        tree = ledger.tree_in(connection)
        entries, versions, head = [], dict[str, str](), tree.head
        for entry in tree.entries():
            entries.append(bytes.fromhex(entry["hash"]))
            versions[entry["subject"]] = entry["record_sha256"]
        if checkpoint is None:
            checkpoint = sign_checkpoint(tree, signer)
        else:
            checkpoint.check(ledger.authority, f"of {checkpoint.date}")
            if checkpoint.head != head:
                raise RegistryError(
                    f"the checkpoint of {checkpoint.date} is of {checkpoint.size} log entries, and {ledger.called} has "
                    f"another log, of {head.seq}; have a checkpoint of today's log cosigned, and publish before it "
                    "grows"
                )
        records, layouts = _records(ledger, connection, specimen, versions)
    people = _people(records, progress)
    content = msgspec.json.encode(BundleContent(checkpoint.note, b"".join(entries), layouts, people))
    expires = (now() + timedelta(days=days)).strftime(TIME)
    header = Header(signer.authority.public_hex, expires, sha256_hex(content))
    with whole_file(path) as temporary:
        temporary.write_bytes(header.sealed_file(signer, content))
        read_bundle_file(temporary)
    return len(people), expires


def _records(
    ledger: Ledger, connection: Connection, specimen: Callable[[Badge], Badge], versions: Mapping[str, str]
) -> tuple[list[tuple[str, BundlePerson]], list[str]]:
    """Identity and person of each record, not sealed yet, and the specimen of each layout as JSON.

    Raises: Fault for a record that is not of its newest version; versions: as `LogTree.versions`.
    """
    numbers: dict[str, int] = {}
    layouts: list[str] = []
    found = []
    for row in pages(connection, select_records(), badges.c.id):
        record = ledger.record(row)
        if versions.get(record.id) != record.digest():
            raise Fault("record_stale", f"the record of id {record.id} is not the version that the log has last")
        if record.layout_key not in numbers:
            numbers[record.layout_key] = len(layouts)
            layouts.append(specimen(record.badge).to_json())
        found.append((record.id, _bare(record, numbers[record.layout_key])))
    # By name: the order of identities would reveal something about them, and the names are in the bundle anyway.
    return sorted(found, key=lambda pair: (pair[1].name, secrets.token_bytes(8))), layouts


def _bare(record: Record, layout: int) -> BundlePerson:
    return BundlePerson(
        name=record.name,
        skeleton=skeleton(record.name),
        folded=folded_skeleton(record.name),
        seal=Seal(b"", b""),
        layout=layout,
        revoked=record.barred(),
        line=record.line,
        figures=[
            (canonical_json(one["as_built"] | {"badge_id": ""}), one["as_built_at"]) for one in record.figure_sets
        ],
    )


def _sealed(pair: tuple[str, BundlePerson]) -> BundlePerson:
    badge_id, person = pair
    return msgspec.structs.replace(person, seal=Seal.of(badge_id, secrets.token_bytes(SALT_BYTES)))


def _people(records: Sequence[tuple[str, BundlePerson]], progress: Progress | None) -> list[BundlePerson]:
    """The people with their sealed identities."""
    people: list[BundlePerson] = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for begin in range(0, len(records), CHUNK):
            people += pool.map(_sealed, records[begin : begin + CHUNK])
            if progress:
                progress(len(people), len(records))
    return people
