"""Lists that people write: CSV files with a line for each film."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from moireid.errors import SpecError
from moireid.files import MOST_TABLE_BYTES, read_regular

#: A row by its columns, with the number of its line.
Line = tuple[int, dict[str, str]]


def read_list(path: Path, what: str, needed: Sequence[str], example: str) -> tuple[list[str], list[Line]]:
    """The columns of a list, in lower case, and its lines that are not empty; a cell that is not there is empty.

    Parameters: what: names the list in a message; needed: columns without which it is none; example: of its first line.
    Raises: SpecError if it cannot be read, lacks a column or has one twice, or a line has too many cells.
    """
    try:
        text = read_regular(path, MOST_TABLE_BYTES).decode("utf-8-sig")
        reader = csv.reader(io.StringIO(text, newline=""), strict=True)
        lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(map(str.strip, row))]
        if "\0" in text:
            raise csv.Error("it holds a NUL")
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SpecError(f"{what} {path} cannot be read ({error}); {example}") from error
    header = [name.lower().lstrip("-") for name in lines[0][1]] if lines else []
    # A spreadsheet writes empty columns at the end.
    while header and not header[-1] and not any(len(row) >= len(header) and row[len(header) - 1] for _, row in lines):
        header.pop()
        lines = [(line, row[: len(header)]) for line, row in lines]
    lacking = [name for name in needed if name not in header]
    if lacking or len(set(header)) < len(header):
        fault = f"has no column {' and no column '.join(lacking)}" if lacking else "names a column twice"
        raise SpecError(f"{what} {path} {fault}, its first line is {','.join(header)[:80]!r}; {example}")
    rows = []
    for line, cells in lines[1:]:
        if len(cells) > len(header):
            raise SpecError(
                f"line {line} of {path.name} has {len(cells)} cells, the first line {len(header)}; put names that hold "
                "a comma in double quotes"
            )
        rows.append((line, dict.fromkeys(header, "") | dict(zip(header, cells, strict=False))))
    return header, rows


def csv_text(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A list as text."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(header)
    lines.writerows(rows)
    return text.getvalue()
