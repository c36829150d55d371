"""Reads an export into an empty registry, without checks; the audit checks it afterwards."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, insert

from moireid.errors import RegistryError
from moireid.registry import schema
from moireid.registry.canonical import canonical_json, pack
from moireid.registry.engine import translated, writing
from moireid.registry.keys import Authority
from moireid.registry.ledger import Ledger
from moireid.registry.transfer.export import FORMAT, VERSION
from moireid.registry.transfer.jsonstream import walk

CHUNK = 1000
#: Every JSON reader reads sequence numbers up to here as exact whole numbers.
LAST_SEQ = 2**53

_DOCUMENTS = {"badge", "as_built"}
_NULLABLE = {column.name for column in schema.badges.c if column.nullable}


def load(path: Path, copy: Ledger) -> None:
    """Read the export at `path` into `copy`, which is empty and has no authority.

    Raises: RegistryError where the file cannot be read, or is no export that this version knows.
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
    tables = {"records": (schema.badges, _record_row, "id"), "log": (schema.log, _entry_row, "seq")}
    waiting: dict[str, list[dict[str, Any]]] = {"records": [], "log": []}
    last: dict[str, Any] = {}
    for key, value in parts:
        if key not in tables:
            if key in header:
                raise ValueError(f"{key!r} stands there twice")
            header[key] = value
            continue
        if (header.get("format"), header.get("version")) != (FORMAT, VERSION):
            raise ValueError(f"it is no export of a moireid registry, version {VERSION}")
        table, row_of, order = tables[key]
        rows = waiting[key]
        rows.append(row_of(value))
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
        raise ValueError(f"it is no export of a moireid registry, version {VERSION}")
    return header


def _record_row(item: Any) -> dict[str, Any]:
    """The row of `badges` that an item of `records` writes."""
    return _row(item, schema.badges.c.keys(), _record_value)


def _record_value(key: str, value: Any) -> Any:
    if value is None and key in _NULLABLE:
        return None
    if key in _DOCUMENTS:
        if not isinstance(value, dict):
            raise ValueError(f"{key} is no document")
        return pack(canonical_json(value))
    return _text(value)


def _entry_row(item: Any) -> dict[str, Any]:
    """The row of `log` that an item of the log writes."""
    return _row(item, schema.log.c.keys(), lambda key, value: _seq(value) if key == "seq" else _text(value))


def _row(item: Any, keys: list[str], read: Callable[[str, Any], Any]) -> dict[str, Any]:
    """The row that an item writes, which must have these keys and no others."""
    if not isinstance(item, dict) or set(item) != set(keys):
        raise ValueError(f"a record or entry does not hold {', '.join(keys)}")
    return {key: read(key, item[key]) for key in keys}


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{str(value)[:40]} stands where text should")
    value.encode()
    return value


def _seq(value: Any) -> int:
    if type(value) is not int or not 1 <= value <= LAST_SEQ:
        raise ValueError(f"{str(value)[:40]} stands where a sequence number should")
    return value


def _damaged(path: Path, what: str) -> RegistryError:
    return RegistryError(f"export {path} is cut, damaged or none ({what}); nothing was imported, so get another copy")
