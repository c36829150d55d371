"""The key in a process of its own.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from kit.registries import badge_of
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import open_registry
from moireid.registry.bundle.bundle_file import ORIGIN
from moireid.registry.keys import ENTRY, NOTE, RECORD, ROOT, Signer
from moireid.registry.log import entry_text, rotation_of, rotation_row
from moireid.registry.signing import client
from moireid.registry.signing import signer_process as signing
from moireid.registry.signing.client import NOTE_ORIGINS, AskingSigner, make_key, of_kind

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows lacks such sockets")


@pytest.fixture
def signer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The socket of a signer with a keys folder of its own; this process has an empty one."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "far away"))
    with signing.own_signer() as path:
        monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "here"))
        monkeypatch.setenv("MOIREID_SIGNER", path)
        yield path


def test_a_registry_is_made_written_and_published_without_its_key(
    signer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a key that is made or read here; signatures by another key; a way of writing that has its own."""
    url = f"sqlite:///{tmp_path}/people.sqlite3"
    with open_registry(url, create=True) as registry:
        registry.enroll(badge_of("Ada Lovelace"))
        registry.enroll_many([badge_of("Grace Hopper")])
        registry.revoke("Grace Hopper", "lost")
        registry.checkpoint()
        registry.publish(tmp_path / "bundle", specimen_of, days=1)
        assert registry.audit().sound and not (tmp_path / "here").exists()
        (key,) = (tmp_path / "far away").iterdir()
        assert key.name == f"{registry.fingerprint}.pem"
    monkeypatch.delenv("MOIREID_SIGNER")
    with open_registry(url, create=False) as registry:
        assert registry.audit().sound
        with pytest.raises(RegistryError, match=r"can only be read here: the private key of authority .+ is not there"):
            registry.revoke("Ada Lovelace", "lost")


@pytest.mark.claim("A signer gives its key to no one and signs only what an authority signs")
def test_it_signs_what_an_authority_signs_and_nothing_else(signer: str, tmp_path: Path) -> None:
    """Catches: a process that signs whatever it is given, in any domain, or that gives its key away."""
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as registry:
        authority, text = registry._ledger.authority, registry.enroll(badge_of("Ada")).signed_text
    asking, finger = AskingSigner(signer, authority), authority.fingerprint
    assert authority.signed(RECORD, text, asking.sign(RECORD, text))
    for domain, content in (
        (RECORD, b"I owe you"),
        (RECORD, json.dumps({"id": "x"}).encode()),
        (RECORD, b"[" * 50_000),
        (NOTE, b"a text that others believe\n"),
        (NOTE, b"moireid/registry/" + b"0" * 32 + b"\n1\n"),
    ):
        with pytest.raises(RegistryError, match="refuses: it signs records, log entries, checkpoints and bundles"):
            asking.sign(domain, content)
    keys = signing.Keys()
    for message in (b"", b"[]", b"{}", b'{"do": "sign"}', b'{"do": "tell", "public": "00"}', b"\xff", b"[" * 100_000):
        assert set(keys.answer(message)) == {"refused"}
    assert of_kind("note", f"moireid/registry/{finger}\n1\n".encode(), finger) and not of_kind("", b"", finger)
    assert not of_kind("root", b"0:" + b"0" * 64, finger) and of_kind("root", b"7:" + b"0" * 64, finger)


def entry_of(**more: object) -> dict[str, object]:
    entry = {"seq": 2, "time": "2026-01-01T00:00:00Z", "action": "enroll", "subject": "00" * 8, "actor": "11" * 32}
    return entry | {"record_sha256": "22" * 32} | more


def test_a_log_entry_is_signed_by_its_words_alone(signer: str) -> None:
    """Catches: a bare hash that is signed, of which no one knows what it says; a second spelling; a hidden key."""
    asking, _ = make_key()
    assert isinstance(asking, AskingSigner)
    text = entry_text(entry_of())
    assert asking.authority.signed(ENTRY, hashlib.sha256(text).hexdigest().encode(), asking.sign_entry(text))
    said = json.loads(entry_text(entry_of()).partition(b"\n")[2])
    for content in (
        b"0" * 64,
        b"",
        entry_text(entry_of(subject="key:" + "00" * 32 + ":" + "11" * 32)),
        entry_text(entry_of(action="rotate")),
        entry_text(entry_of(seq="2")),
        entry_text(entry_of(actor=None)),
        b"moireid registry log entry 1\n" + entry_text(entry_of()).partition(b"\n")[2],
        b"moireid registry log entry 3\n" + json.dumps(said).encode(),
        b"moireid registry log entry 3\n" + b"[" * 50_000,
    ):
        with pytest.raises(RegistryError, match="this is none of them"):
            asking.sign_entry(content)
    with pytest.raises(KeyError):
        asking.sign(ENTRY, b"0" * 64)


def test_the_log_is_given_to_no_key_of_a_client(signer: str) -> None:
    """Catches: a studio taken over for a minute that gets a signature for a change to its own key, or to an old one."""
    (old, _), (other, _), (new, _) = make_key(), make_key(), make_key()
    thief = Signer(Ed25519PrivateKey.generate())
    actor = "00" * 32
    for asked in (old, other):
        asked.sign_entry(entry_text(entry_of()))
    # One of their own; one that the signer holds and that signed before, as a thief may have it; itself; by a third.
    for one, to in ((old, thief), (old, other), (other, other)):
        with pytest.raises(RegistryError, match="only to a new key that it made itself"):
            rotation_row(one, to, 1, actor)
    subject = f"key:{old.authority.public_hex}:{new.authority.public_hex}"
    with pytest.raises(RegistryError, match="only to a new key that it made itself"):
        other.sign_entry(entry_text(entry_of(action="rotate", subject=subject)))
    row = rotation_row(old, new, 1, actor)
    assert rotation_of(row).new.public_hex == new.authority.public_hex
    # It has a log now.
    with pytest.raises(RegistryError, match="only to a new key that it made itself"):
        rotation_row(other, new, 1, actor)


def test_a_signature_that_does_not_hold_is_not_taken(signer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a registry made unsound by a broken signer."""
    own = Signer(Ed25519PrivateKey.generate()).authority
    monkeypatch.setattr(client, "_answer", lambda path, message: {"signature": "00" * 64})
    with pytest.raises(RegistryError, match="a signature that does not hold"):
        AskingSigner(signer, own).sign(ROOT, b"1:" + b"0" * 64)


def test_no_key_and_no_signer_are_reported_in_a_sentence(signer: str, tmp_path: Path) -> None:
    """Catches: a traceback, a wait without end, or words that do not say what to do."""
    other = Signer(Ed25519PrivateKey.generate()).authority
    with pytest.raises(RegistryError, match=r"refuses: the private key of authority .+ is not there"):
        AskingSigner(signer, other)
    with pytest.raises(RegistryError, match=r"does not answer \(No such file.+start `moireid registry signer"):
        AskingSigner(str(tmp_path / "none"), other)


@pytest.mark.slow
def test_silent_clients_keep_no_one_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: idle connections that take every place, or every descriptor, for ever; a message that never ends."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setattr(signing, "IDLE_S", 1)
    with signing._Server(str(tmp_path / "socket"), 0o600) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        monkeypatch.setenv("MOIREID_SIGNER", str(tmp_path / "socket"))
        asking, _ = make_key()
        idle = [socket.socket(socket.AF_UNIX) for _ in range(signing.MOST_CLIENTS + 8)]
        for one in idle:
            one.connect(str(tmp_path / "socket"))
            with contextlib.suppress(OSError):
                one.sendall((1000).to_bytes(4, "big"))
        for one in idle:
            one.settimeout(10)
            with contextlib.suppress(ConnectionError):
                assert one.recv(1) == b""
        assert asking.sign(ROOT, b"1:" + b"0" * 64)
        for one in idle:
            one.close()
        server.shutdown()


def test_it_ends_with_its_starter_and_hides_its_memory(tmp_path: Path) -> None:
    """Catches: a process with a key that stays for ever; one whose memory its user's other programs read."""
    code = (
        "import os\nfrom moireid.registry.signing.signer_process import own_signer\n"
        "with own_signer() as path:\n    print(path, flush=True)\n    os.kill(os.getpid(), 9)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    path = done.stdout.strip()
    last = time.monotonic() + 20
    while any(path in " ".join(one.info["cmdline"] or ()) for one in psutil.process_iter(["cmdline"])):
        assert time.monotonic() < last
        time.sleep(0.05)
    with signing.own_signer() as path:
        (own,) = [one for one in psutil.Process().children() if path in one.cmdline()]
        if sys.platform == "linux":
            # A process that may not be dumped belongs to root, so that its own user cannot look in.
            assert "CoreDumping:\t0" in Path(f"/proc/{own.pid}/status").read_text()
            assert Path(f"/proc/{own.pid}/mem").stat().st_uid == 0
    assert not Path(path).exists()


@pytest.mark.slow
def test_the_command_keeps_its_socket_to_itself(tmp_path: Path) -> None:
    """Catches: a socket that everybody may ask; a second signer that takes the first one's place; a file lost."""
    path, program = tmp_path / "socket", "from moireid.cli.main import main; main()"
    command = [sys.executable, "-c", program, "registry", "signer", "--socket"]
    (tmp_path / "film.mp4").write_text("a film")
    with subprocess.Popen([*command, str(path)], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None and "signing for those who ask" in process.stderr.readline()
        assert path.stat().st_mode & 0o777 == 0o600
        second = subprocess.run([*command, str(path)], capture_output=True, text=True)
        assert second.returncode == 2 and "a signer listens at" in second.stderr
        process.kill()
    third = subprocess.run([*command, str(tmp_path / "film.mp4")], capture_output=True, text=True)
    assert third.returncode == 2 and "is no socket of a signer" in third.stderr
    assert (tmp_path / "film.mp4").read_text() == "a film"
    # What a killed one has left is taken away.
    with subprocess.Popen([*command, str(path)], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None and "signing for those who ask" in process.stderr.readline()
        process.kill()


def test_a_signer_signs_bundles_of_the_present_version_alone() -> None:
    """Catches: a bundle that no signer signs; a signature for a bundle which this version never writes."""
    assert {origin for origin in NOTE_ORIGINS if "bundle" in origin} == {ORIGIN}
