"""A table of people as spreadsheets save it: its encoding, its separator, its rows.

Text that is not Unicode is refused with its row, because its encoding would be a guess: a name in the wrong letters
would be printed and enrolled, and no one could claim it.

Convention: rows are counted as a spreadsheet does, so the first line is row 1 and the first person is in row 2.
"""

from __future__ import annotations

import codecs
import csv
import io
from collections.abc import Mapping
from pathlib import Path

from moireid.errors import SpecError

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
#: How files begin that are no text, though a spreadsheet opens them.
WORKBOOKS = {b"PK\x03\x04": "a workbook (such as .xlsx or .ods)", b"\xd0\xcf\x11\xe0": "an Excel workbook (.xls)"}
SAVE_AS = "save it as “CSV UTF-8”"

Cells = Mapping[str, str]


def read_list(data: bytes, *, source: str = "the list") -> tuple[tuple[str, ...], list[tuple[int, Cells | SpecError]]]:
    """The columns of a list's bytes, in lower case, and each person's row number and cells by column, or its fault.

    Parameters: source: names it in messages.
    Raises: SpecError with the row, where it is no such list, or has a column twice.
    """
    rows, separator = _rows(decoded(data, source), source)
    columns = tuple(cell.strip().lower() for cell in rows[0])
    for column in columns:
        if column and columns.count(column) > 1:
            raise SpecError(f"{source} has {columns.count(column)} columns {column}; leave one of them")
    people: list[tuple[int, Cells | SpecError]] = []
    for number, row in enumerate(rows[1:], start=2):
        if any(cell.strip() for cell in row):
            try:
                _check_row(row, number, columns, separator, source)
            except SpecError as error:
                people.append((number, error))
                continue
            cells = [cell.strip() for cell in row] + [""] * (len(columns) - len(row))
            people.append((number, {column: cells[k] for k, column in enumerate(columns)}))
    return columns, people


def decoded(data: bytes, source: str = "the list") -> str:
    """The text of a list's bytes.  Raises: SpecError where it is a workbook, or not Unicode."""
    for begin, what in WORKBOOKS.items():
        if data.startswith(begin):
            raise unreadable(source, f"it is {what}, no text; {SAVE_AS}")
    # Spreadsheets call it "Unicode text".
    utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if utf16 else "utf-8-sig")
    except UnicodeDecodeError as error:
        row = data[: error.start].count(b"\n") + 1
        why = f"row {row} is not UTF-8, as of a plain CSV of Excel"
        why = "it begins as UTF-16 and is cut or damaged" if utf16 else why
        raise unreadable(source, f"{why}; {SAVE_AS}") from error


def _rows(text: str, source: str) -> tuple[list[list[str]], str]:
    """All rows, and the separator, found in the first line.  Raises: SpecError where it lacks the column name."""
    stated = text[4] if text[:4].lower() == "sep=" and text[4:5] in SEPARATORS else None
    # Excel's own line of one separator is no row of the sheet.
    # Not splitlines: it would split a name that contains a line separator into two people.
    lines = io.StringIO(text, newline="")
    if stated:
        lines.readline()
    start = lines.tell()
    first = lines.readline().rstrip("\r\n")
    lines.seek(start)
    heads = {mark: _head(first, mark) for mark in ([stated] if stated else SEPARATORS)}
    fitting = [mark for mark, head in heads.items() if "name" in head]
    if not fitting:
        raise SpecError(
            f"row 1 of {source} has no column name; it must be 'name' or 'name,line', got {first[:60]!r}; write it "
            "above the first person"
        )
    separator = max(fitting, key=lambda mark: len(heads[mark]))
    rows: list[list[str]] = []
    try:
        for row in csv.reader(lines, delimiter=separator, strict=True):
            rows.append(row)
    except csv.Error as error:
        raise unreadable(source, f"row {len(rows) + 1}: {error}; check its quotes") from error
    return rows, separator


def _head(line: str, mark: str) -> list[str]:
    """The first line's cells by one separator; none where it cannot be split so."""
    try:
        return [cell.strip().lower() for cell in next(csv.reader([line], delimiter=mark, strict=True), [])]
    except csv.Error:
        return []


def _check_row(row: list[str], number: int, columns: tuple[str, ...], separator: str, source: str) -> None:
    """Raise SpecError where a row has more cells than columns, another separator, or letters that were lost."""
    where = f"row {number} of {Path(source).name}"
    # A name with a comma but without quotes would be cut at the comma.
    if any(cell.strip() for cell in row[len(columns) :]):
        raise SpecError(
            f"{where} has {len(row)} cells, and the first line {len(columns)}; put quotes about a name with "
            f'{SEPARATORS[separator][:-1]}s in it, as in "Doe{separator} Jane"'
        )
    whole = separator.join(row)
    if "\ufffd" in whole:
        raise SpecError(f"{where} has a letter that was lost on the way (\ufffd); write it anew, and {SAVE_AS}")
    # A first line of one word does not show the separator.
    other = next((mark for mark in ";\t|" if mark != separator and mark in whole), None)
    if other and len(columns) == 1:
        raise SpecError(
            f"{where} is split by {SEPARATORS[other]}, and the first line is one column; name its columns too, as in "
            f"'name{other}line'"
        )


def unreadable(source: str, why: str | None) -> SpecError:
    """The error of a list that cannot be used as a whole."""
    return SpecError(f"{source} cannot be read: {why}")
