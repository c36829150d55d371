"""Export: records, log and public key as one JSON file that another registry takes in.

The file is one object: `format` and `version`, `authority` (public key, its fingerprint, the signed head), `records`
(the columns of the table, with the badge and the measured figures as JSON), `log` (the entries from the first on),
`actors` (who the entries name).  Version 1 had no actors, and no salts; version 2 no suspensions,
expiries, and days since when a badge is compromised.
A badge stands there in its canonical spelling.  If a tool spells the document differently, for example indented, it is
still the same badge, and its signature stays valid.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from sqlalchemy import Connection, func, select

from moireid.files import planned, whole_file
from moireid.registry.canonical import canonical_json
from moireid.registry.engine import AnyRow
from moireid.registry.ledger import Ledger, pages
from moireid.registry.log import GENESIS, Head, authority_after, check_entry, check_head
from moireid.registry.record import Fault, record_of, tampered
from moireid.registry.schema import actors, authority, badges, log, select_records
from moireid.registry.url import sqlite_file

FORMAT, VERSION = "moireid registry", 3
#: Documents, which are put in as they are, and what is derived.
NOT_FIELDS = ("badge", "as_built", "newest", "skeleton", "folded")
#: Number of records between two reports of progress.
STEP = 500


def export_json(
    ledger: Ledger, path: Path, *, overwrite: bool, progress: Callable[[int, int | None], None] | None
) -> int:
    """What `Registry.export_json` does: one state of the registry, each line of it checked on its way out."""
    planned([path], overwrite=overwrite, kept=[sqlite_file(ledger.url)])
    with (
        # Badges can be printed from it.
        whole_file(path, private=True) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
        ledger.snapshot() as connection,
    ):
        total = connection.scalar(select(func.count()).select_from(badges)) or 0
        done = 0
        try:
            for line, is_record in _lines(ledger, connection):
                stream.write(line)
                done += is_record
                if progress and is_record and done % STEP == 0:
                    progress(done, total)
        except Fault as fault:
            raise tampered(ledger.shown, fault) from fault
    return done


def _lines(ledger: Ledger, connection: Connection) -> Iterator[tuple[str, bool]]:
    """The lines of the file, and whether each is a record.  Raises: Fault where the registry is not sound."""
    top = connection.execute(select(authority)).one()
    header = {
        "format": FORMAT,
        "version": VERSION,
        "authority": {
            "public_key": ledger.authority.public_hex,
            "fingerprint": ledger.authority.fingerprint,
            "head": {"seq": top.head_seq, "hash": top.head_hash, "signature": top.head_signature},
        },
    }
    yield "".join(f'{"," if k else "{"}\n"{key}":{canonical_json(header[key])}' for k, key in enumerate(header)), False
    yield ',\n"records":[', False
    for number, row in enumerate(pages(connection, select_records(), badges.c.id)):
        yield (",\n" if number else "\n") + _record_line(row, ledger), True
    yield '\n],\n"actors":[', False
    for number, row in enumerate(pages(connection, select(actors), actors.c.commitment)):
        yield (",\n" if number else "\n") + canonical_json(dict(row._mapping)), False
    yield '\n],\n"log":[', False
    former = ledger.rotations(connection)
    last, then = Head(0, GENESIS), former[0].old if former else ledger.authority
    for row in pages(connection, select(log), log.c.seq):
        yield (",\n" if last.seq else "\n") + canonical_json(dict(row._mapping)), False
        last = check_entry(row, last, then)
        then = authority_after(row, then)
    check_head(top, last if last.seq else None, ledger.authority)
    yield "\n]\n}\n", False


def _record_line(row: AnyRow, ledger: Ledger) -> str:
    """A record as a JSON object; its documents are put in as they are stored, which is canonical JSON."""
    record = record_of(row, ledger.authority)
    fields = {key: value for key, value in row._mapping.items() if key not in NOT_FIELDS}
    documents = f'"badge":{record.badge_json},"as_built":{record.as_built or "null"}'
    return f"{canonical_json(fields)[:-1]},{documents}}}"
