"""Reads an export into an empty registry, without checks of signatures: the audit makes them afterwards.

Also the notes on names that an import shows: names that look alike, and names with invisible letters.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, func, insert, select

from moireid.errors import RegistryError
from moireid.names import hidden_words
from moireid.registry import schema
from moireid.registry.canonical import canonical_json, pack
from moireid.registry.engine import translated, writing
from moireid.registry.export import FORMAT, VERSION, walk
from moireid.registry.keys import Authority
from moireid.registry.ledger import Ledger
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.schema import badges

CHUNK = 1000
#: Versions of the format that are read.
VERSIONS = tuple(range(1, VERSION + 1))
#: Every JSON reader reads sequence numbers up to here as exact whole numbers.
LAST_SEQ = 2**53

_DOCUMENTS = {"badge", "as_built"}
_NULLABLE = {column.name for column in (*schema.badges.c, *schema.log.c) if column.nullable}
#: Columns that are computed, and those that a version of the format did not have.
_DERIVED = {"skeleton", "folded"}
_STATES = {"suspended_at", "suspended_reason", "expires", "compromised_since"}
_ABSENT = {1: {"salt", "actor"} | _STATES, 2: _STATES}


def load(path: Path, copy: Ledger) -> None:
    """Read the export at `path` into `copy`, which is empty and has no authority.

    Raises: RegistryError if the file cannot be read, or is no export that this version knows.
    """
    try:
        with path.open("rb") as stream, translated(copy.url), writing(copy.engine) as connection:
            header = _load(walk(stream), connection)
            authority = Authority(_text(header["authority"]["public_key"]))
            if header["authority"]["fingerprint"] != authority.fingerprint:
                raise ValueError("its fingerprint is not that of its public key")
            head = header["authority"]["head"]
            values = {"one": 1, "public_key": authority.public_hex, "head_seq": _seq(head["seq"])}
            values |= {"head_hash": _text(head["hash"]), "head_signature": _text(head["signature"])}
            connection.execute(insert(schema.authority).values(values))
    except OSError as error:
        raise RegistryError(f"export {path} cannot be read ({error.strerror}); give the path of one") from error
    except (KeyError, TypeError, ValueError) as error:
        # The remaining cause is text that cannot be encoded.
        what = f"{error} is missing" if isinstance(error, KeyError) else "it is not UTF-8 text"
        raise _damaged(path, str(error) if type(error) in (ValueError, TypeError) else what) from error
    copy.adopt(authority.public_hex)


def _load(parts: Any, connection: Connection) -> dict[str, Any]:
    """Store records and log; returns what else the file says."""
    header: dict[str, Any] = {}
    tables = {
        "records": (schema.badges, _record_row, "id"),
        "actors": (schema.actors, _actor_row, "commitment"),
        "log": (schema.log, _entry_row, "seq"),
    }
    waiting: dict[str, list[dict[str, Any]]] = {key: [] for key in tables}
    last: dict[str, Any] = {}
    for key, value in parts:
        if key not in tables:
            if key in header:
                raise ValueError(f"{key!r} is there twice")
            header[key] = value
            continue
        version = header.get("version")
        if header.get("format") != FORMAT or version not in VERSIONS:
            raise ValueError(f"it is no export of a moireid registry, version {VERSIONS[0]} to {VERSIONS[-1]}")
        table, row_of, order = tables[key]
        rows = waiting[key]
        rows.append(row_of(value, _ABSENT.get(version, set())))
        # In the order in which export writes them; this also excludes duplicates.
        if key in last and not last[key] < rows[-1][order]:
            raise ValueError(f"its {key} are not in order")
        last[key] = rows[-1][order]
        if len(rows) == CHUNK:
            connection.execute(insert(table), rows)
            rows.clear()
    for key, rows in waiting.items():
        if rows:
            connection.execute(insert(tables[key][0]), rows)
    if "authority" not in header or not isinstance(header["authority"], dict):
        raise ValueError(f"it is no export of a moireid registry, version {VERSIONS[0]} to {VERSIONS[-1]}")
    return header


def _record_row(item: Any, absent: set[str]) -> dict[str, Any]:
    """The row of `badges` that an item of `records` writes; absent: columns that its version does not have."""
    row = _row(item, _DERIVED | absent, schema.badges.c.keys(), _record_value)
    name = row["name_nfc"]
    return row | {"skeleton": skeleton(name), "folded": folded_skeleton(name)}


def _record_value(key: str, value: Any) -> Any:
    if key in _DOCUMENTS:
        if value is None and key in _NULLABLE:
            return None
        if not isinstance(value, dict):
            raise ValueError(f"{key} is no document")
        return pack(canonical_json(value))
    return _word(key, value)


def _entry_row(item: Any, absent: set[str]) -> dict[str, Any]:
    """The row of `log` that an item of the log writes."""
    return _row(
        item, absent, schema.log.c.keys(), lambda key, value: _seq(value) if key == "seq" else _word(key, value)
    )


def _actor_row(item: Any, absent: set[str]) -> dict[str, Any]:
    """The row of `actors` that an item of `actors` writes."""
    return _row(item, set(), schema.actors.c.keys(), _word)


def _row(item: Any, absent: set[str], keys: list[str], read: Callable[[str, Any], Any]) -> dict[str, Any]:
    """The row that an item writes, which must have these keys and no others; those that are absent are None."""
    present = [key for key in keys if key not in absent]
    if not isinstance(item, dict) or set(item) != set(present):
        raise ValueError(f"a record or entry does not hold {', '.join(present)}")
    return {key: read(key, item[key]) if key in present else None for key in keys}


def _word(key: str, value: Any) -> Any:
    return None if value is None and key in _NULLABLE else _text(value)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{str(value)[:40]} is where text should be")
    value.encode()
    return value


def _seq(value: Any) -> int:
    if type(value) is not int or not 1 <= value <= LAST_SEQ:
        raise ValueError(f"{str(value)[:40]} is where a sequence number should be")
    return value


def _damaged(path: Path, what: str) -> RegistryError:
    return RegistryError(f"export {path} is cut, damaged or none ({what}); nothing was imported, so get another copy")


#: At most this many groups of names of each kind are reported, with at most this many names each.
MOST_NAMES = 20


def notes_on(ledger: Ledger) -> tuple[str, ...]:
    """A sentence for each group of names in the registry that look alike, and for each name with hidden letters.

    An import accepts such names: an older registry may hold them, and a backup must be restored whole.
    """
    found = []
    for look in (badges.c.skeleton, badges.c.folded):
        several = select(look).group_by(look).having(func.count(badges.c.name_nfc.distinct()) > 1).limit(MOST_NAMES)
        for row in ledger.rows(several):
            names = ledger.rows(select(badges.c.name_nfc).where(look == row[0]).distinct().limit(MOST_NAMES))
            listed = " and ".join(repr(one) for one in sorted(name for (name,) in names))
            found.append(f"the names {listed} look alike, and are of different people")
    for (name,) in ledger.rows(select(badges.c.name_nfc).where(badges.c.name_nfc.is_not(None))):
        if not name.isascii() and (words := hidden_words(unicodedata.normalize("NFC", name))):
            found.append(f"the name {name!r} {words}")
    return tuple(dict.fromkeys(found))
