"""Rows in Parquet, written as they come, in a folder of parts that any program may read at any time.

Convention: `part-RUN-NUMBER.parquet`; each run draws RUN at random, so that two runs never write the same file.  Until
    a part is full, each new row rewrites it as a whole.  So a row is on the disk when `add` returns, no reader sees
    half a file, and each key is in one part only.
"""

from __future__ import annotations

import uuid
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from moireid.errors import SpecError
from moireid.extras import missing_extra
from moireid.files import whole_file

#: Rewriting a part of this size takes some milliseconds, and a hundred thousand films give some hundred parts.
ROWS_A_PART = 256
TYPES = ("string", "bool", "int64", "double", "list<string>")


class Parts:
    """The rows in a folder; `columns` is name -> (one of `TYPES`, meaning), and `key` is one of them."""

    def __init__(self, folder: Path, columns: dict[str, tuple[str, str]]) -> None:
        """Raises: MissingExtraError without pyarrow."""
        try:
            import pyarrow as pa
        except ImportError as error:
            raise missing_extra("a table of results", "pyarrow", "", "moireid-lab") from error
        self._folder = folder
        types = dict(
            zip(TYPES, (pa.string(), pa.bool_(), pa.int64(), pa.float64(), pa.list_(pa.string())), strict=True)
        )
        self.schema = pa.schema(
            [pa.field(name, types[kind], metadata={"description": text}) for name, (kind, text) in columns.items()]
        )
        self._run, self._number, self._open = uuid.uuid4().hex[:8], 0, list[dict[str, Any]]()

    def rows(self) -> dict[str, dict[str, Any]]:
        """All rows by key.  Raises: SpecError where a part cannot be read."""
        return {row["key"]: row for path in self._paths() for row in self._read(path)}

    def drop(self, keys: Collection[str]) -> None:
        """Remove rows that will be computed again."""
        for path in self._paths() if keys else []:
            rows = self._read(path)
            kept = [row for row in rows if row["key"] not in keys]
            if kept and len(kept) < len(rows):
                self._write(path, kept)
            elif not kept:
                path.unlink()

    def add(self, rows: Sequence[dict[str, Any]]) -> None:
        """Save rows; they are on the disk when this returns."""
        self._folder.mkdir(parents=True, exist_ok=True)
        self._open += rows
        self._write(self._folder / f"part-{self._run}-{self._number:05d}.parquet", self._open)
        if len(self._open) >= ROWS_A_PART:
            self._open, self._number = [], self._number + 1

    def _paths(self) -> list[Path]:
        return sorted(self._folder.glob("part-*.parquet"))

    def _read(self, path: Path) -> list[dict[str, Any]]:
        import pyarrow as pa
        import pyarrow.parquet as pq

        try:
            rows: list[dict[str, Any]] = pq.read_table(path, partitioning=None).to_pylist()
        except (pa.ArrowException, OSError) as error:
            raise SpecError(f"{path} cannot be read ({' '.join(str(error).split())[:150]}); take it away") from error
        if any("key" not in row for row in rows):
            raise SpecError(f"{path} holds no rows of moireid; choose another output folder, or take it away")
        return rows

    def _write(self, path: Path, rows: list[dict[str, Any]]) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        with whole_file(path) as temporary:
            pq.write_table(pa.Table.from_pylist(rows, schema=self.schema), temporary)
