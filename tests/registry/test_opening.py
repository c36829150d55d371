"""Opening a registry, and a database that fails.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import os
import re
import sqlite3
import stat
import sys
import threading
from traceback import format_exception

import pytest
from click.testing import CliRunner

from kit.registries import badge_of, tamper, url_of
from moireid.cli.main import moireid
from moireid.errors import MissingExtraError, RegistryError
from moireid.registry import default_url, open_registry


def test_default_url_is_in_the_users_data_folder(tmp_path, monkeypatch):
    """Catches: a default in the working folder; a path whose odd letters do not survive the URL."""
    home = tmp_path / "dät a"
    monkeypatch.setattr("moireid.registry.engine.data_folder", lambda: home / "moireid")
    assert default_url().startswith("sqlite:///")
    with pytest.raises(RegistryError, match="there is no registry"):
        open_registry(None, create=False)
    assert not home.exists()
    open_registry(None, create=True).close()
    assert (home / "moireid" / "registry.sqlite3").is_file()


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("postgresql:people", "no database URL; give one such as sqlite:///people.sqlite3, or a path"),
        ("ada:secret@host/people", "the registry's URL is no database URL"),
        ("postgresql://ada:secret/people", "the registry's URL is no database URL"),
        ("sqlite:///\udcff", "no database URL"),
        ("sqlite://people.sqlite3", "three slashes"),
        ("sqlite://", "names no file"),
        ("sqlite:///:memory:", "names no file"),
        ("nosuch://host/people", "nosuch"),
        ("sqlite:///people.sqlite3?tiemout=3", "options"),
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


@pytest.mark.parametrize(
    "address",
    [
        *("u:s3@cret/w#rd%@host/db", "u:s3/cret@host/db", "u:s3#cret@host/db", "u:s3?cret@host/db"),
        *("u:s3cret%@host/db", "u/x:s3cret@host/db", "host:5432/db?x=s3@cret"),
    ],
)
@pytest.mark.parametrize("variable", ["", "MOIREID_REGISTRY"])
def test_a_password_that_is_not_encoded_is_refused_before_anything_is_looked_up(address, variable, monkeypatch):
    """Catches: a part of a password that is taken for a host, looked up and printed."""
    url = f"postgresql+psycopg://{address}"
    monkeypatch.setattr("moireid.registry.engine.create_engine", lambda *_, **__: pytest.fail("looked up"))
    if variable:
        monkeypatch.setenv(variable, url)
    for words in (["registry", "list"], ["registry", "list", "--json"]):
        given = [] if variable else ["--registry", url]
        for traceback in ("", "1"):
            monkeypatch.setenv("MOIREID_TRACEBACK", traceback)
            done = CliRunner().invoke(moireid, [*words, *given])
            said = done.output + "".join(map(str, format_exception(done.exception)))
            assert "percent-encode the password" in said and not re.search("s3|cret|w#rd|/db", said), said


def test_a_file_whose_name_begins_as_a_url_keeps_its_name(tmp_path, monkeypatch):
    """Catches: another name of the scheme put into a path, so that another file is opened, or made."""
    monkeypatch.chdir(tmp_path)
    with open_registry("postgres+old.sqlite3", create=True):
        assert (tmp_path / "postgres+old.sqlite3").exists()


def test_a_folder_whose_name_is_no_text_is_named(tmp_path, monkeypatch):
    """Catches: a UnicodeEncodeError out of a relative path, where the folder around it has such a name."""
    folder = tmp_path / os.fsdecode(b"q\xff")
    folder.mkdir()
    monkeypatch.chdir(folder)
    with pytest.raises(RegistryError, match="is not Unicode text; give a path that is"):
        open_registry("people.sqlite3", create=True)


@pytest.mark.parametrize("url", ["postgresql+psycopg://ada:s3cret@h/p?sslpassword=s3cret", "pg://ada:s3cret@h:port/p"])
def test_password_is_not_shown(url, monkeypatch):
    """Catches: a password in an error message, from where it reaches logs."""
    monkeypatch.setitem(sys.modules, "psycopg", None)
    with pytest.raises((RegistryError, MissingExtraError)) as caught:
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


@pytest.mark.parametrize(
    ("change", "found"),
    [("UPDATE schema_version SET version = 9", "9"), ("DELETE FROM schema_version", "none")],
)
@pytest.mark.parametrize("create", [False, True])
def test_other_schema_version_is_refused(url, change, found, create):
    """Catches: reading tables of another version by the rules of this one; no word of what to do."""
    open_registry(url, create=True).close()
    tamper(url, change)
    with pytest.raises(RegistryError, match=f"schema version {found}, and this moireid reads version 8; .*a newer one"):
        open_registry(url, create=create)


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


def test_a_new_registry_and_its_export_are_their_owners_alone(path, tmp_path):
    """Catches: badges that anybody with an account on the machine can print; a journal that shows them."""
    was = os.umask(0o022)
    try:
        with open_registry(url_of(path), create=True) as registry:
            registry.enroll(badge_of("Ada"))
            registry.export(tmp_path / "out.sqlite3")
    finally:
        os.umask(was)
    assert [stat.S_IMODE(one.stat().st_mode) for one in (path, tmp_path / "out.sqlite3")] == [0o600, 0o600]


def test_folder_that_cannot_be_made(path):
    """Catches: an OSError where the parent is a file."""
    path.write_text("in the way", encoding="utf-8")
    with pytest.raises(RegistryError, match="cannot be made"):
        open_registry(url_of(path / "people.sqlite3"), create=True)
