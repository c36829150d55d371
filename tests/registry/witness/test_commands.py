"""Registries whose checkpoints witnesses sign, and readers who ask for them.

Each test names the wrong implementation, or the attack by those who run the registry, that it catches.
"""

from __future__ import annotations

import json
import shutil
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest

from kit.registries import badge_of, run, url_of
from kit.witnesses import serving
from moireid.cli.verify.verify_cmd import asked_of
from moireid.cli.verify.verify_options import ClaimWish
from moireid.cli.witness_options import WitnessCheck
from moireid.errors import RegistryError
from moireid.registry import holder_of, open_registry
from moireid.registry.bundle import publish
from moireid.registry.checkpoints.cosignature import Quorum
from moireid.registry.checkpoints.note import VerifierKey
from moireid.registry.checkpoints.sources import checkpoints_from
from moireid.registry.seen import Memory
from moireid.registry.witness import client
from moireid.registry.witness.state import Witness

DOWN = "http://127.0.0.1:9"


class Witnesses:
    """Three witnesses of a registry: their addresses and keys."""

    def __init__(self, addresses: list[str], keys: list[str]) -> None:
        self.addresses, self.keys = addresses, keys

    def quorum(self, needed: int = 2, days: float = 7.0) -> Quorum:
        return Quorum.of(self.keys, needed, days)

    def options(self, needed: int = 2, ask: tuple[str, ...] | None = None) -> list[str]:
        words = [word for key in self.keys for word in ("--witness-key", key)]
        asked = self.addresses if ask is None else ask
        return [*words, "--witnesses", str(needed), *(word for one in asked for word in ("--witness", one))]


@pytest.fixture
def grown(path: Path) -> Path:
    """A registry with two people, three entries."""
    with open_registry(url_of(path), create=True) as registry:
        for name in ("Ada", "Bo"):
            registry.enroll(badge_of(name))
    return path


@pytest.fixture
def witnesses(grown: Path, tmp_path: Path) -> Iterator[Witnesses]:
    shown = json.loads(run("registry", "init", "--registry", url_of(grown), "--json").stdout)
    log = VerifierKey.parse(shown["log_key"])
    made = [Witness(tmp_path / f"w{number}.sqlite3", f"witness.example/w{number}", [log]) for number in (1, 2, 3)]
    with ExitStack() as stack:
        yield Witnesses([stack.enter_context(serving(one)) for one in made], [str(one.public) for one in made])


def noted(path: Path, out: Path, *options: str, code: int = 0) -> Path:
    run("registry", "checkpoint", "--out", out, "--registry", url_of(path), *options, code=code)
    return out


def code_with(path: Path, checkpoint: Path, quorum: Quorum) -> str | None:
    """The code by which a reader who asks for witnesses is refused; None if they are not."""
    with open_registry(url_of(path), create=False) as registry:
        try:
            registry.require_witnesses(checkpoints_from(str(checkpoint))[0], quorum)
        except RegistryError as error:
            assert "\n" not in str(error) and ";" in str(error)
            return str(error.details["code"])
    return None


@pytest.fixture
def stranger(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A reader who has seen nothing of any registry."""
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "stranger"))
    return tmp_path / "stranger"


def test_two_of_three_sign_and_the_third_is_named(grown, witnesses, tmp_path):
    """Catches: one witness that is away stops all; a failure that is not said; a note that only our program reads."""
    options = witnesses.options(ask=(*witnesses.addresses[:2], DOWN))
    out = tmp_path / "one.checkpoint"
    done = run("registry", "checkpoint", "--out", out, "--registry", url_of(grown), *options, "--json")
    found = json.loads(done.stdout)
    assert found["witnesses"] == ["witness.example/w1", "witness.example/w2"]
    assert list(found["witnesses_failed"]) == [DOWN] and DOWN in done.stderr
    assert out.read_text().count("\n— ") == 3
    words = [word for key in witnesses.keys for word in ("--witness-key", key)]
    audit = ("registry", "audit", "--since", out, "--registry", url_of(grown), *words)
    seen = json.loads(run(*audit, "--witnesses", "2", "--json").stdout)["witnessed"]
    assert seen["size"] == 3 and set(seen["signers"]) == {"witness.example/w1", "witness.example/w2"}
    assert "witnesses have seen 3 of 3 entries" in run(*audit, "--witnesses", "2").stdout
    assert "not_witnessed" in run(*audit, "--json", code=1).stdout
    assert code_with(grown, out, witnesses.quorum()) is None
    assert code_with(grown, out, witnesses.quorum(3)) == "not_witnessed"


def test_the_log_goes_on_with_proofs_from_what_each_witness_knows(grown, witnesses, tmp_path):
    """Catches: one proof for all witnesses, though one of them was away and knows an older size."""
    noted(grown, tmp_path / "1", *witnesses.options(ask=tuple(witnesses.addresses[:2])))
    with open_registry(url_of(grown), create=False) as registry:
        registry.revoke("Bo", "lost")
    noted(grown, tmp_path / "2", *witnesses.options(3))
    assert code_with(grown, tmp_path / "2", witnesses.quorum(3)) is None
    assert code_with(grown, tmp_path / "1", witnesses.quorum(2)) is None


def test_too_few_signatures_write_nothing(grown, witnesses, tmp_path):
    """Catches: a checkpoint file that looks signed and is not; an older file that is lost."""
    out = tmp_path / "one"
    done = run(
        *("registry", "checkpoint", "--out", out, "--registry", url_of(grown)),
        *witnesses.options(2, ask=(witnesses.addresses[0], DOWN)),
        code=2,
    )
    assert not out.exists() and DOWN in done.stderr and done.stderr.count("\n") == 1


def test_a_split_view_is_signed_once(grown, witnesses, tmp_path, stranger):
    """Attack: two readers are shown two logs, each signed by the registry's own key."""
    shutil.copy(grown, other := tmp_path / "other.sqlite3")
    with open_registry(url_of(grown), create=False) as registry:
        registry.revoke("Bo", "lost")
    noted(grown, tmp_path / "true", *witnesses.options(3))
    stranger.unlink()
    with open_registry(url_of(other), create=False) as registry:
        registry.enroll(badge_of("Cy"))
    options = witnesses.options(3)
    refused = run("registry", "checkpoint", "--out", tmp_path / "x", "--registry", url_of(other), *options, code=2)
    assert "the registry was forked" in refused.stderr
    own = noted(other, tmp_path / "own")
    assert code_with(other, own, witnesses.quorum()) == "not_witnessed"
    assert code_with(other, tmp_path / "true", witnesses.quorum()) == "forked"
    # A fork that is longer than what the witnesses know: their status 422.
    with open_registry(url_of(other), create=False) as registry:
        registry.enroll(badge_of("Di"))
    refused = run("registry", "checkpoint", "--out", tmp_path / "x", "--registry", url_of(other), *options, code=2)
    assert "422" in refused.stderr


def test_a_rollback_passes_no_longer_than_signatures_count(grown, witnesses, tmp_path, stranger, monkeypatch):
    """Attack: the state of before a revocation is put back, with the checkpoint of that day."""
    noted(grown, tmp_path / "early", *witnesses.options(3))
    shutil.copy(grown, early := tmp_path / "early.sqlite3")
    with open_registry(url_of(grown), create=False) as registry:
        registry.revoke("Bo", "lost")
    noted(grown, tmp_path / "late", *witnesses.options(3))
    stranger.unlink()
    assert code_with(early, tmp_path / "late", witnesses.quorum()) == "rolled_back"
    options = witnesses.options(3)
    refused = run("registry", "checkpoint", "--out", tmp_path / "x", "--registry", url_of(early), *options, code=2)
    assert "rolled back" in refused.stderr
    # This is what is left to the attacker: a few days.
    assert code_with(early, tmp_path / "early", witnesses.quorum(3)) is None
    now = time.time()
    monkeypatch.setattr("moireid.registry.checkpoints.cosignature.time.time", lambda: now + 8 * 86400)
    assert code_with(early, tmp_path / "early", witnesses.quorum(3)) == "not_witnessed"


def test_what_no_witness_has_seen_is_not_relied_on(grown, witnesses, tmp_path):
    """Attack: a badge is entered for one reader alone, after the checkpoint; catches: a lost revocation."""
    out = noted(grown, tmp_path / "one", *witnesses.options(3))
    check = WitnessCheck(str(out), witnesses.quorum(3))
    with open_registry(url_of(grown), create=False) as registry:
        registry.enroll(badge_of("Cy"))
        registry.revoke("Bo", "lost")
        cy = registry.find("Cy").id

    def claim(name: str) -> ClaimWish:
        return ClaimWish(name, url_of(grown), None, None, None, witness_check=check)

    with asked_of(claim("Ada")) as asked:
        assert asked.found.barred is None
        with pytest.raises(RegistryError) as unseen:
            asked.look_up({"identity": {"verdict": "mismatch", "decoded_id": cy}, "badge": {"id": "0" * 16}})
    assert unseen.value.details["code"] == "not_witnessed"
    with pytest.raises(RegistryError, match="witnesses have seen 3"), asked_of(claim("Cy")):
        pass
    with asked_of(claim("Bo")) as asked:
        assert asked.found.barred is not None and asked.found.barred.code == "revoked"
    with open_registry(url_of(grown), create=False) as registry:
        assert holder_of(registry, cy) is not None


def test_a_registry_that_is_exchanged_after_the_check_is_found(grown, witnesses, tmp_path, stranger, monkeypatch):
    """Attack: the file is exchanged for a fork between the check and the look-up, by a reader who remembers nothing."""
    shutil.copy(grown, fork := tmp_path / "fork.sqlite3")
    for path, names in ((grown, ["Cy"]), (fork, ["Cy", "Di"])):
        with open_registry(url_of(path), create=False) as registry:
            for name in names:
                registry.enroll(badge_of(name))
        stranger.unlink()
    out = noted(grown, tmp_path / "one", *witnesses.options(3))
    monkeypatch.setattr("moireid.registry.ledger.recall", lambda place: Memory())
    with open_registry(url_of(grown), create=False) as registry:
        registry.require_witnesses(checkpoints_from(str(out))[0], witnesses.quorum(3))
        shutil.copy(fork, grown)
        with pytest.raises(RegistryError) as refused:
            registry.check_newest(registry.find("Ada"))
    assert refused.value.details["code"] == "forked"


def test_a_checkpoint_of_a_former_key_counts_and_a_stranger_s_does_not(grown, witnesses, tmp_path):
    """Catches: a change of key that ends all checkpoints; a checkpoint of another registry that proves something."""
    out = noted(grown, tmp_path / "one", *witnesses.options(3))
    run("registry", "rotate-key", "--registry", url_of(grown))
    assert code_with(grown, out, witnesses.quorum(3)) is None
    with open_registry(url_of(tmp_path / "b.sqlite3"), create=True) as registry:
        registry.enroll(badge_of("Ada"))
    assert code_with(tmp_path / "b.sqlite3", out, witnesses.quorum(3)) == "key_replaced"


class _Liar(BaseHTTPRequestHandler):
    text = b""

    def do_POST(self) -> None:
        self.send_response(200)
        self.end_headers()
        self.wfile.write(self.text)

    def log_message(self, *words: object) -> None:
        pass


@pytest.mark.parametrize(
    "text", [b"", b"\xff" * 100000, "— witness.example/w1 AAAA\n".encode(), "— a\n".encode() * 500]
)
def test_a_witness_that_lies_is_named_and_counts_not(grown, witnesses, tmp_path, monkeypatch, text):
    """Catches: signatures that are written down unchecked; an answer without an end; a traceback."""
    monkeypatch.setattr(_Liar, "text", text)
    with HTTPServer(("127.0.0.1", 0), _Liar) as server:
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        liar = f"http://127.0.0.1:{server.server_port}"
        options = witnesses.options(2, ask=(*witnesses.addresses[:2], liar))
        done = run("registry", "checkpoint", "--out", tmp_path / "x", "--registry", url_of(grown), *options)
        assert liar in done.stderr
        options = witnesses.options(2, ask=(witnesses.addresses[0], liar))
        run("registry", "checkpoint", "--out", tmp_path / "y", "--registry", url_of(grown), *options, code=2)
        server.shutdown()


def test_a_witness_that_never_answers_is_left_after_the_deadline(grown, witnesses, tmp_path, monkeypatch):
    """Catches: a wait for one witness without an end, byte by byte."""
    monkeypatch.setattr(client, "MOST_S", 1.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"http://127.0.0.1:{silent.getsockname()[1]}"
        options = witnesses.options(2, ask=(*witnesses.addresses[:2], address))
        began = time.monotonic()
        done = run("registry", "checkpoint", "--out", tmp_path / "x", "--registry", url_of(grown), *options)
        assert time.monotonic() - began < 8 and "no answer after 1.5 s" in done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--witness", DOWN], "--witness-key"),
        (["--witness-key", "KEY"], "--witness URL"),
        (["--witnesses", "2"], "--witness-key"),
        (["--witness", DOWN, "--witness-key", "KEY", "--witnesses", "2"], "more than half"),
        (["--witness", "file:///etc/passwd", "--witness-key", "KEY"], "no web address"),
        (["--witness", DOWN, "--witness-key", "nonsense"], "nonsense"),
    ],
)
def test_options_that_lack_something_say_what(grown, witnesses, tmp_path, words, said):
    """Catches: a witness that is asked and not checked; an address that opens a file."""
    words = [witnesses.keys[0] if word == "KEY" else word for word in words]
    done = run("registry", "checkpoint", "--out", tmp_path / "x", "--registry", url_of(grown), *words, code=2)
    assert said in done.stderr and not (tmp_path / "x").exists() and done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "command", [["verify", "x.mp4", "--claim", "Ada"], ["identify", "x.mp4"], ["attest", "check", "x"]]
)
def test_readers_refuse_half_a_request(command, witnesses, tmp_path):
    """Catches: a reader who believes that witnesses are asked for, while they are not."""
    key = ["--witness-key", witnesses.keys[0]]
    assert "--checkpoint" in run(*command, *key, code=2).stderr
    assert "--witness-key" in run(*command, "--checkpoint", "x", code=2).stderr
    assert "--bundle" in run(*command, *key, "--checkpoint", "x", "--bundle", "b", code=2).stderr


def _published(grown: Path, witnesses: Witnesses, out: Path, *options: str, code: int = 0) -> str:
    words = ("registry", "publish", "--out", out, "--registry", url_of(grown), "--json", "--overwrite")
    return str(run(*words, *options, code=code).stdout)


def bundle_code(bundle: Path, quorum: Quorum) -> str | None:
    """The code by which a claim in a bundle is refused to a reader who asks for witnesses; None if it is not."""
    wish = ClaimWish("Ada", None, None, bundle, None, witness_check=WitnessCheck(None, quorum))
    try:
        with asked_of(wish) as asked:
            assert asked.found.barred is None
    except RegistryError as error:
        assert "\n" not in str(error) and ";" in str(error)
        return str(error.details["code"])
    return None


def test_a_bundle_holds_what_witnesses_signed(grown, witnesses, tmp_path, monkeypatch):
    """Catches: cosignatures that are checked and not kept; a bundle whose witnesses count for ever, or for anyone."""
    out, options = tmp_path / "people.bundle", witnesses.options(ask=(*witnesses.addresses[:2], DOWN))
    found = json.loads(_published(grown, witnesses, out, *options))
    assert found["witnesses"] == ["witness.example/w1", "witness.example/w2"]
    assert list(found["witnesses_failed"]) == [DOWN]
    assert bundle_code(out, witnesses.quorum()) is None
    assert bundle_code(out, witnesses.quorum(3)) == "not_witnessed"
    now = time.time()
    monkeypatch.setattr("moireid.registry.checkpoints.cosignature.time.time", lambda: now + 8 * 86400)
    assert bundle_code(out, witnesses.quorum()) == "not_witnessed"


def test_a_bundle_without_witnesses_is_refused_to_those_who_ask(grown, witnesses, tmp_path):
    """Catches: an option that checks nothing where there is nothing; too few signatures that still publish."""
    out = tmp_path / "people.bundle"
    _published(grown, witnesses, out)
    assert bundle_code(out, witnesses.quorum()) == "not_witnessed"
    done = run("verify", "x.mp4", "--claim", "Ada", "--bundle", out, "--witness-key", witnesses.keys[0], code=2)
    assert "signed by 0 of the 1 witnesses" in done.stderr and done.stderr.count("\n") <= 2
    before = out.read_bytes()
    _published(grown, witnesses, out, *witnesses.options(2, ask=(witnesses.addresses[0], DOWN)), code=2)
    assert out.read_bytes() == before


def test_a_bundle_with_the_checkpoint_of_another_log_is_refused(grown, witnesses, tmp_path, stranger, monkeypatch):
    """Attack: the registry's own key signs a bundle over a log for one reader, with the witnesses' true checkpoint."""
    true = noted(grown, tmp_path / "true", *witnesses.options(3)).read_text()
    with open_registry(url_of(grown), create=False) as registry:
        registry.enroll(badge_of("Cy"))
    made = publish.made_content
    monkeypatch.setattr(publish, "made_content", lambda checkpoint, *rest: made(true, *rest))
    _published(grown, witnesses, tmp_path / "false.bundle")
    assert bundle_code(tmp_path / "false.bundle", witnesses.quorum(3)) == "forked"
