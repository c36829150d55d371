"""Export: records, log and public key as one JSON file that another registry can import; and its stream reader.

The file is one object: `format` and `version`, `authority` (public key, its fingerprint, the signed head), `records`
(the columns of the table, with the badge and the measured figures as JSON), `log` (the entries from the first on),
`actors` (the names of the entries' actors).  Version 1 had no actors and no salts; version 2 had no suspensions, days
of expiry or days of compromise.  A badge is written in its canonical spelling.  If a tool spells the document
differently, for example indented, it is still the same badge, and its signature stays valid.

`walk` reads a JSON object of any size in little memory: it gives the items of its arrays one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import ijson
from sqlalchemy import Connection, func, select

from moireid.files import planned, whole_file
from moireid.registry.canonical import canonical_json
from moireid.registry.engine import AnyRow, sqlite_file
from moireid.registry.ledger import Ledger, pages
from moireid.registry.log import GENESIS, Head, authority_after, check_entry, check_head
from moireid.registry.record import Fault, record_of, tampered
from moireid.registry.schema import actors, authority, badges, log, select_records

FORMAT, VERSION = "moireid registry", 3
#: Documents, which are copied as they are stored, and derived columns.
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
    """The lines of the file, and whether each is a record.  Raises: Fault if the registry is not sound."""
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
    """A record as a JSON object; its documents are copied as they are stored, which is canonical JSON."""
    record = record_of(row, ledger.authority)
    fields = {key: value for key, value in row._mapping.items() if key not in NOT_FIELDS}
    documents = f'"badge":{record.badge_json},"as_built":{record.as_built or "null"}'
    return f"{canonical_json(fields)[:-1]},{documents}}}"


CHUNK = 2**16
#: Largest single value, bytes; no record is longer.
VALUE_LIMIT = 2**27
#: A record's documents are a handful of levels deep.
DEEPEST = 200

_BEGIN = frozenset(["start_map", "start_array"])
_Events = Iterator[tuple[str, Any]]


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


def _walk(events: _Events) -> _Events:
    if next(events) != ("start_map", None):
        raise ValueError("it is no JSON object")
    for _, key in _until("end_map", events):
        event, value = next(events)
        if event == "start_array":
            yield from ((key, _whole(events, *item)) for item in _until("end_array", events))
        else:
            yield key, _whole(events, event, value)
    # The parser sees whether anything follows.
    next(events, None)


def _whole(events: _Events, event: str, value: Any, levels: int = DEEPEST) -> Any:
    """The value that begins with this event.  Raises: ValueError if it is nested too deep."""
    if event not in _BEGIN:
        return value
    if not levels:
        raise ValueError(f"it is nested deeper than {DEEPEST} levels")
    if event == "start_array":
        return [
            _whole(events, event, value, levels - 1) if event in _BEGIN else value
            for event, value in _until("end_array", events)
        ]
    made = {}
    for _, key in _until("end_map", events):
        event, value = next(events)
        made[key] = _whole(events, event, value, levels - 1) if event in _BEGIN else value
    return made


def _until(end: str, events: _Events) -> _Events:
    """The events up to the next `end` that was not consumed elsewhere; the parser ensures that it comes."""
    return iter(partial(next, events), (end, None))


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
