"""A list of people (CSV), and the badge of each: used by `--people` and by the studio's page for an event.

The list is read as spreadsheets save it: its encoding, its separator, its rows.  If the encoding is a guess, the list
is read with a note that says so.  Text that fits no known encoding is refused with its row: a name in the wrong letters
would be printed and enrolled, and no one could claim it.

Convention: rows are counted as a spreadsheet does, so the first line is row 1 and the first person is in row 2.
"""

from __future__ import annotations

import codecs
import csv
import io
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from moireid.badge import Badge
from moireid.designer.drawn import DrawnBadge, HolderOf, drawn_badge
from moireid.designer.request import Request, clean_name, payload_from_hex
from moireid.errors import MoireIdError, SpecError
from moireid.files import MOST_TABLE_BYTES, AnyPath, read_regular
from moireid.names import LINE_COLUMNS, PICTURE_COLUMNS, line_of
from moireid.user_settings import nearest

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
#: How files begin that are no text, though a spreadsheet opens them.
WORKBOOKS = {b"PK\x03\x04": "a workbook (such as .xlsx or .ods)", b"\xd0\xcf\x11\xe0": "an Excel workbook (.xls)"}
#: Taken where a list is not Unicode: Excel saves "CSV" so in western Europe and America.
WESTERN = "cp1252"
#: Signs within and at the end of words that names and offices do have.
GOOD_SIGNS, CLOSING, OPENING = "’‘´·–—®™©", "”“»…", "“„‚«‹¡¿…•"
#: Polish ś before w and ć and at a word's end, read as Windows-1252; no word of its own languages has them.
WRONG_PAIRS = ("œw", "œæ", "œ ")
#: So many cells are shown in which a guess matters.
SHOWN = 10
SAVE_AS = "save it as “CSV UTF-8”"

#: What is wrong with the rows of a list, by their numbers.
RowFaults = dict[int, SpecError]


@dataclass(frozen=True)
class ListTable:
    """The cells of a list.

    columns: the first line's cells, in lower case; rows: each person's row number and cells, by column; note: a
    sentence about what was guessed because the file does not state it, None where nothing was guessed.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[int, Mapping[str, str]], ...]
    note: str | None = None


def read_list(
    data: bytes, *, source: str = "the list", needed: str = "name", faults: RowFaults | None = None
) -> ListTable:
    """The rows of a list's bytes; `source` names it in messages, and its columns hold `needed`.

    Parameters: faults: takes the rows that do not fit, which are then left out; None to raise the first one's.
    Raises: SpecError with the row, where it is no such list, has a column twice, or holds a row that does not fit.
    """
    text, note = decoded(data, source)
    rows, separator = _rows(text, source, needed)
    columns = tuple(cell.strip().lower() for cell in rows[0])
    for column in columns:
        if column and columns.count(column) > 1:
            raise SpecError(f"{source} has {columns.count(column)} columns {column}; leave one of them")
    people = []
    for number, row in enumerate(rows[1:], start=2):
        if any(cell.strip() for cell in row):
            try:
                _check_row(row, number, columns, separator, source)
            except SpecError as error:
                if faults is None:
                    raise
                faults[number] = error
                continue
            cells = [cell.strip() for cell in row] + [""] * (len(columns) - len(row))
            people.append((number, {column: cells[k] for k, column in enumerate(columns)}))
    return ListTable(columns, tuple(people), _with_examples(note, people, needed))


def decoded(data: bytes, source: str = "the list") -> tuple[str, str | None]:
    """The text of a list's bytes, and what to say where its encoding is a guess.

    Raises: SpecError where it is a workbook, or no encoding that is known here.
    """
    for begin, what in WORKBOOKS.items():
        if data.startswith(begin):
            raise unreadable(source, f"it is {what}, no text; {SAVE_AS}")
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in data[:200]:
        return _utf16(data, source), None
    try:
        return data.decode("utf-8-sig"), None
    except UnicodeDecodeError:
        pass
    try:
        text = data.decode(WESTERN)
    except UnicodeDecodeError as error:
        row = data[: error.start].count(b"\n") + 1
        raise unreadable(source, f"row {row} is neither UTF-8 nor Windows-1252; {SAVE_AS}") from error
    for row, line in enumerate(text.splitlines(), start=1):
        if strange := _strange(line):
            raise unreadable(
                source,
                f"row {row} is not UTF-8, and as Windows-1252 it has {strange!r} within a word, which no name "
                f"has; {SAVE_AS}",
            )
    return text, f"{source} is not UTF-8 and was read as Windows-1252"


def _utf16(data: bytes, source: str) -> str:
    """UTF-16 text, which spreadsheets call "Unicode text"; without a byte order mark, the zero bytes show the order."""
    marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    encoding = "utf-16" if marked else "utf-16-be" if data[:200:2].count(0) > data[1:200:2].count(0) else "utf-16-le"
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise unreadable(source, f"it begins as UTF-16 and is cut or damaged; {SAVE_AS}") from error


def _strange(line: str) -> str | None:
    """A letter that no Windows-1252 word has: another encoding's letter read as a sign, or as a capital in a word."""
    for before, sign, after in zip(" " + line, line, line[1:] + " ", strict=False):
        wrong = _odd_sign if not sign.isalpha() else _odd_letter
        if ord(sign) > 127 and wrong(before, sign, after):
            return sign
    return None


def _odd_sign(before: str, sign: str, after: str) -> bool:
    """Whether a sign is within a word, at its end or at its beginning, where real words have none."""
    if sign in GOOD_SIGNS:
        return False
    if before.isalpha():
        return after.isalpha() or (_parts(after) and sign not in CLOSING)
    return after.isalpha() and _parts(before) and sign not in OPENING and not sign.isspace()


def _odd_letter(before: str, letter: str, after: str) -> bool:
    """Whether no word has a letter there: a capital after a small letter, or before a letter that never follows it."""
    pair = (letter + (" " if _parts(after) else after)).lower()
    return (before.islower() and letter.isupper()) or pair in WRONG_PAIRS


def _parts(letter: str) -> bool:
    """Whether a sign separates words or cells."""
    return letter.isspace() or letter == '"' or letter in SEPARATORS


def _rows(text: str, source: str, needed: str) -> tuple[list[list[str]], str]:
    """All rows, and the separator, found in the first line.  Raises: SpecError where it lacks the column `needed`."""
    stated = text[4] if text[:4].lower() == "sep=" and text[4:5] in SEPARATORS else None
    # Excel's own line of one separator is no row of the sheet.
    text = text.partition("\n")[2] if stated else text
    # Not splitlines: it would split a name that contains a line separator into two people.
    first = text.partition("\n")[0].rstrip("\r")
    heads = {mark: _head(first, mark) for mark in ([stated] if stated else SEPARATORS)}
    fitting = [mark for mark, head in heads.items() if needed in head]
    if not fitting:
        raise SpecError(
            f"row 1 of {source} has no column {needed}; it must be '{needed}' or '{needed},line', got {first[:60]!r}; "
            "write it above the first person"
        )
    separator = max(fitting, key=lambda mark: len(heads[mark]))
    rows: list[list[str]] = []
    try:
        for row in csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True):
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


def _with_examples(note: str | None, people: list[tuple[int, dict[str, str]]], needed: str) -> str | None:
    """A note with the rows in which the guess shows, the cells of the column `needed` first."""
    cells = [(number, column, cell) for number, row in people for column, cell in row.items() if not cell.isascii()]
    if note is None or not cells:
        return note
    cells.sort(key=lambda one: one[1] != needed)
    shown = ", ".join(f"row {number} has {cell[:60]!r}" for number, _, cell in cells[:SHOWN])
    more = f" and {len(cells) - SHOWN} more" if len(cells) > SHOWN else ""
    return f"{note}: {shown}{more}; if a letter is wrong there, {SAVE_AS}"


def unreadable(source: str, why: str | None) -> SpecError:
    """The error of a list that cannot be used as a whole."""
    return SpecError(f"{source} cannot be read: {why}")


MOST_PEOPLE = 10_000
#: Checks a name against the fonts: returns None if they print all of it, else what they leave out; raises if nothing
#: is left.
NameNote = Callable[[str], str | None]


@dataclass(frozen=True)
class PersonRow:
    """One row of a list: its number, name and payload as given (empty where none is), and all cells by column."""

    row: int
    name: str
    payload: str
    cells: Mapping[str, str] = field(default_factory=dict)

    @property
    def line(self) -> str:
        """The first line below the name, empty where none is given: the column line, line1 and so on, or else role."""
        return next((self.cells[column] for column in (*LINE_COLUMNS, "role") if self.cells.get(column)), "")


@dataclass(frozen=True)
class PeopleList:
    """The people of a list; notes: what was guessed on reading it, and which columns are not used."""

    people: tuple[PersonRow, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class DesignResult:
    """A person and either the badge, or why there is none.

    note: what there is to say of the badge; name_note: what its print leaves out of the name.
    """

    person: PersonRow
    badge: Badge | None = None
    fault: SpecError | None = None
    note: str | None = None
    name_note: str | None = None


def read_people(people_csv: AnyPath, *, faults: RowFaults | None = None) -> PeopleList:
    """The people of a CSV file; faults: as for `read_list`.

    Raises: SpecError as `parse_people`, and where the file cannot be read.
    """
    try:
        data = read_regular(people_csv, MOST_TABLE_BYTES)
    except OSError as error:
        raise unreadable(str(people_csv), f"{error.strerror}; give a CSV file with a column name") from error
    return parse_people(data, source=str(people_csv), faults=faults)


def parse_people(data: bytes, *, source: str = "the list", faults: RowFaults | None = None) -> PeopleList:
    """The people of the bytes of a CSV file; `source` names it in messages, and faults are as for `read_list`.

    Raises: SpecError as `read_list`, and where the list names no one or too many people.
    """
    listed = read_list(data, source=source, faults=faults)
    people = [PersonRow(row, cells["name"], cells.get("payload", ""), cells) for row, cells in listed.rows]
    if not 1 <= len(people) + len(faults or ()) <= MOST_PEOPLE:
        raise SpecError(f"{source} names {len(people)} people; 1 to {MOST_PEOPLE} can be printed at once")
    notes = (listed.note, _unused(listed.columns, source))
    return PeopleList(tuple(people), tuple(note for note in notes if note))


def _unused(columns: Iterable[str], source: str) -> str | None:
    """A note on columns that nothing is printed of, each with the column that may have been meant."""
    known = ("name", *LINE_COLUMNS, "role", "payload", *PICTURE_COLUMNS)
    unused = [f"{column[:40]!r}{nearest(column, known)}" for column in columns if column and column not in known]
    if not unused:
        return None
    more = f" and {len(unused) - SHOWN} more" if len(unused) > SHOWN else ""
    return (
        f"nothing is printed of {Path(source).name}'s column{'s' if len(unused) > 1 else ''} "
        f"{', '.join(unused[:SHOWN])}{more}; the columns that count are {', '.join(known[:-1])}"
    )


def design_people(
    people: Iterable[PersonRow],
    request: Request,
    *,
    holder_of: HolderOf | None = None,
    source: str = "the list",
    name_note: NameNote = lambda name: None,
    line: str = "",
) -> Iterator[DesignResult]:
    """A badge for each person, in order, or the fault of that row.

    An identity that the list does not give is drawn, once: going through the list again draws others.  If two rows have
    the same identity, the later one is at fault; two rows of one name and one line are a note.

    Parameters: holder_of: as for `drawn_badge`; name_note: a `NameNote`, which `fabrication` provides; line: the first
        line for rows that have none.
    """
    rows: dict[str, int] = {}
    names: dict[tuple[str, str | None], int] = {}
    for person in people:
        where = f"row {person.row} of {Path(source).name} ({person.name[:40]!r})"
        try:
            missing_letters = name_note(clean_name(person.name))
            drawn = _drawn(person, request, holder_of, rows)
        except MoireIdError as error:
            fault = SpecError(f"{where}: {error}")
            fault.__cause__ = error
            yield DesignResult(person, fault=fault)
            continue
        badge = drawn.badge
        badge_id = badge.id or ""
        if badge_id in rows:
            fault = SpecError(
                f"rows {rows[badge_id]} and {person.row} of {Path(source).name} give one identity, {badge_id}; give "
                "another payload in one of them, or none, and one is drawn"
            )
            yield DesignResult(person, fault=fault)
            continue
        rows[badge_id] = person.row
        shown = line_of(badge.print) or unicodedata.normalize("NFC", line).strip() or None
        twin = names.setdefault((badge.name, shown), person.row)
        note = drawn.note if twin == person.row else _alike(twin, person.row, badge.name, shown)
        yield DesignResult(person, badge, note=note, name_note=missing_letters)


def _drawn(person: PersonRow, request: Request, holder_of: HolderOf | None, taken: Mapping[str, int]) -> DrawnBadge:
    """The badge of one row, of an identity that no row before has where one is drawn.  Raises: as `drawn_badge`."""
    wish = wish_of(person, request)
    if person.payload:
        chosen = payload_from_hex(person.payload, family=request.family or "spacing")
        return with_line(drawn_badge(wish, chosen, None), person)
    drawn = drawn_badge(wish, None, holder_of)
    # Of 24 bits two people of a long list draw the same now and then.
    while drawn.badge.id in taken:
        drawn = drawn_badge(wish, None, holder_of)
    return with_line(drawn, person)


def wish_of(person: PersonRow, request: Request) -> Request:
    """The request for one person of a list.  Raises: SpecError as `clean_name`."""
    return replace(request, name=clean_name(person.name))


def with_line(drawn: DrawnBadge, person: PersonRow) -> DrawnBadge:
    """The same, with the line below the name in the badge's print data."""
    if not person.line:
        return drawn
    line = clean_name(person.line, "line")
    return replace(drawn, badge=replace(drawn.badge, print=(drawn.badge.print or {}) | {"lines": [line]}))


def _alike(twin: int, row: int, name: str, line: str | None) -> str:
    also = f" and the line {line[:40]!r}" if line else ""
    return (
        f"rows {twin} and {row} bear the name {name[:40]!r}{also}, so claims distinguish them by "
        "their ids alone; a column line, such as what each does, is printed below the name and distinguishes them too"
    )


def without_held(designed: Iterable[DesignResult], request: Request, holder_of: HolderOf) -> Iterator[DesignResult]:
    """The same, once the registry can be asked: a random identity that another person holds is drawn again."""
    for one in designed:
        if one.badge is None or one.person.payload or holder_of(one.badge.id or "") is None:
            yield one
        else:
            drawn = with_line(drawn_badge(wish_of(one.person, request), None, holder_of), one.person)
            yield replace(one, badge=drawn.badge)


def badges_of(designed: Iterable[DesignResult]) -> list[Badge]:
    """The badges of a list.  Raises: the first row's fault."""
    badges = []
    for one in designed:
        if one.fault is not None:
            raise one.fault
        assert one.badge is not None
        badges.append(one.badge)
    return badges
