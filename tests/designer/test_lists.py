"""Lists as spreadsheets save them.  Each test names the fault that it catches."""

from __future__ import annotations

import pytest

from moireid.designer.list_table import read_list
from moireid.designer.people import design_people, parse_people
from moireid.designer.request import Request
from moireid.errors import SpecError
from moireid.names import line_of

ROWS = "Name;Line\r\nZoë Müller;Reporter, Example News\r\n\r\n“Bo” O’Neil;\r\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("mark", [";", "\t", "|", ","])
def test_encodings_and_separators_of_spreadsheets_are_read(encoding: str, mark: str) -> None:
    """Catches: a separator or an encoding that makes one column of a list; rows that are counted without empty ones."""
    text = ROWS.replace("Reporter, Example News", '"Reporter, Example News"').replace(";", mark)
    listed = read_list(text.encode(encoding))
    assert [(row, cells["name"], cells["line"]) for row, cells in listed.rows] == [
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
        (b"name\nAda\nBo;Reporter\n", "row 3 of the list is split by semicolons"),
        ("name\nAda\nZo\ufffd\n".encode(), "row 3 of the list has a letter that was lost"),
        (b'name;line\nAda;x\nBo;"y\n', "row 3"),
        (b"name;line\nAda;x;y\n", "row 2 of the list has 3 cells"),
        ("name\nAda".encode("utf-16")[:-1], "UTF-16 and is cut"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_row(data: bytes, words: str) -> None:
    """Catches: letters of another encoding on a badge, a role taken for a part of the name, a bare traceback."""
    with pytest.raises(SpecError, match=words):
        read_list(data)


def test_namesakes_are_distinguished_by_their_lines() -> None:
    """Catches: a line that is read and lost; a warning about people whose lines differ, or none about twins."""
    people = parse_people(b"name,line1,line2\nAna Silva,Reporter,News\nAna Silva,,Editor\n").people
    assert [one.note for one in design_people(people, Request("Everybody"))] == [None, None]
    people = parse_people(b"name,role\nAna Silva,Reporter\nAna Silva,Editor\nAna Silva,Editor\n").people
    results = list(design_people(people, Request("Everybody")))
    assert [line_of(one.badge.print) for one in results if one.badge] == ["Reporter", "Editor", "Editor"]
    assert [one.note for one in results[:2]] == [None, None]
    assert results[2].note and results[2].note.startswith(
        "rows 3 and 4 bear the name 'Ana Silva' and the line 'Editor'"
    )
