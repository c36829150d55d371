"""Rows as a table of text, for benches and for collections."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import reduce
from typing import Any

Row = Mapping[str, Any]
#: Format of each column by its heading: `<` or `>`, the width, and Python's format of its values; before it, where the
#: rows have it under another key than the heading, that key and a space (`fine.image >8.2%`: of an object in the row).
Columns = Mapping[str, str]


def table_lines(rows: Iterable[Row], columns: Columns) -> Iterator[str]:
    """Rows as text, each as it comes.

    Convention: a row shows what it has of the columns, in their order; where that differs from the row before, a new
    table begins.  None is a dash.
    """
    shown: list[str] | None = None
    for row in rows:
        names = [name for name, spec in columns.items() if _key(name, spec)[0] in row]
        if names != shown:
            yield from ([] if shown is None else [""])
            yield _line((name, columns[name]) for name in names)
            shown = names
        yield _line((_text(_value(row, _key(name, columns[name])), columns[name]), columns[name]) for name in names)


def _key(name: str, spec: str) -> list[str]:
    """Where a row has the value of a column."""
    return spec.rpartition(" ")[0].split(".") if " " in spec else [name]


def _value(row: Row, key: list[str]) -> Any:
    return reduce(lambda part, name: part[name], key, row)


def _line(cells: Iterable[tuple[str, str]]) -> str:
    """Texts with the formats of their columns, each as wide as its column, a space apart."""
    sides = [(text, *re.split(r"(?<=[<>])(\d+)", spec.rpartition(" ")[2])[:2]) for text, spec in cells]
    return " ".join(f"{text:{side}{width}}" for text, side, width in sides).rstrip()


def _text(value: Any, spec: str) -> str:
    if value is None:
        return "-"
    if isinstance(value, (list, tuple)):
        return " ".join(map(str, value))
    return format(value, "" if isinstance(value, str) else re.sub(r".*[<>]\d+", "", spec))
