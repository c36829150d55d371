"""The trust bundle: what it holds, what it gives away, and what is refused.  Each test says what it catches."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import msgspec
import pytest

from kit.registries import badge_of, run, url_of
from kit.untrusted_readers import signed_bundle
from moireid.asbuilt import AsBuilt
from moireid.errors import MoireIdError, RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import Registry, open_registry
from moireid.registry.bundle import bundle_file
from moireid.registry.bundle.bundle_file import read_bundle_file
from moireid.registry.bundle.held import Bundle

BUILT = AsBuilt("", 0.03, 1e-4, 0.5, 0.01, 1e-4, 1e-5, 0.98, 0.01)


@pytest.fixture
def people(url: str):
    """Ada, who was measured; Bo, who was revoked; two of one name; and one who looks like Ada."""
    with open_registry(url, create=True) as registry:
        for name in ("Ada", "Bo", "Аda"):
            registry.enroll(badge_of(name))
        for payload in (b"\x01\x02\x03", b"\x01\x02\x04"):
            registry.enroll(badge_of("Cy", payload))
        built = replace(BUILT, badge_id=badge_of("Ada").id)
        registry.store_as_built(badge_of("Ada").id, built.to_json())
        registry.revoke("Bo", "lost on the train")
        yield registry


def published(registry: Registry, path: Path, days: float = 7.0) -> Path:
    assert registry.publish(path, specimen_of, days=days, overwrite=True)[0] == registry.count()
    return path


def test_claims_mean_in_a_bundle_what_they_mean_in_the_registry(people, tmp_path):
    """Catches: a revocation, a measured figure or a look-alike that is left behind; a seal of another identity."""
    with Bundle(published(people, tmp_path / "b")) as bundle:
        ada, bo = bundle.claimed("Ada"), bundle.claimed("Bo")
        assert ada.provenance.source == "bundle" and ada.badge.name == "Ada" and ada.badge.id is None
        assert ada.seal and ada.seal.holds(badge_of("Ada").id) and not ada.seal.holds(badge_of("Bo").id)
        assert ada.as_built == BUILT and bo.as_built is None
        assert ada.barred is None and bo.barred and bo.barred.reason == "lost on the train"
        assert ada.provenance.alike == ("Аda",)
        assert ada.badge.layout_key() == badge_of("Ada").layout_key()
        assert bundle.claimed(badge_of("Bo").id.upper()).badge.name == "Bo"
        for claim, words in (("Cy", "2 people are named"), ("Di", "no one named"), ("ff" * 8, "no one there has")):
            with pytest.raises(RegistryError, match=words):
                bundle.claimed(claim)
        assert bundle.claimed("010204").badge.name == "Cy"
        standing = bundle.standing
    assert (standing.fingerprint, standing.head) == (people.fingerprint, people.head())


@pytest.mark.claim("No badge can be printed from a bundle")
def test_it_gives_no_badge_away(people, tmp_path):
    """Catches: an identity, lines, or a log entry's record in the file; one specimen that is somebody's badge."""
    whole = published(people, tmp_path / "b").read_bytes()
    content = read_bundle_file(tmp_path / "b")[2]
    # What lines are in it are those of the identity zero, which no one has.
    assert sorted(content.layouts) == sorted({specimen_of(record.badge).to_json() for record in people.records()})
    dump = repr(content)
    # Dates that it does give may be of the second in which someone was enrolled.
    dump = re.sub(r"\bdate \d\S+", "", dump)
    for record in people.records():
        for given in {record.revoked_at, record.as_built_at} - {None}:
            dump = dump.replace(given, "")
    for record in people.records():
        assert record.id.encode() not in whole and bytes.fromhex(record.id) not in whole
        assert record.id not in dump.lower()
        assert record.issued_at not in dump
    # A seal has a salt of its own: two bundles have nothing in common by which to follow a person who was renamed.
    with Bundle(published(people, tmp_path / "c")) as second, Bundle(tmp_path / "b") as first:
        assert first.claimed("Ada").seal != second.claimed("Ada").seal


def _ada(content: dict, place: int, value: object) -> None:
    content["people"][0][place] = value


@pytest.mark.parametrize(
    "change",
    [
        lambda content: _ada(content, 3, {"salt": "text", "digest": ""}),
        lambda content: _ada(content, 4, 1),
        lambda content: _ada(content, 7, [["{}"]]),
        lambda content: content.update(entries="c2hvcnQ="),
        lambda content: content.update(layouts=[]),
        lambda content: content.update(layouts=["[" * 100_000]),
        None,
    ],
)
def test_a_bundle_of_an_authority_in_an_attacker_s_hands_is_refused_in_a_sentence(tmp_path, change):
    """Catches: a signed content that ends a command in an internal error, or in a query without end."""
    made = b""
    if change:
        with open_registry(url_of(tmp_path / "people"), create=True) as people:
            people.enroll(badge_of("Ada"))
            published(people, tmp_path / "b")
        content = msgspec.to_builtins(read_bundle_file(tmp_path / "b")[2])
        change(content)
        made = msgspec.json.encode(content)
    (tmp_path / "made").write_bytes(signed_bundle(made))
    with pytest.raises(MoireIdError, match="made") as refused, Bundle(tmp_path / "made") as bundle:
        bundle.layouts()
        for claim in ("Ada", "010203"):
            bundle.claimed(claim)
    assert "\n" not in str(refused.value) and (";" in str(refused.value) or not change)


def test_every_byte_is_signed(people, tmp_path):
    """Catches: a part of the file that may be changed, added or cut."""
    path = published(people, tmp_path / "b")
    whole = path.read_bytes()
    places = [*range(0, 700, 11), *range(700, len(whole), len(whole) // 40), len(whole) - 1]
    for place in places:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.raises(RegistryError, match=r"is no bundle|is cut, changed or damaged|is of format"):
            Bundle(path)
    for other in (b"", whole[:-1], whole + b"x", whole[:300], b"moireid bundle 3 999999\n"):
        path.write_bytes(other)
        with pytest.raises(RegistryError, match=r"is no bundle|is cut, changed or damaged|is of format"):
            Bundle(path)
    path.write_bytes(whole)
    Bundle(path)
    with pytest.raises(RegistryError, match="cannot be read"):
        Bundle(tmp_path / "absent")


@pytest.mark.claim("A bundle expires")
def test_a_bundle_expires(people, tmp_path, monkeypatch):
    """Catches: an old bundle that a mirror serves for ever."""
    path = published(people, tmp_path / "b", days=2)
    moment = bundle_file.now()
    monkeypatch.setattr(bundle_file, "now", lambda: moment + timedelta(days=1.9))
    Bundle(path)
    monkeypatch.setattr(bundle_file, "now", lambda: moment + timedelta(days=2.1))
    with pytest.raises(RegistryError, match="expired on") as caught:
        Bundle(path)
    assert caught.value.details["code"] == "expired"


@pytest.mark.claim("An older bundle is refused once a newer one was seen")
def test_an_older_bundle_is_refused_once_a_newer_one_was_seen(people, tmp_path):
    """Catches: a mirror that serves the bundle from before a revocation, which has not expired."""
    old = published(people, tmp_path / "old")
    people.revoke("Ada", "stolen")
    new = published(people, tmp_path / "new")
    (tmp_path / "seen.sqlite3").unlink()
    Bundle(old)
    Bundle(new)
    with pytest.raises(RegistryError, match="rolled back") as caught:
        Bundle(old)
    assert caught.value.details["code"] == "rolled_back"


def test_a_bundle_of_a_forked_registry_is_refused(path, tmp_path):
    """Catches: a publisher who shows one history to one newsroom and another to the next."""
    with open_registry(url_of(path), create=True) as registry:
        shutil.copy(path, tmp_path / "early")
        registry.enroll(badge_of("Ada"))
        one = published(registry, tmp_path / "one")
    (tmp_path / "seen.sqlite3").unlink()
    shutil.copy(tmp_path / "early", path)
    with open_registry(url_of(path), create=False) as registry:
        for name in ("Bo", "Cy"):
            registry.enroll(badge_of(name))
        other = published(registry, tmp_path / "other")
    (tmp_path / "seen.sqlite3").unlink()
    Bundle(one)
    with pytest.raises(RegistryError, match="forked"):
        Bundle(other)


def test_only_the_trusted_authority_counts(people, tmp_path, monkeypatch):
    """Catches: a bundle that brings its own key, and is believed."""
    path = published(people, tmp_path / "b")
    (tmp_path / "seen.sqlite3").unlink()
    assert Bundle(path).standing.new and not Bundle(path).standing.new
    with open_registry(url_of(tmp_path / "eve.sqlite3"), create=True) as eve:
        eve.enroll(badge_of("Ada"))
        published(eve, path)
        other = eve.fingerprint
    with pytest.raises(RegistryError, match="key was replaced"):
        Bundle(path)
    with pytest.raises(RegistryError, match="key was replaced"):
        Bundle(path, people.fingerprint)
    assert Bundle(path, other).standing.fingerprint == other


def test_a_bundle_replaces_the_registry(people, tmp_path):
    """Catches: two sources of one claim, of which one is passed over in silence."""
    path = published(people, tmp_path / "b")
    (tmp_path / "badge.json").write_text(badge_of("Ada").to_json())
    for options in (
        ("--claim", "Ada", "--registry", "sqlite:///x"),
        ("--badge", tmp_path / "badge.json"),
    ):
        refused = run("verify", tmp_path / "film", "--bundle", path, *options, code=2)
        assert "--bundle replaces --registry" in refused.stderr
    lone = run("verify", tmp_path / "film", "--badge", tmp_path / "badge.json", "--trust", "ab" * 16, code=2)
    assert "--trust" in lone.stderr
