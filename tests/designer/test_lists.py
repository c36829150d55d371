"""Lists as spreadsheets save them.  Each test names the fault that it catches."""

from __future__ import annotations

import pytest

from moireid.designer.list_table import read_list
from moireid.errors import SpecError

ROWS = "Name;Line\r\nZoë Müller;Reporter, Example News\r\n\r\n“Bo” O’Neil;\r\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("mark", [";", "\t", "|", ","])
def test_encodings_and_separators_of_spreadsheets_are_read(encoding: str, mark: str) -> None:
    """Catches: a separator or an encoding that makes one column of a list; rows that are counted without empty ones."""
    text = ROWS.replace("Reporter, Example News", '"Reporter, Example News"').replace(";", mark)
    _, listed = read_list(text.encode(encoding))
    assert [(row, cells["name"], cells["line"]) for row, cells in listed if not isinstance(cells, SpecError)] == [
        (2, "Zoë Müller", "Reporter, Example News"),
        (4, "“Bo” O’Neil", ""),
    ]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("name\nAda\nJosé Silva\n".encode("cp850"), "row 3 is not UTF-8"),
        ("name\nAda\n山田\n".encode("shift-jis"), "row 3 is not UTF-8"),
        ("name\nAda\nZoë\n".encode("cp1252"), "row 3 is not UTF-8"),
        (b"PK\x03\x04 and more", "a workbook"),
        (b"Ada Lovelace\nBo\n", "row 1 of the list has no column name"),
        (b'name;line\nAda;x\nBo;"y\n', "row 3"),
        ("name\nAda".encode("utf-16")[:-1], "UTF-16 and is cut"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_row(data: bytes, words: str) -> None:
    """Catches: letters of another encoding on a badge, a role taken for a part of the name, a bare traceback."""
    with pytest.raises(SpecError, match=words):
        read_list(data)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"name\nAda\nBo;Reporter\nCy\n", "row 3 of the list is split by semicolons"),
        ("name\nAda\nZo\ufffd\nCy\n".encode(), "row 3 of the list has a letter that was lost"),
        (b"name;line\nAda;x\nBo;y;z\nCy;\n", "row 3 of the list has 3 cells"),
    ],
)
def test_a_row_that_does_not_fit_has_its_fault_and_the_others_are_read(data: bytes, words: str) -> None:
    """Catches: a role taken for a part of the name; a fault that hides those of other rows."""
    _, listed = read_list(data)
    assert [row for row, _ in listed] == [2, 3, 4]
    faults = [str(cells) for _, cells in listed if isinstance(cells, SpecError)]
    assert len(faults) == 1 and faults[0].startswith(words)


def test_rows_that_end_in_a_carriage_return_alone_are_read() -> None:
    """Catches: a list of an old Mac taken for one row."""
    for data in (
        b"name,line\rAda,a\rBo,b\r",
        b"sep=,\rname,line\rAda,a\rBo,b",
    ):
        columns, people = read_list(data)
        assert columns == ("name", "line")
        assert [cells for _, cells in people] == [{"name": "Ada", "line": "a"}, {"name": "Bo", "line": "b"}]
