"""The registry: who was issued which badge.  Beside each test stands the wrong implementation it would catch."""

from __future__ import annotations

import multiprocessing
import re
import sqlite3
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from sqlalchemy import event

import moireid.registry
from moireid.badge import Badge, badge_from_json
from moireid.designer import Request, design_badge, payload_for_name
from moireid.errors import RegistryError, SpecError
from moireid.registry import default_url, open_registry, store

ZOE_NFC, ZOE_NFD = "Zo\u00eb", "Zoe\u0308"


def url_of(path: Path, **options: object) -> str:
    query = "&".join(f"{key}={value}" for key, value in options.items())
    return f"sqlite:///{path}" + ("?" + query if query else "")


def badge_of(name: str, payload: bytes | None = None, **request: object) -> Badge:
    return design_badge(Request(name, **request), payload or payload_for_name(name))  # type: ignore[arg-type]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "people.sqlite3"


@pytest.fixture
def registry(path: Path):
    with open_registry(url_of(path), create=True) as opened:
        yield opened


def test_exported_names():
    assert moireid.registry.__all__ == ["Record", "Registry", "default_url", "open_registry"]


# What comes out is what went in.


def test_record_survives_reopening(path):
    """Catches: no commit; a badge that loses figures on its way through the database."""
    badge = badge_of("Ada")
    with open_registry(url_of(path), create=True) as first:
        enrolled = first.enroll(badge)
    with open_registry(url_of(path), create=False) as again:
        found = again.find("Ada")
    assert found == enrolled
    assert found.badge == badge and found.badge.to_json() == badge.to_json()
    assert (found.id, found.name, found.layout_key) == (badge.id, "Ada", badge.layout_key())
    with pytest.raises(FrozenInstanceError):
        found.name = "Eve"  # type: ignore[misc]


def test_issued_at_is_utc_now_to_the_second(registry, monkeypatch):
    """Catches: local time, microseconds, a stamp without its zone."""
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    time.tzset()
    try:
        before = datetime.now(UTC).replace(microsecond=0)
        stamp = registry.enroll(badge_of("Ada")).issued_at
        after = datetime.now(UTC)
    finally:
        monkeypatch.undo()
        time.tzset()
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", stamp)
    assert before <= datetime.fromisoformat(stamp) <= after


def test_enroll_is_idempotent(path, registry):
    """Catches: a second row, an error, or a second date of issue for the very same badge."""
    first = registry.enroll(badge_of("Ada"))
    long_ago = "2001-02-03T04:05:06Z"
    with sqlite3.connect(path) as raw:
        raw.execute("UPDATE badges SET issued_at = ?", (long_ago,))
    second = registry.enroll(badge_from_json(first.badge.to_json()))
    assert second == replace(first, issued_at=long_ago)
    assert registry.count() == 1


def test_idempotent_where_json_writes_a_number_otherwise(registry):
    """Catches: comparing JSON texts, in which 210 and 210.0 differ although the badge is the same."""
    badge = badge_of("Ada")
    whole = replace(badge, page_mm=(210, 297))
    as_floats = replace(badge, page_mm=(210.0, 297.0))
    assert whole.to_json() != as_floats.to_json()
    assert registry.enroll(whole) == registry.enroll(as_floats)
    assert len(registry.layouts()) == 1


# Whose id it is.


def test_id_of_somebody_else_is_refused(registry):
    """Catches: overwriting, ignoring a conflict, or a message that does not say who holds the id."""
    ada = badge_of("Ada")
    kept = registry.enroll(ada)
    with pytest.raises(RegistryError, match=r"is issued already to 'Ada'.*'Grace' cannot") as caught:
        registry.enroll(badge_of("Grace", bytes.fromhex(ada.id)))
    assert caught.value.details["holder"] == "Ada" and caught.value.details["id"] == ada.id
    assert list(registry.records()) == [kept]


def test_another_badge_of_the_same_name_and_id_is_refused(registry):
    """Catches: idempotence by id and name alone, which would let a badge of another pitch stand for the issued one."""
    kept = registry.enroll(badge_of("Ada"))
    with pytest.raises(RegistryError, match=r"already to 'Ada' with another badge"):
        registry.enroll(badge_of("Ada", lens="60lpi"))
    assert registry.find("Ada") == kept


def test_badge_without_id_is_refused(registry):
    """Catches: a NULL or the word None as an id."""
    with pytest.raises(RegistryError, match="has no id"):
        registry.enroll(replace(badge_of("Ada"), id=None))
    assert registry.count() == 0


@pytest.mark.parametrize("name", ["", "  ", "A\x00da", "A\nda", "A\ud800da"])
def test_name_that_nobody_can_claim_is_refused(registry, name):
    """Catches: a UnicodeEncodeError of the driver; an entry that no claim would ever find."""
    with pytest.raises(RegistryError, match="plain name"):
        registry.enroll(replace(badge_of("Ada"), name=name))


def test_text_that_is_not_unicode_is_refused(registry):
    """Catches: a lone surrogate, which JSON may spell, reaching the driver."""
    with pytest.raises(RegistryError, match="not Unicode"):
        registry.enroll(replace(badge_of("Ada"), print={"by": "\ud800"}))


def test_badge_that_could_not_be_read_back_is_refused(registry):
    """Catches: writing first and finding out at verification: this id is upper case, which the schema forbids."""
    with pytest.raises(SpecError, match="id"):
        registry.enroll(replace(badge_of("Ada"), id="ABCDEF"))
    assert registry.count() == 0


# Claims.


@pytest.mark.parametrize(("enrolled", "claimed"), [(ZOE_NFC, ZOE_NFD), (ZOE_NFD, ZOE_NFC)])
def test_names_match_after_nfc(registry, enrolled, claimed):
    """Catches: comparing code points, on either side."""
    assert enrolled != claimed
    registry.enroll(replace(badge_of("Zoe"), name=enrolled))
    assert registry.find(claimed).name == ZOE_NFC


@pytest.mark.parametrize("claim", ["ada", "ADA", " Ada", "Ada ", "Ad", "Ada%", "Ad_", "", "Ada\x00", "Ada\udcff"])
def test_names_match_exactly(registry, claim):
    """Catches: folding case, trimming, LIKE, and a driver's error on what no database can hold."""
    registry.enroll(badge_of("Ada"))
    with pytest.raises(RegistryError, match="moireid registry list") as caught:
        registry.find(claim)
    assert repr(claim) in str(caught.value)


def test_ligatures_and_wide_letters_stay_apart(registry):
    """Catches: NFKC, under which two different names would be one."""
    registry.enroll(badge_of("\uff21da"))
    with pytest.raises(RegistryError, match="nobody named"):
        registry.find("Ada")


def test_ids_match_in_any_case(registry):
    """Catches: ids compared as typed."""
    record = registry.enroll(badge_of("Ada", bytes.fromhex("abcdef")))
    assert registry.find("ABCDEF") == registry.find("abcdef") == registry.by_id("AbCdEf") == record
    assert registry.is_taken("ABCDEF") and not registry.is_taken("abcdee") and not registry.is_taken("Ada")
    assert registry.by_id("abcdee") is None and registry.by_id("Ada") is None and registry.by_id("\udcff") is None


def test_two_people_of_one_name(registry):
    """Catches: taking the first that comes."""
    ids = ["0a0a0a", "f0f0f0"]
    for badge_id in reversed(ids):
        registry.enroll(badge_of("Ada", bytes.fromhex(badge_id)))
    with pytest.raises(RegistryError, match=r"2 people are named 'Ada', with ids 0a0a0a, f0f0f0") as caught:
        registry.find("Ada")
    assert caught.value.details["ids"] == ids
    assert registry.find("f0f0f0").id == "f0f0f0"


def test_many_people_of_one_name_are_counted_not_all_listed(registry):
    """Catches: a message of a thousand ids; and a count that is off by one."""
    for number in range(store.LISTED + 3):
        registry.enroll(badge_of("Ada", number.to_bytes(3, "big")))
    with pytest.raises(RegistryError, match=r"13 people .* 000009 and 3 more;") as caught:
        registry.find("Ada")
    assert len(caught.value.details["ids"]) == 13


def test_id_of_one_that_is_the_name_of_another(registry):
    """Catches: preferring one kind of claim, so that somebody can take a name that is another's id."""
    registry.enroll(badge_of("Ada", bytes.fromhex("abcdef")))
    registry.enroll(badge_of("ABCDEF", bytes.fromhex("123456")))
    with pytest.raises(RegistryError, match=r"is the id of 'Ada' and also the name on 123456") as caught:
        registry.find("ABCDEF")
    assert caught.value.details["ids"] == ["123456", "abcdef"]
    assert registry.find("abcdef").name == "Ada"  # Names keep their case, so this one is an id alone.
    assert registry.find("123456").name == "ABCDEF" and registry.find("Ada").id == "abcdef"


def test_name_that_is_its_own_id(registry):
    """Catches: counting one record twice where both of its columns match."""
    registry.enroll(badge_of("abcdef", bytes.fromhex("abcdef")))
    assert registry.find("abcdef").id == "abcdef"


# Lists.


def test_records_are_ordered_and_complete_across_pages(registry, monkeypatch):
    """Catches: paging by name alone, which drops or repeats people of one name at a page's edge."""
    monkeypatch.setattr(store, "PAGE", 3)
    names = ["Bo"] * 5 + ["Al"] * 2 + ["Cy"] * 2
    pairs = [(name, bytes([200 - k, 0, k])) for k, name in enumerate(names)]
    for name, payload in pairs:
        registry.enroll(badge_of(name, payload))
    listed = [(record.name, record.id) for record in registry.records()]
    assert listed == sorted((name, payload.hex()) for name, payload in pairs)
    assert registry.count() == len(pairs)


def test_records_are_streamed(registry, monkeypatch):
    """Catches: reading the whole table for the first record."""
    monkeypatch.setattr(store, "PAGE", 2)
    for k in range(6):
        registry.enroll(badge_of("Ada", bytes([0, 0, k])))
    queries = []
    event.listen(registry._engine, "before_cursor_execute", lambda *args: queries.append(args[2]))
    stream = registry.records()
    assert next(stream).id == "000000"
    assert len([query for query in queries if query.startswith("SELECT")]) == 1
    assert len(list(stream)) == 5


def test_enrolling_while_listing(path):
    """Catches: a list that holds a lock as long as its reader takes, and so blocks every enrolment."""
    with open_registry(url_of(path, timeout=0.5), create=True) as registry:
        registry.enroll(badge_of("Ada"))
        stream = registry.records()
        next(stream)
        registry.enroll(badge_of("Bo"))
        assert [record.name for record in stream] in ([], ["Bo"])


def test_layouts_are_one_badge_each(registry):
    """Catches: a badge per record, or layouts told apart by name or id."""
    assert registry.layouts() == []
    wide = {"size_mm": (170.0, 180.0)}
    enrolled = [badge_of("Ada"), badge_of("Bo"), badge_of("Cy", **wide), badge_of("Di", **wide), badge_of("Ed")]
    for badge in enrolled:
        registry.enroll(badge)
    layouts = registry.layouts()
    assert {badge.layout_key() for badge in layouts} == {badge.layout_key() for badge in enrolled}
    assert len(layouts) == 2 and all(badge in enrolled for badge in layouts)
    assert [badge.id for badge in layouts] == sorted(badge.id for badge in layouts)


# Opening.


def test_default_url_is_in_the_users_data_folder(tmp_path, monkeypatch):
    """Catches: a default in the working folder; a path whose odd letters do not survive the URL."""
    home = tmp_path / "dät a"
    monkeypatch.setattr("moireid.registry.url.user_data_path", lambda name, appauthor: home / name)
    assert default_url().startswith("sqlite:///")
    with pytest.raises(RegistryError, match="there is no registry"):
        open_registry(None, create=False)
    assert not home.exists()
    open_registry(None, create=True).close()
    assert (home / "moireid" / "registry.sqlite3").is_file()


def test_absent_file_is_not_made(path):
    """Catches: SQLite's habit of making what it opens."""
    with pytest.raises(RegistryError, match=r"enroll someone first, or run `moireid registry init`"):
        open_registry(url_of(path), create=False)
    assert list(path.parent.iterdir()) == []


def test_create_makes_folders_and_keeps_what_is_there(tmp_path):
    """Catches: a create that empties an existing registry."""
    url = url_of(tmp_path / "a" / "b" / "people.sqlite3")
    with open_registry(url, create=True) as registry:
        registry.enroll(badge_of("Ada"))
    with open_registry(url, create=True) as registry:
        assert registry.find("Ada").name == "Ada"


def test_relative_path_is_that_of_the_opening(tmp_path, monkeypatch):
    """Catches: a registry that follows the working folder about."""
    monkeypatch.chdir(tmp_path)
    registry = open_registry("sqlite:///people.sqlite3", create=True)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    registry.close()
    registry.enroll(badge_of("Ada"))
    registry.close()
    assert list(elsewhere.iterdir()) == []


def test_registry_stays_one_file(path, registry):
    """Catches: a write-ahead log, without which a copy of the file would lack the last enrolments."""
    registry.enroll(badge_of("Ada"))
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("people.sqlite3", "no database URL; give one such as sqlite:///people.sqlite3"),
        ("/tmp/people.sqlite3", "no database URL; give one such as sqlite:///people.sqlite3"),
        ("", "no database URL"),
        ("sqlite:///\udcff", "no database URL"),
        ("sqlite://people.sqlite3", "three slashes"),
        ("sqlite://", "names no file"),
        ("sqlite:///:memory:", "names no file"),
        ("nosuch://host/people", "nosuch"),
        ("sqlite+nosuch:///people.sqlite3", "nosuch"),
        ("sqlite:///people.sqlite3?tiemout=3", "options"),
        ("sqlite:///people.sqlite3?timeout=soon", "soon"),
        ("sqlite:///peo\x00ple.sqlite3", "null"),
        ("sqlite:///" + "n" * 300, "n cannot be used"),
    ],
)
def test_bad_url(url, message, tmp_path, monkeypatch):
    """Catches: SQLAlchemy's and Python's own exceptions reaching the user, and a file made on the way."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RegistryError, match=re.escape(message)) as caught:
        open_registry(url, create=True)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_driver_that_is_not_installed(monkeypatch):
    """Catches: a traceback of ModuleNotFoundError."""
    monkeypatch.setitem(sys.modules, "psycopg", None)
    with pytest.raises(RegistryError, match=r"needs the Python package 'psycopg'"):
        open_registry("postgresql+psycopg://localhost/people", create=False)


@pytest.mark.parametrize("url", ["postgresql+psycopg://ada:s3cret@h/p?sslpassword=s3cret", "pg://ada:s3cret@h:port/p"])
def test_password_is_not_told(url, monkeypatch):
    """Catches: a password in an error message, from where it reaches logs."""
    monkeypatch.setitem(sys.modules, "psycopg", None)
    with pytest.raises(RegistryError) as caught:
        open_registry(url, create=False)
    assert "s3cret" not in str(caught.value)


@pytest.mark.parametrize("create", [False, True])
def test_text_file_is_no_registry_and_stays_as_it_is(path, create):
    """Catches: sqlite3.DatabaseError reaching the user; a text file overwritten by a database."""
    path.write_text("Ada, Bo, Cy\n", encoding="utf-8")
    with pytest.raises(RegistryError, match="not a database") as caught:
        open_registry(url_of(path), create=create)
    assert caught.value.__cause__ is not None
    assert path.read_text(encoding="utf-8") == "Ada, Bo, Cy\n"


@pytest.mark.parametrize("create", [False, True])
def test_folder_is_no_registry(tmp_path, create):
    """Catches: an OperationalError where the path is a folder."""
    with pytest.raises(RegistryError, match="unable to open"):
        open_registry(url_of(tmp_path), create=create)


def test_folder_that_cannot_be_made(path):
    """Catches: an OSError where the parent is a file."""
    path.write_text("in the way", encoding="utf-8")
    with pytest.raises(RegistryError, match="cannot be made"):
        open_registry(url_of(path / "people.sqlite3"), create=True)


@pytest.mark.parametrize("create", [False, True])
def test_database_of_another_program_is_left_alone(path, create):
    """Catches: our tables in somebody's photo library."""
    with sqlite3.connect(path) as raw:
        raw.execute("CREATE TABLE photos (taken TEXT)")
    with pytest.raises(RegistryError, match="not one of moireid's"):
        open_registry(url_of(path), create=create)
    with sqlite3.connect(path) as raw:
        assert raw.execute("SELECT name FROM sqlite_master").fetchall() == [("photos",)]


def test_empty_file_is_no_registry_until_it_is_made_one(path):
    """Catches: a registry half made, by a process that was killed, that can neither be read nor finished."""
    path.touch()
    with pytest.raises(RegistryError, match="registry init"):
        open_registry(url_of(path), create=False)
    with open_registry(url_of(path), create=True) as registry:
        assert registry.count() == 0


@pytest.mark.parametrize(("change", "found"), [("UPDATE schema_version SET version = 2", "2"),
                                               ("DELETE FROM schema_version", "none")])  # fmt: skip
@pytest.mark.parametrize("create", [False, True])
def test_other_schema_version_is_refused(path, change, found, create):
    """Catches: reading tables of a later version by the rules of this one."""
    open_registry(url_of(path), create=True).close()
    with sqlite3.connect(path) as raw:
        raw.execute(change)
    with pytest.raises(RegistryError, match=f"schema version {found}, and this moireid reads version 1"):
        open_registry(url_of(path), create=create)


def test_schema_version_is_written_once(path):
    """Catches: a version row for each opening."""
    for _ in range(2):
        open_registry(url_of(path), create=True).close()
    with sqlite3.connect(path) as raw:
        assert raw.execute("SELECT version FROM schema_version").fetchall() == [(1,)]


# Faults of the database.


def test_locked_database_is_one_sentence(path):
    """Catches: OperationalError reaching the user on opening or on enrolling."""
    open_registry(url_of(path), create=True).close()
    url = url_of(path, timeout=0.05)
    holder = sqlite3.connect(path, isolation_level=None)
    try:
        with open_registry(url, create=False) as registry:
            holder.execute("BEGIN EXCLUSIVE")
            with pytest.raises(RegistryError, match=r"locked.*another program holds it"):
                registry.enroll(badge_of("Ada"))
            with pytest.raises(RegistryError, match=r"locked.*another program holds it"):
                open_registry(url, create=False)
    finally:
        holder.close()


def test_enroll_waits_for_another_writer(path):
    """Catches: giving up at once, or Python's 5 s overruled by 0, where another process is merely writing."""
    holder_done = threading.Event()
    with open_registry(url_of(path), create=True) as registry:
        holder = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
        holder.execute("BEGIN IMMEDIATE")

        def let_go() -> None:
            holder_done.set()
            holder.execute("COMMIT")

        timer = threading.Timer(0.3, let_go)
        timer.start()
        registry.enroll(badge_of("Ada"))
        assert holder_done.is_set()
        timer.join()
        holder.close()


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("badge_json", "{"),
        ("badge_json", "{}"),
        ("name_nfc", "Eve"),
        ("id", "abcdef"),
    ],
)
def test_damaged_record_is_told(path, registry, column, value):
    """Catches: a row edited by hand that would let Eve pass with Ada's badge; a SpecError about a file nobody gave."""
    badge_id = registry.enroll(badge_of("Ada")).id
    with sqlite3.connect(path) as raw:
        raw.execute(f"UPDATE badges SET {column} = ?", (value,))
    with pytest.raises(RegistryError, match="damaged"):
        registry.find(value if column == "name_nfc" else "Ada")
    with pytest.raises(RegistryError, match="damaged"):
        registry.by_id(value if column == "id" else badge_id)


# Several at once.


def test_registries_made_at_once(tmp_path):
    """Catches: a transaction that looks first and takes the write lock later, which SQLite refuses without any wait."""
    for attempt in range(10):
        url = url_of(tmp_path / f"{attempt}.sqlite3")
        with ThreadPoolExecutor(8) as pool:
            for registry in pool.map(lambda _, url=url: open_registry(url, create=True), range(8)):
                registry.close()
        with open_registry(url, create=False) as registry:
            assert registry.count() == 0


def _enroll_many(url: str, badges: list[str], ready, results) -> None:
    """What each of the processes does: open, and enroll all, telling how each went."""
    ready.wait()
    outcomes = []
    with open_registry(url, create=True) as registry:
        for text in badges:
            try:
                outcomes.append(registry.enroll(badge_from_json(text)).name)
            except RegistryError as error:
                outcomes.append(f"RegistryError: {error}")
    results.put(outcomes)


def _run_together(url: str, lists: list[list[str]]) -> list[list[str]]:
    context = multiprocessing.get_context("spawn")
    ready, results = context.Barrier(len(lists)), context.Queue()
    processes = [context.Process(target=_enroll_many, args=(url, badges, ready, results)) for badges in lists]
    for process in processes:
        process.start()
    outcomes = [results.get(timeout=120) for _ in processes]
    for process in processes:
        process.join(timeout=30)
        assert process.exitcode == 0
    return outcomes


def _renamed(badge: Badge, name: str, number: int) -> str:
    """The JSON of `badge` with another name and id: the registry reads no code, and designing takes longer."""
    return replace(badge, name=name, id=number.to_bytes(3, "big").hex()).to_json()


def test_two_processes_lose_nothing(path):
    """Catches: 'database is locked', tables made twice, a row lost to a read-modify-write."""
    badge = badge_of("Ada")
    lists = [[_renamed(badge, f"{who} {k:02}", 1000 * p + k) for k in range(50)] for p, who in enumerate(("Al", "Bo"))]
    outcomes = _run_together(url_of(path), lists)
    expected = [f"{who} {k:02}" for who in ("Al", "Bo") for k in range(50)]
    assert sorted(name for outcome in outcomes for name in outcome) == expected
    with open_registry(url_of(path), create=False) as registry:
        assert [record.name for record in registry.records()] == expected


def test_two_processes_that_want_the_same_ids(path):
    """Catches: looking before writing, by which both would be told that the id is theirs."""
    badge = badge_of("Ada")
    lists = [[_renamed(badge, who, k) for k in range(30)] for who in ("Al", "Bo")]
    outcomes = _run_together(url_of(path), lists)
    with open_registry(url_of(path), create=False) as registry:
        holders = {int(record.id, 16): record.name for record in registry.records()}
    assert sorted(holders) == list(range(30))
    for outcome in outcomes:
        (who,) = {told for told in outcome if told in ("Al", "Bo")} or {""}
        for k, told in enumerate(outcome):
            assert (told == who) == (holders[k] == who)
            assert told == who or f"already to {holders[k]!r}" in told
