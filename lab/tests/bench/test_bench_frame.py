"""The frame of benches: tables, choice of cases, output.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import pytest

from moireid.errors import SpecError
from moireid_lab.bench.bench_rows import chosen_names
from moireid_lab.evaluation.text_table import table_lines

COLUMNS = {"film": "name <6", "gain": ">7.2f", "share": "fine.share >6.0%", "why": "<1", "sum": ">4"}


def test_a_row_shows_what_it_has_of_the_columns():
    """Catches: columns in a row's own order, a heading that is no key of the row, a table that goes on under others."""
    rows = [
        {"gain": 1.234, "name": "a", "why": ["x", "y"], "hidden": 1},
        {"gain": None, "name": "long name", "why": []},
        {"sum": 2},
        {"fine": {"share": 0.5}, "name": "b"},
    ]
    assert list(table_lines(rows, COLUMNS)) == [
        "film      gain why",
        "a         1.23 x y",
        "long name       -",
        "",
        " sum",
        "   2",
        "",
        "film    share",
        "b         50%",
    ]


def test_names_are_those_that_are_asked_for():
    """Catches: a name that no case has taken for all."""
    assert chosen_names(["ab", "ba"], "^b") == ["ba"]
    with pytest.raises(SpecError, match="no case's name holds 'z'"):
        chosen_names(["a"], "z")
