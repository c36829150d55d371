"""Time stamps by an authority that the test starts itself.  Each test names the fault that it catches."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from click.testing import CliRunner

from kit.programs import needs
from kit.signing import certificate, certified_key, new_key, pem_of_certificates, time_authority
from moireid.attest import check, load_signing_key
from moireid.attest.envelope import opened
from moireid.attest.signing_keys import SigningKey, load_certificates
from moireid.attest.timestamp import ask_for_stamp, read_stamp
from moireid.cli.main import moireid
from moireid.errors import SpecError

Sign = Callable[..., str]


@pytest.fixture(scope="module")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    """Its address, and its root certificate's file."""
    with time_authority(tmp_path_factory.mktemp("clock") / "tsa") as found:
        yield found


def test_a_stamp_is_believed_of_a_known_authority_alone(
    authority: tuple[str, Path], sign: Sign, film: Path, tmp_path: Path
) -> None:
    """Catches: a stamp of anybody's authority that counts, one of another signature, one that is never looked at."""
    url, root = authority
    certified_key(tmp_path / "key.pem", "p256")
    key = load_signing_key(tmp_path / "key.pem")
    text = sign(key, lambda signature: ask_for_stamp(url, signature))
    (tmp_path / "verdict.json").write_text(text)
    command = [
        "attest",
        "check",
        str(tmp_path / "verdict.json"),
        "--film",
        str(film),
        "--key",
        str(tmp_path / "key.pem"),
    ]
    done = CliRunner().invoke(moireid, [*command, "--authority", str(root)])
    assert done.exit_code == 0 and "by the time stamp of the given authority" in done.output, done.output
    printed = json.loads(CliRunner().invoke(moireid, [*command, "--authority", str(root), "--json"]).stdout)["time"]
    assert printed["source"] == "time stamp" and printed["at"] == printed["stamped_at"]
    stamped = datetime.fromisoformat(printed["stamped_at"])
    assert abs((datetime.now(UTC) - stamped).total_seconds()) < 60
    alone = CliRunner().invoke(moireid, command)
    assert alone.exit_code == 0 and "signer's own clock" in alone.output and "is not believed" in alone.output

    stranger = new_key("p256")
    other = certificate("Clocks", stranger, "Clocks", stranger, authority=True)
    (tmp_path / "other.pem").write_bytes(pem_of_certificates(other))
    assert _parts(text, load_certificates(tmp_path / "other.pem")) == ["timestamp"]

    unstamped = sign(key)
    assert _parts(unstamped, load_certificates(root)) == ["timestamp"]
    moved = json.loads(unstamped)
    moved["signatures"][0]["timestamp"] = json.loads(text)["signatures"][0]["timestamp"]
    assert _parts(json.dumps(moved)) == ["timestamp"] == _parts(json.dumps(moved), load_certificates(root))


def _parts(text: str, authorities: tuple = ()) -> list[str]:
    return [fault.part for fault in check(text.encode(), authorities=authorities).faults]


def test_the_stamp_is_read_by_openssl_too(authority: tuple[str, Path], sign: Sign, tmp_path: Path) -> None:
    """Catches: a stamp of something else than the signature's own bytes, which no one else could check."""
    url, root = authority
    found = opened(sign(SigningKey(new_key("ed25519")), lambda signature: ask_for_stamp(url, signature)).encode())
    (tmp_path / "sig").write_bytes(found.signature)
    (tmp_path / "r.tsr").write_bytes(found.timestamp or b"")
    command = [needs("openssl"), "ts", "-verify", "-data", "sig", "-in", "r.tsr", "-CAfile", str(root)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "Verification: OK" in done.stdout + done.stderr


def test_a_changed_stamp_never_counts(authority: tuple[str, Path]) -> None:
    """Catches: a time that can be moved after it was stamped, or a traceback of the library."""
    url, root = authority
    given, known = ask_for_stamp(url, b"signature"), load_certificates(root)
    true = read_stamp(given, b"signature", known)
    assert true is not None and true.trusted and read_stamp(given, b"another", known) is None
    for at in range(len(given)):
        changed = bytearray(given)
        changed[at] ^= 1
        found = read_stamp(bytes(changed), b"signature", known)
        assert found is None or found.at == true.at, at
    for length in range(0, len(given), 50):
        assert read_stamp(given[:length], b"signature", known) is None


@pytest.mark.parametrize(
    ("answer", "words"), [(b"", "no time stamp"), (b"<html>", "no time stamp"), (None, "of another request")]
)
def test_an_authority_that_does_not_stamp_is_reported(
    authority: tuple[str, Path], tmp_path: Path, answer: bytes | None, words: str
) -> None:
    """Catches: whatever a server says put into the envelope; a stamp that is played again."""
    url, root = authority
    if answer is None:
        answer = ask_for_stamp(url, b"signature")
    (root.parent / "bad").write_bytes(answer)
    with pytest.raises(SpecError, match=words):
        ask_for_stamp(f"{url}bad", b"signature")


@pytest.mark.parametrize("url", ["file:///etc/passwd", "http://127.0.0.1:1/", "http://[", "no address"])
def test_an_address_that_answers_nothing_is_reported(url: str) -> None:
    """Catches: a file of this machine sent for a stamp, a traceback of the network."""
    with pytest.raises(SpecError, match="time authority"):
        ask_for_stamp(url, b"signature")
