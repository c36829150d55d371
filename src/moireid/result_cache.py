"""Rows of figures kept in a file of JSON lines, so that an interrupted run can be continued.

Convention: one object per line, {"key": ..., "row": {...}}; the last line of a key counts.  A key includes all that the
    row depends on, also the program (`program_digest`), so that a change leads to a new measurement.
"""

from __future__ import annotations

import hashlib
import json
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

#: The packages of the project; the last two may be absent.
PACKAGES = ("moireid", "moireid_studio", "moireid_lab")


@cache
def program_digest(*rooms: str) -> str:
    """Digest of the project's sources: of the top-level modules of `moireid` and the given `rooms`, or of every
    installed package of the project if none is given.

    Parameters: rooms: folders of `moireid`, such as "verifier".
    """
    digest = hashlib.sha256()
    for package in PACKAGES[:1] if rooms else PACKAGES:
        found = find_spec(package)
        if found is None or found.origin is None:
            continue
        root = Path(found.origin).parent
        for source in sorted(root.rglob("*.py")):
            name = source.relative_to(root)
            if not rooms or len(name.parts) == 1 or any(name.is_relative_to(room) for room in rooms):
                digest.update(f"{package}/{name.as_posix()}".encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


def kept_rows(path: Path | None) -> dict[str, dict[str, Any]]:
    """Rows of an earlier run by their key; an incomplete or invalid line is skipped."""
    rows: dict[str, dict[str, Any]] = {}
    if path is None or not path.exists():
        return rows
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(entry, dict) and isinstance(entry.get("key"), str) and isinstance(entry.get("row"), dict):
            rows[entry["key"]] = entry["row"]
    return rows


def keep_row(path: Path | None, key: str, row: dict[str, Any]) -> None:
    """Add a row to the file, on a new line even if the last line is incomplete; path None: do nothing."""
    if path is None:
        return
    line = json.dumps({"key": key, "row": row}, allow_nan=False) + "\n"
    with path.open("ab+") as file:
        if file.tell():
            file.seek(-1, 2)
            line = line if file.read(1) == b"\n" else "\n" + line
        file.write(line.encode())
