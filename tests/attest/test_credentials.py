"""The verdict as content credentials, read by c2pa's own reader.  Each test names the fault that it catches."""

from __future__ import annotations

import base64
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import c2pa
import pytest

from kit.coded_films import first_frames
from kit.places import FILMS
from kit.signing import certified_key, pem_of
from moireid.attest import credentials, film_credentials, load_signing_key
from moireid.attest.credentials import (
    talk_with,
    write_credentials,
)
from moireid.attest.credentials_work import LABEL, read
from moireid.attest.film_credentials import may_carry, with_carried
from moireid.attest.signing_keys import SigningKey
from moireid.attest.statement import attested
from moireid.badge import load_badge
from moireid.errors import MediaError
from moireid.verifier import Question, verify


@pytest.fixture
def here(film: Path, tmp_path: Path) -> Path:
    """The film in a folder of its own."""
    return Path(shutil.copy(film, tmp_path / "film.mp4"))


@pytest.fixture(params=["ed25519", "p256"])
def key(request: pytest.FixtureRequest, tmp_path: Path) -> SigningKey:
    certified_key(tmp_path / "key.pem", request.param)
    return load_signing_key(tmp_path / "key.pem")


def assertion_of(reader: c2pa.Reader) -> dict[str, Any]:
    """Ours, as c2pa's own reader gives it."""
    assert reader.get_validation_state() == "Valid"
    codes = {one["code"] for one in json.loads(reader.json())["validation_status"]}
    assert codes == {"signingCredential.untrusted"}
    (manifest,) = json.loads(reader.crjson())["manifests"]
    found: dict[str, Any] = manifest["assertions"][LABEL]
    return found


def test_a_sidecar_leaves_the_film_as_it_is(here: Path, judged: dict[str, Any], key: SigningKey) -> None:
    """Catches: a film that is written to, a sidecar of another film, numbers that the format turns into others."""
    before, state = here.read_bytes(), here.stat()
    report = attested(judged, key)
    words = write_credentials(report, here, "sidecar", key)
    assert "'Desk, House'" in words and "on no trust list" in words
    assert here.read_bytes() == before and here.stat().st_mtime_ns == state.st_mtime_ns
    assert sorted(os.listdir(here.parent)) == ["film.c2pa", "film.mp4", "key.pem"]
    sidecar = here.with_suffix(".c2pa").read_bytes()
    with here.open("rb") as stream:
        assert assertion_of(c2pa.Reader("video/mp4", stream, sidecar)) == report
    assert len(sidecar) < 40_000
    other = bytearray(before)
    other[len(other) // 2] ^= 1
    here.write_bytes(other)
    found = read(here, sidecar)
    assert found is not None and found["state"] == "Invalid"


@pytest.fixture(scope="module")
def open_report(film: Path) -> dict[str, Any]:
    """Of a film that is too short for a verdict."""
    badge = load_badge(FILMS / "badge.json")
    short = first_frames(film, film.with_name("short.mp4"), 12)
    found = verify(short, Question(badge))
    assert found.verdict != "accept"
    return found.to_json()


@pytest.mark.claim("Content credentials are a note and never a reason")
def test_carried_credentials_are_a_note_and_never_a_reason(
    here: Path, judged: dict[str, Any], key: SigningKey, open_report: dict[str, Any]
) -> None:
    """Catches: a verdict that rises, or falls, by what a file says of itself; damaged credentials reported as sound."""
    assert with_carried(open_report, here) is open_report
    write_credentials(attested(judged, key), here, "embed", key)
    made = here.with_name("film.c2pa.mp4")
    assert may_carry(made) and not may_carry(here)
    noted = with_carried(open_report, made)
    assert noted | {"reasons": noted["reasons"][:-1]} == open_report
    note = noted["reasons"][-1]
    assert (note["code"], note["level"], note["measured"]) == ("content_credentials", "note", "Valid")
    assert "'Desk'" in note["text"]
    content = bytearray(made.read_bytes())
    content[-100] ^= 1
    made.write_bytes(content)
    damaged = with_carried(open_report, made)["reasons"][-1]
    assert damaged["measured"] == "Invalid" and "do not hold" in damaged["text"] and damaged["level"] == "note"
    hurt = content.replace(b"jumb", b"jumc")
    made.write_bytes(hurt)
    assert with_carried(open_report, made)["verdict"] == open_report["verdict"]


def test_a_library_that_ends_its_process_leaves_a_note(
    here: Path, open_report: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: credentials read in the process that gives the verdict, which a fault of their reader ends."""
    monkeypatch.setattr(film_credentials, "may_carry", lambda film: True)

    def crashing(work: str, message: object, film: Path, answer: Callable[[dict[str, Any]], object]) -> object:
        return talk_with("kit.sandbox_work:act", ("crash",), film, answer)

    monkeypatch.setattr(credentials, "talk_with", crashing)
    (*before, note) = with_carried(open_report, here)["reasons"]
    assert before == open_report["reasons"] and note["measured"] == "Unreadable" and note["level"] == "note"


def box(kind: bytes, body: bytes = b"", *, wide: bool = False, size: int | None = None) -> bytes:
    """A box of the ISO base media format; wide: its size is written in 64 bits."""
    length = len(body) + (16 if wide else 8) if size is None else size
    head = (1).to_bytes(4) + kind + length.to_bytes(8) if wide else length.to_bytes(4) + kind
    return head + body


@pytest.mark.parametrize(
    ("content", "may"),
    [
        (box(b"ftyp", b"isom") + box(b"mdat", b"uuid" * 9) + box(b"moov", box(b"uuid")), False),
        (box(b"ftyp", b"isom") + box(b"mdat", b"x" * 9, wide=True) + box(b"uuid", b"y" * 16), True),
        (box(b"ftyp", b"isom") + box(b"mdat", b"x" * 90, size=0), False),
        (box(b"ftyp", b"isom") + box(b"moov", size=3) + box(b"free"), True),
        (b"RIFF\0\0\0\0AVI " + bytes(90), True),
        (b"", True),
    ],
    ids=["none", "behind a wide box", "a last box", "damaged", "another format", "empty"],
)
def test_credentials_are_looked_for_where_they_may_lie(tmp_path: Path, content: bytes, may: bool) -> None:
    """Catches: credentials that are passed over behind a large box, or in a format whose boxes are not read here."""
    (tmp_path / "film").write_bytes(content)
    assert may_carry(tmp_path / "film") == may


def test_without_the_extra_a_film_is_judged_all_the_same(
    here: Path, open_report: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a verify that fails where c2pa-python is not installed."""
    monkeypatch.setattr(film_credentials, "find_spec", lambda name: None)
    monkeypatch.setattr(film_credentials, "read", lambda film: {"state": "Valid", "signer": "", "verdict": None})
    assert with_carried(open_report, here) is open_report


def test_a_film_that_carries_credentials_keeps_them(here: Path, judged: dict[str, Any], key: SigningKey) -> None:
    """Catches: the camera's own credentials thrown away by ours."""
    report = attested(judged, key)
    write_credentials(report, here, "embed", key)
    made = here.with_name("film.c2pa.mp4")
    write_credentials(report, made, "embed", key)
    store = json.loads(c2pa.Reader(made.with_name("film.c2pa.c2pa.mp4")).json())
    assert len(store["manifests"]) == 2


def test_the_key_signs_nothing_but_credentials(
    here: Path, judged: dict[str, Any], key: SigningKey, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a process that reads strangers' films and gets a signature under a verdict of its own making."""

    def hostile(
        work: str, message: object, film: Path, answer: Callable[[dict[str, Any]], object], written: list[Path]
    ) -> None:
        assert pem_of(key.private) not in repr(message).encode()
        answer({"sign": base64.b64encode(b"DSSEv1 28 application/vnd.in-toto+json 2 {}").decode()})

    monkeypatch.setattr(credentials, "talk_with", hostile)
    with pytest.raises(MediaError, match="another signature"):
        write_credentials(attested(judged, key), here, "sidecar", key)
    assert sorted(os.listdir(here.parent)) == ["film.mp4", "key.pem"]


@pytest.mark.parametrize(
    ("work", "words"),
    [
        ("two_signatures", "another signature"),
        ("no_text", "another signature"),
        ("forged_file", "do not hold when they are read again"),
    ],
)
def test_one_signature_is_given_and_the_file_is_read_by_another_process(
    here: Path, judged: dict[str, Any], key: SigningKey, monkeypatch: pytest.MonkeyPatch, work: str, words: str
) -> None:
    """Catches: signatures for the asking, kept in a file that is sound by the word of the process that made it."""

    def taken_over(of: str, *given: Any, **more: Any) -> object:
        return talk_with(f"kit.hostile_work:{work}" if of.endswith(":write") else of, *given, **more)

    monkeypatch.setattr(credentials, "talk_with", taken_over)
    with pytest.raises(MediaError, match=words):
        write_credentials(attested(judged, key), here, "embed", key)
    assert sorted(os.listdir(here.parent)) == ["film.mp4", "key.pem"]
