"""What a registry proves of a signed verdict: whose badge it is, not who signed.  Each test names what it catches."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from kit.registries import url_of
from kit.signing import new_key, pem_of, public_pem_of
from moireid.attest.signing_keys import SigningKey, load_signing_key
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.designer import Order, design_badge
from moireid.idcodes import specimen_of
from moireid.registry import open_registry

Sign = Callable[..., str]


def checked(*options: object) -> Result:
    done = CliRunner().invoke(moireid, ["attest", "check", *map(str, options)])
    assert "inside moireid" not in done.output, done.output
    return done


class Desk:
    """A registry with one person, its bundle, and a key of a newsroom's own."""

    def __init__(self, folder: Path, sign: Sign) -> None:
        self.folder, self._sign = folder, sign
        self.badge: Badge = design_badge(Order("Ana", lens="50lpi"), bytes(range(8)))
        self.url = url_of(folder / "people.sqlite3")
        with open_registry(self.url, create=True) as registry:
            registry.enroll(self.badge)
            self.key_path = registry.key_path
            self.fingerprint, self.head = registry.fingerprint, registry.head()
            registry.publish(folder / "bundle", specimen_of, days=7)
        self.key = SigningKey(new_key("ed25519"))
        (folder / "pub.pem").write_bytes(public_pem_of(self.key.private))

    def signed(self, key: SigningKey, **changes: Any) -> Path:
        """A verdict about the person's badge, as this registry is asked, with some changes."""
        registry = {"fingerprint": self.fingerprint, "head": self.head, "expires": None}
        badge = {"id": self.badge.id, "name": self.badge.name}
        report = {"badge": badge, "registry": registry, "claim_source": "registry"} | changes
        path = self.folder / "verdict.json"
        path.write_text(self._sign(key, **report))
        return path


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sign: Sign) -> Desk:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    return Desk(tmp_path, sign)


def test_a_registry_alone_does_not_vouch_for_a_stranger_s_key(desk: Desk) -> None:
    """Catches: a forger's own key under "Ana is accepted", which holds as soon as the registry knows Ana."""
    forged = desk.signed(SigningKey(new_key("ed25519")))
    for place in (("--registry", desk.url), ("--bundle", desk.folder / "bundle")):
        done = checked(forged, *place)
        assert done.exit_code == 1 and "says who holds a badge, and not who signs" in done.stdout, done.output
        done = checked(forged, *place, "--key", desk.folder / "pub.pem")
        assert done.exit_code == 1 and "it is not the key that you gave" in done.output
        # The key of a desk that the user knows holds.
        done = checked(desk.signed(desk.key), *place, "--key", desk.folder / "pub.pem")
        assert done.exit_code == 0 and "it still counts" in done.output, done.output
        desk.signed(SigningKey(new_key("ed25519")))


def test_what_the_authority_itself_signed_holds_by_the_registry(desk: Desk) -> None:
    """Catches: a registry's operator who needs a second key for verdicts of their own."""
    signed = desk.signed(load_signing_key(desk.key_path))
    for place in (("--registry", desk.url), ("--bundle", desk.folder / "bundle")):
        done = checked(signed, *place)
        assert done.exit_code == 0 and "a key of the registry's authority" in done.output, done.output
    printed = json.loads(checked(signed, "--registry", desk.url, "--json").stdout)["signer"]
    assert (printed["expected"], printed["expected_by"]) == (True, ["registry"])


@pytest.mark.parametrize(
    ("changes", "part", "words"),
    [
        ({"badge": {"name": "Ana Bella"}}, "badge", "is 'Ana''s, and not 'Ana Bella''s"),
        ({"registry": None, "claim_source": "file"}, "registry", "what a file said"),
        ({"registry": {"fingerprint": "ab" * 16}}, "registry", "this is another registry"),
    ],
)
def test_name_line_and_authority_are_compared_with_the_record(
    desk: Desk, changes: dict[str, Any], part: str, words: str
) -> None:
    """Catches: a verdict whose id is one person's and whose name is another's; one by another registry."""
    plain = {
        "badge": {"id": desk.badge.id, "name": "Ana"},
        "registry": {"fingerprint": desk.fingerprint, "head": desk.head, "expires": None},
    }
    changes = {name: plain[name] | value if isinstance(value, dict) else value for name, value in changes.items()}
    signed = desk.signed(desk.key, **changes)
    for place in (("--registry", desk.url), ("--bundle", desk.folder / "bundle")):
        done = checked(signed, *place, "--key", desk.folder / "pub.pem", "--json")
        (fault,) = json.loads(done.stdout)["faults"]
        assert done.exit_code == 1 and fault["part"] == part and words in fault["text"], fault


def test_a_verdict_by_a_bundle_is_looked_up_by_the_identity_that_was_read(desk: Desk, judged: dict[str, Any]) -> None:
    """Catches: a verdict by a bundle, whose identities are sealed, that no bundle can be asked about."""
    read = judged["identity"] | {"claimed_id": desk.badge.id}
    signed = desk.signed(desk.key, badge={"id": None, "name": "Ana", "line": None}, identity=read)
    done = checked(signed, "--bundle", desk.folder / "bundle", "--key", desk.folder / "pub.pem")
    assert done.exit_code == 0 and "it still counts" in done.output, done.output


@pytest.mark.claim("No verdict of a revoked badge holds by its own date")
def test_a_verdict_of_a_badge_that_was_revoked_since_does_not_hold(desk: Desk) -> None:
    """Catches: a thief's verdict on a film of a stolen badge, dated to the day before it was missed."""
    signed = desk.signed(desk.key)
    with open_registry(desk.url, create=False) as registry:
        registry.revoke("Ana", "stolen")
    done = checked(signed, "--registry", desk.url, "--key", desk.folder / "pub.pem", "--json")
    printed = json.loads(done.stdout)
    assert done.exit_code == 1 and [fault["part"] for fault in printed["faults"]] == ["badge"]
    assert not printed["badge_now"]["counts"] and printed["badge_now"]["revoked_at"]


def test_the_signing_key_may_be_the_registry_s_by_file_as_verify_reads_it(desk: Desk) -> None:
    """Catches: a key file of the registry that `verify --sign` does not read."""
    assert load_signing_key(desk.key_path).chain == () and pem_of(load_signing_key(desk.key_path).private)
