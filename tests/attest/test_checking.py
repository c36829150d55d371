"""Is a signed verdict what it was, of which film, and by whom?  Each test names the fault that it catches."""

from __future__ import annotations

import base64
import copy
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result
from securesystemslib.dsse import Envelope
from securesystemslib.signer import CryptoSigner

from kit.signing import certificate, certified_key, new_key, pem_of_certificates, public_pem_of
from moireid.attest.checking import check
from moireid.attest.envelope import signed_envelope
from moireid.attest.signing_keys import SigningKey, load_signing_key
from moireid.attest.statement import PREDICATE_TYPE, attested, statement
from moireid.cli.main import moireid

Sign = Callable[..., str]


def changed(text: str, change: Callable[[dict[str, Any]], None]) -> str:
    document = json.loads(text)
    change(document)
    return json.dumps(document)


def checked(path: Path, *options: str | Path) -> Result:
    """Run the command, which reports each fault in a sentence."""
    done = CliRunner().invoke(moireid, ["attest", "check", str(path), *map(str, options)])
    assert "Traceback" not in done.output and "inside moireid" not in done.output, done.output
    return done


@pytest.fixture
def key(tmp_path: Path) -> SigningKey:
    made = new_key("ed25519")
    (tmp_path / "pub.pem").write_bytes(public_pem_of(made))
    return SigningKey(made)


@pytest.fixture
def envelope(tmp_path: Path, key: SigningKey, sign: Sign) -> Path:
    path = tmp_path / "verdict.json"
    path.write_text(sign(key))
    return path


def test_it_says_who_judged_what_when_and_against_which_registry(envelope: Path, film: Path, tmp_path: Path) -> None:
    """Catches: a check that only says yes, a registry that is not named, a key that counts as known unasked."""
    done = checked(envelope, "--film", film, "--key", tmp_path / "pub.pem")
    assert done.exit_code == 0 and done.output.startswith("HOLDS: film.mp4 was judged ACCEPT"), done.output
    for words in ("the given film is that film", "it is the key that you gave", "signer's own clock", "moireid 0."):
        assert words in done.output
    assert "of authority " + "ab" * 16 in done.output
    printed = json.loads(checked(envelope, "--json", "--key", tmp_path / "pub.pem").stdout)
    assert printed["holds"] and printed["verdict"] == "accept" and printed["film"]["same"] is None
    assert printed["time"].startswith("20") and "by the signer's own clock" in done.output
    assert printed["signer"]["expected"] is True and printed["registry"]["head"].startswith("2:")


@pytest.mark.claim("A key that is only in the file proves nothing")
def test_a_key_that_is_only_in_the_file_proves_nothing_and_does_not_pass(
    tmp_path: Path, sign: Sign, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a green verdict signed by anybody in a newsroom's name, with a certificate that anybody made, and a day
    that anybody wrote.
    """
    certified_key(tmp_path / "key.pem", "p256", "Famous Newsroom")
    monkeypatch.setattr("moireid.attest.statement.utc", lambda moment: "2020-01-01T00:00:00Z")
    (tmp_path / "verdict.json").write_text(sign(SigningKey(load_signing_key(tmp_path / "key.pem").private)))
    for options in ((), ("--json",), ("--film", tmp_path / "key.pem")):
        done = checked(tmp_path / "verdict.json", *options)
        assert done.exit_code == 2 and done.stdout == "" and "nothing says whom to expect" in done.stderr


def test_a_verdict_of_another_format_is_refused(key: SigningKey, judged: dict[str, Any]) -> None:
    """Catches: a report of a form that this version does not know, checked by the rules of its own."""
    report = attested(copy.deepcopy(judged) | {"registry": None}, key)
    document = json.loads(statement(report, "film.mp4")) | {"predicateType": PREDICATE_TYPE[:-1] + "1"}
    (fault,) = check(signed_envelope(json.dumps(document).encode(), key).encode(), key=key.public).faults
    assert fault.part == "report" and "predicateType" in fault.text


def flipped(text: str, part: str, place: int) -> str:
    """One bit of one byte of a base64 text's content changed, so that it is still base64."""

    def change(document: dict[str, Any]) -> None:
        holder, name = (document, "payload") if part == "report" else (document["signatures"][0], "sig")
        content = bytearray(base64.b64decode(holder[name]))
        content[place] ^= 1
        holder[name] = base64.b64encode(content).decode()

    return changed(text, change)


@pytest.mark.parametrize("kind", ["ed25519", "p256"])
def test_one_changed_byte_is_reported(kind: str, sign: Sign, film: Path, tmp_path: Path) -> None:
    """Catches: a change that passes, and one of the film that is reported as one of the verdict."""
    text = sign(SigningKey(new_key(kind)))
    size = len(base64.b64decode(json.loads(text)["payload"]))
    for part, places in (("report", (0, size // 2, size - 1)), ("signature", (0, 9, 40, 63))):
        for place in places:
            faults = check(flipped(text, part, place).encode(), film=film).faults
            assert [fault.part for fault in faults] == ["signature"], (part, place)
    other = bytearray(film.read_bytes())
    other[len(other) // 2] ^= 1
    (tmp_path / "other.mp4").write_bytes(other)
    found = check(text.encode(), film=tmp_path / "other.mp4")
    assert [fault.part for fault in found.faults] == ["film"] and found.report is not None
    assert check(text.encode(), film=film).holds


def test_another_key_and_another_signer_s_certificate_are_reported(tmp_path: Path, sign: Sign, film: Path) -> None:
    """Catches: a certificate of the same key put next to the signature, which names another person."""
    key = certified_key(tmp_path / "key.pem", "p256")
    text = sign(load_signing_key(tmp_path / "key.pem"))
    thief = new_key("p256")
    swapped = certificate("Famous Newsroom", key, "Thief", thief)

    def swap(document: dict[str, Any]) -> None:
        document["signatures"][0]["certificates"] = [pem_of_certificates(swapped).decode()]

    def strip(document: dict[str, Any]) -> None:
        document["signatures"][0]["certificates"] = []

    for change in (swap, strip):
        assert [fault.part for fault in check(changed(text, change).encode()).faults] == ["certificate"]
    (tmp_path / "verdict.json").write_text(text)
    (tmp_path / "other.pem").write_bytes(public_pem_of(thief))
    done = checked(tmp_path / "verdict.json", "--film", film, "--key", tmp_path / "other.pem")
    assert (
        done.exit_code == 1 and "not by the given" in done.output and "it is not the key that you gave" in done.output
    )


def _again(document: dict[str, Any], payload: Any, key: SigningKey) -> None:
    """Another payload under a true signature of it, as a hostile signer can make it."""
    content = payload if isinstance(payload, bytes) else json.dumps(payload).encode()
    made = Envelope(content, document["payloadType"], {})
    made.sign(CryptoSigner(key.private))
    signed = made.to_dict()
    document["payload"] = signed["payload"]
    document["signatures"][0] |= signed["signatures"][0]


def _statement(document: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(base64.b64decode(document["payload"]))
    return found


def _put(document: dict[str, Any], value: Any, *place: str) -> dict[str, Any]:
    statement = inner = copy.deepcopy(_statement(document))
    for name in place[:-1]:
        inner = inner[name]
    inner[place[-1]] = value
    return statement


Hostile = Callable[[dict[str, Any], SigningKey], Any]
#: What is done to a sound envelope, and the part that must be named.  What is given back takes the document's place.
HOSTILE: dict[str, tuple[str, Hostile]] = {
    "payload type": ("envelope", lambda d, k: d.update(payloadType="application/json")),
    "payload not base64": ("envelope", lambda d, k: d.update(payload="é" + d["payload"])),
    "no payload": ("envelope", lambda d, k: d.pop("payload") and None),
    "no signature": ("envelope", lambda d, k: d.update(signatures=[])),
    "two signatures": ("envelope", lambda d, k: d.update(signatures=d["signatures"] * 2)),
    "signature a text": ("envelope", lambda d, k: d.update(signatures=["abc"])),
    "sig a list": ("envelope", lambda d, k: d["signatures"][0].update(sig=[1])),
    "sig long": ("signature", lambda d, k: d["signatures"][0].update(sig="A" * 400_000)),
    "key of another algorithm": (
        "signature",
        lambda d, k: d["signatures"][0].update(publicKey=public_pem_of(new_key("p256")).decode()),
    ),
    "key no PEM": ("envelope", lambda d, k: d["signatures"][0].update(publicKey="-----BEGIN PUBLIC KEY-----")),
    "key id": ("signature", lambda d, k: d["signatures"][0].update(keyid="0" * 64)),
    "certificates a text": ("envelope", lambda d, k: d["signatures"][0].update(certificates="x")),
    "many certificates": ("envelope", lambda d, k: d["signatures"][0].update(certificates=["x"] * 10_000)),
    "signed: no JSON": ("report", lambda d, k: _again(d, b"\x00\xff", k)),
    "signed: deep": ("report", lambda d, k: _again(d, b'{"a":' * 200_000, k)),
    "signed: another statement": ("report", lambda d, k: _again(d, _put(d, "https://x/v0.1", "_type"), k)),
    "signed: a later format": ("report", lambda d, k: _again(d, _put(d, 3, "predicate", "format"), k)),
    "signed: another subject": (
        "report",
        lambda d, k: _again(d, _put(d, [{"name": "x", "digest": {"sha256": "0" * 64}}], "subject"), k),
    ),
    "signed: another's key": (
        "report",
        lambda d, k: _again(d, _put(d, "0" * 64, "predicate", "attested", "signer", "key_sha256"), k),
    ),
    "signed: two verdicts": (
        "report",
        lambda d, k: _again(
            d, json.dumps(_statement(d)).replace('"verdict":', '"verdict": "reject", "verdict":', 1).encode(), k
        ),
    ),
    "signed: infinity": (
        "report",
        lambda d, k: _again(
            d, re.sub(r'"total_s": [0-9.]+', '"total_s": 1e999', json.dumps(_statement(d))).encode(), k
        ),
    ),
    "signed: respelled": (
        "report",
        lambda d, k: _again(d, json.dumps(_statement(d), indent=1).encode(), k),
    ),
    "signed: not a number": ("report", lambda d, k: _again(d, _put(d, float("nan"), "predicate", "timing"), k)),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_envelope_gives_a_sentence(name: str, envelope: Path, key: SigningKey, tmp_path: Path) -> None:
    """Catches: a traceback, an endless wait, or an envelope that readers understand differently."""
    part, spoil = HOSTILE[name]
    document = json.loads(envelope.read_text())
    spoil(document, key)
    (tmp_path / "hostile.json").write_text(json.dumps(document))
    done = checked(tmp_path / "hostile.json", "--key", tmp_path / "pub.pem", "--json")
    printed = json.loads(done.stdout)
    assert done.exit_code == 1 and not printed["holds"]
    assert "verdict" not in printed or name.startswith("digest")
    assert [fault["part"] for fault in printed["faults"]] == [part], printed
    done = checked(tmp_path / "hostile.json", "--key", tmp_path / "pub.pem")
    assert done.exit_code == 1 and done.output.startswith("DOES NOT HOLD") and len(done.output) < 900


def test_what_is_not_there_is_bad_input(tmp_path: Path, envelope: Path) -> None:
    """Catches: exit code 1, by which a script would take a wrong name for a forgery."""
    for options in ((tmp_path / "none",), (envelope, "--film", tmp_path / "none"), (envelope, "--key", envelope)):
        done = checked(*options)
        assert done.exit_code == 2 and done.stderr.startswith("error: ") and done.stdout == ""
