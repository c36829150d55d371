"""Signed verdicts read by other programs, as their specifications say.  Each test names the fault that it catches."""

from __future__ import annotations

import base64
import hashlib
import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from securesystemslib.dsse import Envelope
from securesystemslib.signer import SSlibKey

from kit.programs import needs
from kit.signing import certificate, certified_key, new_key, pem_of, pem_of_certificates, public_pem_of
from moireid.attest.signing_keys import MOST_BYTES, SigningKey, fingerprint, holder, load_public_key, load_signing_key
from moireid.errors import SpecError

KINDS = ("ed25519", "p256")


def pae(envelope: dict[str, Any]) -> bytes:
    """What DSSE signs, written from its specification: DSSEv1, then length and bytes of type and body."""
    kind, body = envelope["payloadType"].encode(), base64.b64decode(envelope["payload"])
    return b"DSSEv1 " + b" ".join(part for one in (kind, body) for part in (str(len(one)).encode(), one))


@pytest.mark.claim("A signed verdict is verified by other programs")
@pytest.mark.parametrize("kind", KINDS)
def test_an_envelope_is_verified_by_others(kind: str, sign: Callable[..., str], tmp_path: Path) -> None:
    """Catches: a signature over the bare payload, in another form than DER, or over our own spelling of it; a name of
    the key that in-toto's own library does not give it.
    """
    key = new_key(kind)
    envelope = json.loads(sign(SigningKey(key)))
    signature = base64.b64decode(envelope["signatures"][0]["sig"])
    if isinstance(key, Ed25519PrivateKey):
        key.public_key().verify(signature, pae(envelope))
    else:
        key.public_key().verify(signature, pae(envelope), ec.ECDSA(hashes.SHA256()))
    files = {"pae": pae(envelope), "sig": signature, "pub.pem": public_pem_of(key)}
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    command = [needs("openssl"), "pkeyutl", "-verify", "-pubin", "-inkey", "pub.pem", "-rawin", "-in", "pae"]
    done = subprocess.run([*command, "-sigfile", "sig"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "Verified Successfully" in done.stdout, done.stderr
    theirs = SSlibKey.from_crypto(key.public_key())
    assert list(Envelope.from_dict(envelope).verify([theirs], 1)) == [theirs.keyid]


def test_the_statement_is_one_of_in_toto(sign: Callable[..., str], film: Path, judged: dict[str, Any]) -> None:
    """Catches: a predicate that is not the report as it is printed, a digest of something else than the film."""
    envelope = json.loads(sign(SigningKey(new_key("ed25519"))))
    assert envelope["payloadType"] == "application/vnd.in-toto+json"
    statement = json.loads(base64.b64decode(envelope["payload"]))
    assert statement["_type"] == "https://in-toto.io/Statement/v1" and statement["predicateType"].endswith(":2")
    digest = hashlib.sha256(film.read_bytes()).hexdigest()
    assert statement["subject"] == [{"name": "film.mp4", "digest": {"sha256": digest}}]
    own = statement["predicate"].pop("attested")
    assert set(own) == {"at", "signer"} and statement["predicate"].pop("registry")["head"].startswith("2:")
    assert statement["predicate"] == {name: value for name, value in judged.items() if name != "registry"}


def test_a_report_that_is_none_is_not_signed(sign: Callable[..., str]) -> None:
    """Catches: a signature under whatever a process says that a stranger's film was read by."""
    with pytest.raises(SpecError, match=r"cannot be signed: predicate\.verdict breaks the rule 'enum'"):
        sign(SigningKey(new_key("ed25519")), verdict="genuine")


@pytest.mark.parametrize("kind", KINDS)
def test_a_key_comes_with_its_chain(kind: str, tmp_path: Path) -> None:
    """Catches: certificates that are lost, a public key of another one."""
    key = certified_key(tmp_path / "key.pem", kind)
    found = load_signing_key(tmp_path / "key.pem")
    assert [holder(one) for one in found.chain] == ["Desk, House", "Root, House"]
    (tmp_path / "own.pem").write_bytes(pem_of_certificates(found.chain[0]))
    (tmp_path / "pub.pem").write_bytes(public_pem_of(key))
    for name in ("own.pem", "pub.pem"):
        assert fingerprint(load_public_key(tmp_path / name)) == fingerprint(found.public)
    der = key.public_key().public_bytes(serialization.Encoding.DER, serialization.PublicFormat.SubjectPublicKeyInfo)
    assert fingerprint(found.public) == hashlib.sha256(der).hexdigest()


def bad_keys() -> dict[str, tuple[bytes, str]]:
    """Files that are no key to sign with, and words of what is said."""
    key, other = new_key("p256"), new_key("p256")
    own = certificate("Desk", key, "Root", other)
    locked = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.BestAvailableEncryption(b"x")
    )
    p384 = pem_of(ec.generate_private_key(ec.SECP384R1()))
    return {
        "public": (public_pem_of(key), "no private key"),
        "two": (pem_of(key) + pem_of(other), "2 private keys"),
        "locked": (locked, "encrypted"),
        "p384": (p384, "neither Ed25519 nor ECDSA on P-256"),
        "another's certificate": (pem_of(other) + pem_of_certificates(own), "of another key"),
        "no certificate": (
            pem_of(key) + b"-----BEGIN CERTIFICATE-----\nMAA=\n-----END CERTIFICATE-----\n",
            "certificate",
        ),
        "huge": (pem_of(key) + b"\n" * MOST_BYTES, "larger than"),
    }


BAD_KEYS = bad_keys()


@pytest.mark.parametrize("name", BAD_KEYS)
def test_what_is_no_key_is_refused(name: str, tmp_path: Path) -> None:
    """Catches: a traceback of the library, a key of a kind that no one can check, a certificate of another."""
    content, words = BAD_KEYS[name]
    path = tmp_path / "key.pem"
    path.write_bytes(content)
    with pytest.raises(SpecError, match=words):
        load_signing_key(path)
    with pytest.raises(SpecError, match=r"missing\.pem cannot be read"):
        load_signing_key(tmp_path / "missing.pem")
