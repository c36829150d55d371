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

from kit.signing import certified_key, pem_of
from moireid.attest import credentials
from moireid.attest.credentials import (
    talk_with,
    write_credentials,
)
from moireid.attest.credentials_work import LABEL, read
from moireid.attest.signing_keys import SigningKey, load_signing_key
from moireid.attest.statement import attested
from moireid.errors import MediaError


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
