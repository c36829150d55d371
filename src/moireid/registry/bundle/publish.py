"""The people of a registry as its bundle holds them: each record checked, and each identity sealed."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import msgspec
from sqlalchemy import Connection

from moireid.badge import Badge
from moireid.provenance import Seal
from moireid.registry.bundle.bundle_file import BundlePerson
from moireid.registry.canonical import canonical_json
from moireid.registry.engine import chunks
from moireid.registry.ledger import Ledger
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.record import Fault, record_of
from moireid.registry.schema import badges, pages, select_records

Progress = Callable[[int, int | None], None]
SALT_BYTES = 16


def unsealed_people(
    connection: Connection, ledger: Ledger, specimen: Callable[[Badge], Badge], versions: Mapping[str, str]
) -> tuple[list[tuple[str, BundlePerson]], list[str]]:
    """Identity and person of each record, not sealed yet, and the specimen of each layout as JSON.

    Raises: Fault for a record that is not of its newest version; versions: of each id the newest digest in the log.
    """
    numbers: dict[str, int] = {}
    layouts: list[str] = []
    found = []
    for row in pages(connection, select_records(), badges.c.id):
        record = record_of(row, ledger.authority)
        if versions.get(record.id) != record.digest():
            raise Fault("record_stale", f"the record of id {record.id} is not the version that the log has last")
        layout = numbers.setdefault(record.layout_key, len(numbers))
        if layout == len(layouts):
            layouts.append(specimen(record.badge).to_json())
        person = BundlePerson(
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
        found.append((record.id, person))
    # By name: the order of identities would reveal something about them, and the names are in the bundle anyway.
    return sorted(found, key=lambda pair: (pair[1].name, secrets.token_bytes(8))), layouts


def _sealed(pair: tuple[str, BundlePerson]) -> BundlePerson:
    badge_id, person = pair
    return msgspec.structs.replace(person, seal=Seal.of(badge_id, secrets.token_bytes(SALT_BYTES)))


def sealed_people(records: Sequence[tuple[str, BundlePerson]], progress: Progress | None) -> list[BundlePerson]:
    """The people with their sealed identities."""
    people: list[BundlePerson] = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for some in chunks(records):
            people += pool.map(_sealed, some)
            if progress:
                progress(len(people), len(records))
    return people
