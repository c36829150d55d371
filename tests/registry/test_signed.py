"""Keys, signatures, revocation, measured figures.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import json
import os
import re
import shutil
from dataclasses import replace
from hashlib import sha256

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from cryptography.hazmat.primitives.serialization import load_pem_private_key

from kit.registries import badge_of, rows_of, state_of, stop_clock, tamper, url_of
from moireid.errors import RegistryError
from moireid.registry import open_registry
from moireid.registry.canonical import canonical_json, pack, sha256_hex, unpack
from moireid.registry.keys import ENTRY, RECORD, ROOT, new_key

# Keys.


def test_new_registry_makes_one_key(url, keys):
    """Catches: a key readable by others, a key for each opening, a name that is not the fingerprint, a question."""
    for _ in range(2):
        with open_registry(url, create=True) as registry:
            fingerprint, path = registry.fingerprint, registry.key_path
    assert [entry.name for entry in keys.iterdir()] == [f"{fingerprint}.pem"] == [path.name]
    assert os.stat(path).st_mode & 0o777 == 0o600 and os.stat(keys).st_mode & 0o777 == 0o700
    public = load_pem_private_key(path.read_bytes(), password=None).public_key().public_bytes_raw()
    assert sha256_hex(public).startswith(fingerprint) and len(fingerprint) == 32
    assert rows_of(url, "SELECT public_key FROM authority") == [{"public_key": public.hex()}]


def test_private_key_is_nowhere_but_in_its_file(path, url, registry, tmp_path):
    """Catches: the private key in the database or an export, in any of the ways to write it."""
    registry.enroll(badge_of("Ada"))
    key = load_pem_private_key(registry.key_path.read_bytes(), password=None)
    registry.export(tmp_path / "out.sqlite3")
    held = json.dumps(state_of(url), default=repr)
    raw = (tmp_path / "out.sqlite3").read_bytes() + (path.read_bytes() if path.exists() else b"")
    assert key.private_bytes_raw().hex() not in held.lower()
    assert key.private_bytes_raw() not in raw and b"PRIVATE" not in raw and "PRIVATE" not in held


def test_without_the_private_key_all_can_be_read_and_nothing_written(url, keys):
    """Catches: reading that wants the private key; writing unsigned; a message that does not say where to look."""
    with open_registry(url, create=True) as registry:
        ada = registry.enroll(badge_of("Ada"))
        name = registry.key_path.name
    shutil.rmtree(keys)
    with open_registry(url, create=True) as registry:
        assert registry.find("Ada") == registry.by_id(ada.id) == next(registry.records()) == ada
        assert registry.layouts() == [ada.badge] and registry.audit().sound
        assert registry.enroll(badge_of("Ada")) == ada
        before = state_of(url)
        for write in (
            lambda: registry.enroll(badge_of("Bo")),
            lambda: registry.enroll_many([badge_of("Bo")]),
            lambda: registry.revoke("Ada", "lost"),
            lambda: registry.store_as_built(ada.id, "{}"),
        ):
            with pytest.raises(RegistryError, match=rf"{re.escape(str(keys / name))}.*MOIREID_KEYS"):
                write()
        assert state_of(url) == before
    assert not keys.exists()


def test_key_file_that_is_none_or_another_is_refused(url, keys):
    """Catches: a traceback of cryptography; signing with whatever key lies there."""
    with open_registry(url, create=True) as registry:
        path = registry.key_path
    new_key()
    (other,) = set(keys.iterdir()) - {path}
    for content, message in ((b"none", "holds no plain PEM key"), (other.read_bytes(), "is another one")):
        path.write_bytes(content)
        with open_registry(url, create=False) as registry, pytest.raises(RegistryError, match=message):
            registry.enroll(badge_of("Ada"))


# What is signed.


def test_signature_can_be_checked_without_moireid(url, registry):
    """Catches: signing other bytes than the documented ones.  Convention: domain line, then canonical JSON."""
    badge = badge_of("Ada")
    registry.enroll(badge)
    (row,) = rows_of(url, "SELECT * FROM badges")
    document = json.dumps(json.loads(badge.to_json()), sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    absent = "as_built_at as_built_reason as_built_sha256 as_built_earlier_sha256 revoked_at"
    absent += " revoked_reason"
    fields = dict.fromkeys(absent.split()) | {
        "badge_json_sha256": sha256_hex(document.encode()),
        "id": badge.id,
        "issued_at": row["issued_at"],
        "layout_key": badge.layout_key(),
        "name": "Ada",
        "salt": row["salt"],
    }
    assert len(row["salt"]) == 32
    text = json.dumps(fields, separators=(",", ":"), sort_keys=True).encode()
    (top,) = rows_of(url, "SELECT * FROM authority")
    key = Ed25519PublicKey.from_public_bytes(bytes.fromhex(top["public_key"]))
    key.verify(bytes.fromhex(row["signature"]), b"moireid registry record 2\n" + text)
    entry = rows_of(url, "SELECT * FROM log ORDER BY seq")[-1]
    assert entry["record_sha256"] == sha256_hex(text) and (entry["action"], entry["seq"]) == ("enroll", 2)
    said = {key: entry[key] for key in ("action", "actor", "record_sha256", "seq", "subject", "time")}
    content = json.dumps(said, separators=(",", ":"), sort_keys=True).encode()
    assert entry["hash"] == sha256_hex(b"moireid registry log entry 3\n" + content)
    leaves = [sha256(b"\0" + bytes.fromhex(row["hash"])).digest() for row in rows_of(url, "SELECT hash FROM log")]
    root = sha256(b"\1" + leaves[0] + leaves[1])
    head = f"2:{root.hexdigest()}"
    assert registry.head() == head
    key.verify(bytes.fromhex(top["head_signature"]), b"moireid registry log head 2\n" + head.encode())


def test_signatures_of_one_kind_are_none_of_another():
    """Catches: signing without a domain, so that a log entry's signature could be shown for a record."""
    signer, _ = new_key()
    domains = (RECORD, ENTRY, ROOT)
    for domain in domains:
        signature = signer.sign(domain, b"x")
        assert [signer.authority.signed(other, b"x", signature) for other in domains] == [
            other == domain for other in domains
        ]
        assert not signer.authority.signed(domain, b"y", signature)
        for wrong in (signature.upper(), signature[:-2], "", "zz", None, 7, bytes.fromhex(signature)):
            assert not signer.authority.signed(domain, b"x", wrong)


def test_canonical_json_is_one_text():
    """Catches: a text that depends on the order of keys or on white space, or that does not survive reading."""
    one = {"b": [1, 1.0, 1e-7, -0.0, "é\u2028"], "a": {"y": None, "x": True}}
    other = json.loads(json.dumps({"a": {"x": True, "y": None}, "b": one["b"]}, indent=3))
    assert canonical_json(one) == canonical_json(other) == canonical_json(json.loads(canonical_json(one)))
    assert canonical_json(one) == '{"a":{"x":true,"y":null},"b":[1,1.0,1e-07,-0.0,"é\u2028"]}'
    with pytest.raises(ValueError, match="JSON compliant"):
        canonical_json([float("nan")])


@pytest.mark.parametrize("content", ["text", b"", b"no zlib", pack("x") + b"more", pack("x" * 99)[:-1], None, 7])
def test_what_was_not_packed_is_reported(content):
    """Catches: zlib.error and TypeError out of a damaged column; a tail that no one checks."""
    with pytest.raises(ValueError, match="document"):
        unpack(content)
    assert unpack(pack("é")) == "é"


def test_document_that_would_fill_the_memory_is_refused(monkeypatch):
    """Catches: a few kB in a column that unpack to gigabytes."""
    monkeypatch.setattr("moireid.registry.canonical.UNPACKED_LIMIT", 1000)
    assert len(unpack(pack("x" * 999))) == 999
    with pytest.raises(ValueError, match="longer than it may be"):
        unpack(pack("x" * 100_000))


# Tampering is reported on reading.

FORGED = pack(canonical_json(json.loads(badge_of("Ada", bytes(3)).to_json())))


@pytest.mark.claim("A changed record is found")
@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        "name_nfc = 'Eve'",
        "id = 'abcdef'",
        "layout_key = 'x'",
        "issued_at = '2001-01-01T00:00:00Z'",
        "badge = :forged",
        "badge = :nothing",
        "as_built = :forged",
        "revoked_at = '2001-01-01T00:00:00Z'",
        "revoked_reason = 'x'",
        "signature = ''",
    ],
)
def test_changed_record_is_reported(url, registry, change):
    """Catches: a column that is not signed: a row edited by hand that would let Eve pass with Ada's badge."""
    ada = registry.enroll(badge_of("Ada"))
    assert tamper(url, f"UPDATE badges SET {change}", forged=FORGED, nothing=b"{}") == 1
    claim = "Eve" if "Eve" in change else "Ada"
    badge_id = "abcdef" if "abcdef" in change else ada.id
    for read in (
        lambda: registry.find(claim),
        lambda: registry.by_id(badge_id),
        lambda: list(registry.records()),
        registry.layouts,
        lambda: registry.enroll(badge_of("Ada")) if badge_id == ada.id else registry.find(claim),
        lambda: registry.revoke(claim, "lost"),
    ):
        with pytest.raises(RegistryError, match=r"tampered with or is damaged: the record of id"):
            read()


def test_another_authoritys_record_is_reported(url, registry, tmp_path):
    """Catches: checking a signature against a key that came with the record."""
    registry.enroll(badge_of("Ada"))
    eve = url_of(tmp_path / "eve.sqlite3")
    with open_registry(eve, create=True) as forger:
        forger.enroll(badge_of("Eve"))
    (forged,) = rows_of(eve, "SELECT * FROM badges")
    names = ", ".join(forged)
    tamper(url, f"INSERT INTO badges ({names}) VALUES ({', '.join(':' + name for name in forged)})", **forged)
    with pytest.raises(RegistryError, match="signature does not fit"):
        registry.find("Eve")
    assert {finding.code for finding in registry.audit().findings} == {"record_signature"}


# Revocation.


@pytest.mark.claim("A revocation is for good")
def test_revocation_is_for_good(registry, monkeypatch):
    """Catches: a second revocation over the first; a revocation undone by enrolling the badge again."""
    ada = registry.enroll(badge_of("Ada"))
    registry.enroll(badge_of("Bo"))
    assert (ada.revoked_at, ada.revoked_reason) == (None, None)
    stop_clock(monkeypatch, "2030-01-02T03:04:05Z")
    revoked = registry.revoke(ada.id.upper(), " lost on the train ")
    assert revoked == replace(ada, revoked_at="2030-01-02T03:04:05Z", revoked_reason="lost on the train")
    assert registry.find("Ada") == registry.enroll(badge_of("Ada")) == revoked
    head = registry.head()
    with pytest.raises(RegistryError, match=r"revoked already on 2030-01-02T03:04:05Z \(lost on the train\)"):
        registry.revoke("Ada", "again")
    assert registry.head() == head and registry.find("Bo").revoked_at is None
    seen = registry.audit()
    assert seen.sound and (seen.records, seen.revoked, seen.entries) == (2, 1, 4)


# Measured figures.


@pytest.mark.parametrize("text", ["", "{", "[]", "7", '{"a": NaN}', '{"a": 1e999}', '{"a": "\\ud800"}', "[" * 100000])
def test_measured_figures_that_cannot_be_kept(registry, text):
    """Catches: NaN in signed JSON; a traceback of the parser."""
    ada = registry.enroll(badge_of("Ada"))
    with pytest.raises(RegistryError, match="measured figures"):
        registry.store_as_built(ada.id, text)
    with pytest.raises(RegistryError, match="no badge of id 'abcdef'"):
        registry.store_as_built("abcdef", "{}")
    assert registry.by_id(ada.id) == ada


def test_keys_folder_that_cannot_be_made(path, url, keys, monkeypatch, tmp_path):
    """Catches: an OSError; a registry whose key was never kept."""
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "file" / "keys"))
    with pytest.raises(RegistryError, match="MOIREID_KEYS"):
        open_registry(url, create=True)
    with pytest.raises(RegistryError, match="registry init"):
        open_registry(url, create=False)
