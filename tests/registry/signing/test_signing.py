"""The key in a process of its own.  Beside each test: the wrong implementation it catches."""

from __future__ import annotations

import json
import os
import subprocess
import sys
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
from moireid.registry.keys import ENTRY, NOTE, RECORD, Signer
from moireid.registry.signing import process as signing
from moireid.registry.signing.client import AskingSigner
from moireid.registry.signing.kinds import of_kind

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


def test_it_signs_what_an_authority_signs_and_nothing_else(signer: str, tmp_path: Path) -> None:
    """Catches: a process that signs whatever it is given, in any domain, or that tells its key."""
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as registry:
        authority, text = registry._ledger.authority, registry.enroll(badge_of("Ada")).signed_text
    asking, finger = AskingSigner(signer, authority), authority.fingerprint
    assert authority.signed(RECORD, text, asking.sign(RECORD, text))
    for domain, content in (
        (RECORD, b"I owe you"),
        (RECORD, json.dumps({"id": "x"}).encode()),
        (RECORD, b"[" * 50_000),
        (ENTRY, b"0" * 63),
        (NOTE, b"a text that others believe\n"),
        (NOTE, b"moireid/registry/" + b"0" * 32 + b"\n1\n"),
    ):
        with pytest.raises(RegistryError, match="refuses: it signs records, log entries, checkpoints and bundles"):
            asking.sign(domain, content)
    keys = signing.Keys()
    for message in (b"", b"[]", b"{}", b'{"do": "sign"}', b'{"do": "tell", "public": "00"}', b"\xff", b"[" * 100_000):
        assert set(keys.answer(message)) == {"refused"}
    assert of_kind("note", f"moireid/registry/{finger}\n1\n".encode(), finger) and not of_kind("", b"", finger)
    assert not of_kind("head", b"0:" + b"0" * 64, finger) and of_kind("head", b"7:" + b"0" * 64, finger)


def test_a_signature_that_does_not_hold_is_not_taken(signer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a registry made unsound by a broken signer."""
    own = Signer(Ed25519PrivateKey.generate()).authority
    monkeypatch.setattr(AskingSigner, "_told", lambda self, message: json.dumps({"signature": "00" * 64}).encode())
    with pytest.raises(RegistryError, match="a signature that does not hold"):
        AskingSigner(signer, own).sign(ENTRY, b"0" * 64)


def test_no_key_and_no_signer_are_told_in_a_sentence(signer: str, tmp_path: Path) -> None:
    """Catches: a traceback, a wait without end, or words that do not say what to do."""
    other = Signer(Ed25519PrivateKey.generate()).authority
    with pytest.raises(RegistryError, match=r"refuses: the private key of authority .+ is not there"):
        AskingSigner(signer, other)
    with pytest.raises(RegistryError, match=r"does not answer \(No such file.+start `moireid registry signer"):
        AskingSigner(str(tmp_path / "none"), other)


def test_it_ends_with_its_starter_and_shows_nobody_its_memory(tmp_path: Path) -> None:
    """Catches: a process with a key that stays for ever; one whose memory its user's other programs read."""
    code = (
        "import os\nfrom moireid.registry.signing.process import own_signer\n"
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
