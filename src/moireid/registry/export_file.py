"""The export: records, log and public key as one JSON file that another registry can import; written, and read.

The file is one object: `format` and `version`, `authority` (public key, its fingerprint, the signed head), `records`
(the columns of the table, with the badge and the measured figures as JSON), `log` (the entries from the first on),
`actors` (the names of the entries' actors).  A badge is written in its canonical spelling.  If a tool spells the
document differently, for example indented, it is still the same badge, and its signature stays valid.

`walk` reads a JSON object of any size in little memory: it gives the items of its arrays one by one.  `load` reads an
export into an empty registry, without checks of signatures: the audit makes them afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, BinaryIO

import ijson
import msgspec
from sqlalchemy import Connection, Table, func, insert, select

from moireid.errors import RegistryError
from moireid.files import open_regular, planned, whole_file
from moireid.registry.canonical import canonical_json, pack
from moireid.registry.engine import AnyRow, sqlite_file, translated, writing
from moireid.registry.keys import Authority
from moireid.registry.ledger import Ledger
from moireid.registry.log import authority_after, check_entry, leaf_of
from moireid.registry.log_tree import grow
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.merkle import Tree
from moireid.registry.record import DOCUMENTS, Fault, record_of
from moireid.registry.schema import actors, authority, badges, log, pages, select_records

FORMAT, VERSION = "moireid registry", 5
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
    written = dict[str, str]()
    for number, row in enumerate(pages(connection, select_records(), badges.c.id)):
        written[row.id] = row.newest
        yield (",\n" if number else "\n") + _record_line(row, ledger), True
    yield '\n],\n"actors":[', False
    for number, row in enumerate(pages(connection, select(actors), actors.c.commitment)):
        yield (",\n" if number else "\n") + canonical_json(dict(row._mapping)), False
    yield '\n],\n"log":[', False
    former = ledger.rotations(connection)
    tree, then = Tree(), former[0].old if former else ledger.authority
    stale = set[str]()
    for row in pages(connection, select(log), log.c.seq):
        yield (",\n" if tree.size else "\n") + canonical_json(dict(row._mapping)), False
        tree.add(leaf_of(check_entry(row, tree.size, then)))
        then = authority_after(row, then)
        # The database's index may hide the newest entry, by which a record was compared.
        if row.subject in written:
            (stale.discard if row.record_sha256 == written[row.subject] else stale.add)(row.subject)
    if stale:
        raise Fault("record_stale", f"the record of id {min(stale)} is not the version that the log has last")
    if (tree.size, tree.root()) != (signed.size, signed.root):
        raise Fault("head_hash", "the log's entries are not those of its signed head")
    yield "\n]\n}\n", False


def _record_line(row: AnyRow, ledger: Ledger) -> str:
    """A record as a JSON object; its documents are copied as they are stored, which is canonical JSON."""
    record = record_of(row, ledger.authority)
    fields = {key: value for key, value in row._mapping.items() if key not in NOT_FIELDS}
    documents = f'"badge":{record.badge_json},"as_built":{record.as_built or "null"}'
    documents += f',"as_built_earlier":{record.as_built_earlier or "null"}'
    return f"{canonical_json(fields)[:-1]},{documents}}}"


CHUNK = 2**16
#: Largest single value, bytes; no record is longer.
VALUE_LIMIT = 2**27
#: A record's documents are a handful of levels deep.
DEEPEST = 200

#: By how many levels an event leads deeper into a value.
_LEVELS = {"start_map": 1, "start_array": 1, "end_map": -1, "end_array": -1}


def walk(stream: BinaryIO) -> Iterator[tuple[str, Any]]:
    """The members of the object in `stream`, in order: (key, value), and for an array (key, item) of each item.

    White space is allowed wherever JSON allows it.
    Raises: ValueError if the bytes are not one JSON object, when the reader reaches the fault.
    """
    limited = _LimitedStream(stream)
    try:
        for found in _walk(ijson.basic_parse(limited, use_float=True, buf_size=CHUNK)):
            yield found
            limited.left = VALUE_LIMIT
    except ijson.JSONError as error:
        # The parser's text goes on with an extract of the file, over several lines.
        words = str(error)
        not_text = "UTF8" in words or "utf-8" in words
        raise ValueError("it is not UTF-8 text" if not_text else words.splitlines()[0]) from error


def _walk(events: Iterator[tuple[str, Any]]) -> Iterator[tuple[str, Any]]:
    if next(events) != ("start_map", None):
        raise ValueError("it is no JSON object")
    key, in_array, level = "", False, 0
    for event, value in events:
        if level == 0:
            if event == "map_key":
                key = value
                continue
            if (event == "start_array" and not in_array) or event == "end_array":
                in_array = event == "start_array"
                continue
            if event == "end_map":
                # The parser sees whether anything follows.
                continue
            builder = ijson.ObjectBuilder()
        builder.event(event, value)
        level += _LEVELS.get(event, 0)
        if level > DEEPEST:
            raise ValueError(f"it is nested deeper than {DEEPEST} levels")
        if level == 0:
            yield key, builder.value


class _LimitedStream:
    """A stream that gives no more than `left` bytes, which is set anew with every value."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self.left = stream, VALUE_LIMIT

    def read(self, size: int) -> bytes:
        content = self._stream.read(size)
        self.left -= len(content)
        if self.left < 0:
            raise ValueError(f"a value of it is longer than {VALUE_LIMIT} bytes")
        return content


#: Rows that are stored at a time.
ROWS = 1000
#: Every JSON reader reads numbers up to here as exact whole numbers.
SequenceNumber = Annotated[int, msgspec.Meta(ge=1, le=2**53)]
_TYPES: dict[str, Any] = {
    "badge": dict[str, Any],
    "as_built": dict[str, Any],
    "as_built_earlier": list[dict[str, Any]],
    "seq": SequenceNumber,
}
#: The file's arrays: their tables, and the column by which they are ordered.
TABLES = {"records": (badges, "id"), "actors": (actors, "commitment"), "log": (log, "seq")}


class ExportHead(msgspec.Struct):
    """The log's head."""

    seq: SequenceNumber
    hash: str
    signature: str


class ExportAuthority(msgspec.Struct):
    """The authority: its public key and that key's fingerprint, and the head that it signed."""

    public_key: str
    fingerprint: str
    head: ExportHead


def load(path: Path, copy: Ledger) -> None:
    """Read the export at `path` into `copy`, which is empty and has no authority.

    Raises: RegistryError if the file cannot be read, or is no export that this version knows.
    """
    try:
        with open_regular(path) as stream, translated(copy.url), writing(copy.engine) as connection:
            own = _load(walk(stream), connection)
            if own.fingerprint != Authority(own.public_key).fingerprint:
                raise ValueError("its fingerprint is not that of its public key")
            values = {"one": 1, "public_key": own.public_key, "head_seq": own.head.seq}
            values |= {"head_hash": own.head.hash, "head_signature": own.head.signature}
            connection.execute(insert(authority).values(values))
            grow(connection, Tree())
    except OSError as error:
        raise RegistryError(f"export {path} cannot be read ({error.strerror}); give the path of one") from error
    except ValueError as error:
        # Letters that cannot be encoded are named by code, which says nothing to a person.
        what = "it is not UTF-8 text" if isinstance(error, UnicodeError) else str(error).splitlines()[0]
        raise RegistryError(
            f"export {path} is cut, damaged or none ({what}); nothing was imported, so get another copy"
        ) from error
    copy.adopt(own.public_key)


def _load(parts: Iterator[tuple[str, Any]], connection: Connection) -> ExportAuthority:
    """Store records and log; returns what the file says of its authority."""
    header: dict[str, Any] = {}
    waiting: dict[str, list[dict[str, Any]]] = {key: [] for key in TABLES}
    last: dict[str, Any] = {}
    models = {key: _model(table) for key, (table, _) in TABLES.items()}
    for key, value in parts:
        if key not in TABLES:
            if key in header:
                raise ValueError(f"{key!r} is there twice")
            header[key] = value
            continue
        _check_format(header)
        table, order = TABLES[key]
        rows = waiting[key]
        rows.append(_row(table, msgspec.structs.asdict(msgspec.convert(value, models[key]))))
        # In the order in which export writes them; this also excludes duplicates.
        if key in last and not last[key] < rows[-1][order]:
            raise ValueError(f"its {key} are not in order")
        last[key] = rows[-1][order]
        if len(rows) == ROWS:
            connection.execute(insert(table), rows)
            rows.clear()
    for key, rows in waiting.items():
        if rows:
            connection.execute(insert(TABLES[key][0]), rows)
    _check_format(header)
    return msgspec.convert(header.get("authority"), ExportAuthority)


def _check_format(header: dict[str, Any]) -> None:
    """Raise ValueError unless a file begins as an export of this version."""
    version = header.get("version")
    if header.get("format") != FORMAT or not isinstance(version, int):
        raise ValueError("it is no export of a moireid registry")
    if version != VERSION:
        maker = "a newer one" if version > VERSION else "an unreleased version"
        raise ValueError(f"{maker} made it, version {version}, and this moireid reads version {VERSION}")


def _model(table: Table) -> type[msgspec.Struct]:
    """What an item of the file holds: the table's columns and no others, but for derived ones."""
    names = [str(column.name) for column in table.c if column.name not in ("skeleton", "folded")]
    types = {name: _TYPES.get(name, str) for name in names}
    of = [(name, kind | None if table.c[name].nullable else kind) for name, kind in types.items()]
    return msgspec.defstruct(table.name, of, forbid_unknown_fields=True)


def _row(table: Table, item: dict[str, Any]) -> dict[str, Any]:
    """The row that an item writes."""
    row: dict[str, Any] = dict.fromkeys(table.c.keys()) | item
    if table is badges:
        row |= {"skeleton": skeleton(row["name_nfc"]), "folded": folded_skeleton(row["name_nfc"])}
        row |= {name: pack(canonical_json(row[name])) for name in ("badge", *DOCUMENTS) if row[name] is not None}
    return row
