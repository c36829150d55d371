"""The export: records, log and public key as one JSON file that another registry can import; written, and read.

The file is one JSON object: `format` and `version`, the public key and the signed head, `records` (the columns of the
table, with the badge and the measured figures as JSON), `log` (the entries from the first on).  Each item is a line of
its own, so `load` reads a file of any size in little memory: into an empty registry, without checks of signatures,
which the audit makes afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, BinaryIO

import msgspec
from sqlalchemy import Connection, Table, func, insert, select

from moireid.errors import RegistryError
from moireid.files import open_regular, planned, whole_file
from moireid.registry.canonical import canonical_json, pack
from moireid.registry.engine import AnyRow, chunks, sqlite_file, translated, writing
from moireid.registry.keys import Authority
from moireid.registry.ledger import Ledger
from moireid.registry.log import check_entry, leaf_of
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.merkle import Tree
from moireid.registry.record import DOCUMENTS, Fault, record_of
from moireid.registry.schema import authority, badges, log, pages, select_records

FORMAT, VERSION = "moireid registry", 7
#: Documents, which are copied as they are stored, and derived columns.
NOT_FIELDS = ("badge", *DOCUMENTS, "newest", "skeleton", "folded")
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
        for line, is_record in _lines(ledger, connection):
            stream.write(line)
            done += is_record
            if progress and is_record and done % STEP == 0:
                progress(done, total)
    return done


def _lines(ledger: Ledger, connection: Connection) -> Iterator[tuple[str, bool]]:
    """The lines of the file, and whether each is a record.  Raises: Fault if the registry is not sound."""
    top, signed = connection.execute(select(authority)).one(), ledger.tree_in(connection)
    header = ExportHeader(FORMAT, VERSION, ledger.authority.public_hex, top.head_seq, top.head_hash, top.head_signature)
    yield f"{msgspec.json.encode(header).decode()[:-1]}{RECORDS}", False
    written = dict[str, str]()
    for number, row in enumerate(pages(connection, select_records(), badges.c.id)):
        written[row.id] = row.newest
        yield f"{',' if number else ''}{_record_line(row, ledger)}\n", True
    yield LOG, False
    tree, stale = Tree(), set[str]()
    for row in pages(connection, select(log), log.c.seq):
        yield f"{',' if tree.size else ''}{canonical_json(dict(row._mapping))}\n", False
        tree.add(leaf_of(check_entry(row, tree.size, ledger.authority)))
        # The database's index may hide the newest entry, by which a record was compared.
        if row.subject in written:
            (stale.discard if row.record_sha256 == written[row.subject] else stale.add)(row.subject)
    if stale:
        raise Fault("record_stale", f"the record of id {min(stale)} is not the version that the log has last")
    if (tree.size, tree.root()) != (signed.size, signed.root):
        raise Fault("head_hash", "the log's entries are not those of its signed head")
    yield END, False


def _record_line(row: AnyRow, ledger: Ledger) -> str:
    """A record as a JSON object; its documents are copied as they are stored, which is canonical JSON."""
    record = record_of(row, ledger.authority)
    fields = {key: value for key, value in row._mapping.items() if key not in NOT_FIELDS}
    documents = f'"badge":{record.badge_json},"as_built":{record.as_built or "null"}'
    documents += f',"as_built_earlier":{record.as_built_earlier or "null"}'
    return f"{canonical_json(fields)[:-1]},{documents}}}"


#: Every JSON reader reads numbers up to here as exact whole numbers.
SequenceNumber = Annotated[int, msgspec.Meta(ge=1, le=2**53)]
_TYPES: dict[str, Any] = {
    "badge": dict[str, Any],
    "as_built": dict[str, Any],
    "as_built_earlier": list[dict[str, Any]],
    "seq": SequenceNumber,
}
#: The lines that begin the file's arrays, the first of them after the header, and the one that ends it.
RECORDS, LOG, END = ',"records":[\n', '],"log":[\n', "]}\n"
#: The arrays: the table of each, the column by which it is ordered, and the line that ends it.
ARRAYS = ((badges, "id", LOG), (log, "seq", END))
#: Longest line, bytes; no record is longer.
LONGEST = 2**27


class ExportHeader(msgspec.Struct):
    """What the file says of the registry: the authority's public key, and the head that it signed."""

    format: str
    version: int
    public_key: str
    head_seq: SequenceNumber
    head_hash: str
    head_signature: str


def load(path: Path, copy: Ledger) -> None:
    """Read the export at `path` into `copy`, which is empty and has no authority.

    Raises: RegistryError if the file cannot be read, or is no export that this version knows.
    """
    try:
        with open_regular(path) as stream, translated(copy.url), writing(copy.engine) as connection:
            own = _load(stream, connection)
            values = {name: getattr(own, name) for name in ExportHeader.__struct_fields__[2:]}
            connection.execute(insert(authority).values(one=1, **values))
    except OSError as error:
        raise RegistryError(f"export {path} cannot be read ({error.strerror}); give the path of one") from error
    except (ValueError, RecursionError) as error:
        raise RegistryError(
            f"export {path} is cut, damaged or none ({error}); nothing was imported, so get another copy"
        ) from error
    copy.adopt(own.public_key)


def _load(stream: BinaryIO, connection: Connection) -> ExportHeader:
    """Store records and log; returns what the file says of the registry."""

    def line() -> bytes:
        found = stream.readline(LONGEST)
        if not found.endswith(b"\n"):
            raise ValueError("it ends within a line, or a line is too long")
        return found

    header = msgspec.json.decode(line().removesuffix(RECORDS.encode()) + b"}", type=ExportHeader)
    if header.format != FORMAT:
        raise ValueError("it is no export of a moireid registry")
    if header.version != VERSION:
        raise ValueError(f"it is of version {header.version}, and this moireid reads version {VERSION}")
    # Raises: ValueError if it is no key.
    Authority(header.public_key)
    for table, order, end in ARRAYS:
        model, last = _model(table), list[Any]()
        for some in chunks(iter(line, end.encode())):
            rows = [_row(table, msgspec.json.decode(one.removeprefix(b","), type=model)) for one in some]
            keys = [*last, *(row[order] for row in rows)]
            # In the order in which export writes them; this also excludes duplicates.
            if any(one >= other for one, other in pairwise(keys)):
                raise ValueError(f"its {table.name} are not in order")
            connection.execute(insert(table), rows)
            last = keys[-1:]
    if stream.read(1):
        raise ValueError("something follows its end")
    return header


def _model(table: Table) -> type[msgspec.Struct]:
    """What an item of the file holds: the table's columns and no others, but for derived ones."""
    names = [str(column.name) for column in table.c if column.name not in ("skeleton", "folded")]
    types = {name: _TYPES.get(name, str) for name in names}
    of = [(name, kind | None if table.c[name].nullable else kind) for name, kind in types.items()]
    return msgspec.defstruct(table.name, of, forbid_unknown_fields=True)


def _row(table: Table, item: msgspec.Struct) -> dict[str, Any]:
    """The row that an item writes."""
    row = msgspec.structs.asdict(item)
    if table is badges:
        row |= {"skeleton": skeleton(row["name_nfc"]), "folded": folded_skeleton(row["name_nfc"])}
        row |= {name: row[name] and pack(canonical_json(row[name])) for name in ("badge", *DOCUMENTS)}
    return row
