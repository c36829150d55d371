"""Rows of figures kept in a file of JSON lines, so that a long run that was broken off goes on.

Convention: one object a line, {"key": ..., "row": {...}}; the last line of a key holds.  A key names all that the row
depends on, the program among it (`program_digest`), so that what changed is measured anew.
"""

from __future__ import annotations

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any

import moireid


@cache
def program_digest(*rooms: str) -> str:
    """Digest of the package's sources: of the ground and the `rooms` named, or of everything where none is named.

    Parameters: rooms: folders of the package, such as "verifier" or "evaluation/baseline".
    """
    root = Path(moireid.__file__).parent
    digest = hashlib.sha256()
    for source in sorted(root.rglob("*.py")):
        name = source.relative_to(root)
        if not rooms or len(name.parts) == 1 or any(name.is_relative_to(room) for room in rooms):
            digest.update(name.as_posix().encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


def kept_rows(path: Path | None) -> dict[str, dict[str, Any]]:
    """Rows of an earlier run by their key; a line that was cut off, or is no row, is passed over."""
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
    """Add a row to the file, on a line of its own even where the last line was cut off; None keeps nothing."""
    if path is None:
        return
    line = json.dumps({"key": key, "row": row}, allow_nan=False) + "\n"
    with path.open("ab+") as file:
        if file.tell():
            file.seek(-1, 2)
            line = line if file.read(1) == b"\n" else "\n" + line
        file.write(line.encode())
