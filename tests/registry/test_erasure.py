"""People erased on their wish.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from kit.registries import badge_of, rows_of, tamper
from moireid.cli.main import moireid
from moireid.errors import RegistryError
from moireid.registry import claimed_by_file, holder_of, import_registry, open_registry
from moireid.registry.canonical import pack
from moireid.registry.record import new_record

NAME = "Wilhelmina Quux"


@pytest.fixture
def erased(registry):
    """A registry of three, of whom one was measured, revoked and erased; and her badge."""
    badge = badge_of(NAME)
    for one in (badge_of("Ada"), badge, badge_of("Bo")):
        registry.enroll(one)
    registry.store_as_built(str(badge.id), '{"tilt_rad": 0.01}')
    registry.revoke(NAME, "Quux lost it")
    before = registry.checkpoint()[0]
    entry, cleaned = registry.by("Bob").erase(NAME)
    assert (entry["subject"], entry["action"], cleaned) == (badge.id, "erase", True)
    return registry, badge, before


def test_the_chain_stays_and_checkpoints_hold(erased):
    """Catches: entries taken out with the person; an erasure that the audit calls a loss, or does not count."""
    registry, badge, before = erased
    seen = registry.audit(since=[before])
    assert (seen.sound, seen.erased, seen.records, seen.found) == (True, 1, 2, 0)
    entry = registry.entries(badge.id)[0]
    assert (entry["action"], entry["subject"], entry["actor"]) == ("erase", badge.id, "Bob")
    # As the name is gone, only the id finds what was done.
    with pytest.raises(RegistryError, match="no one named"):
        registry.entries(NAME)


@pytest.mark.claim("Of an erased person, nothing stays in the registry")
def test_no_file_holds_the_person(erased, url, path, tmp_path):
    """Catches: pages of SQLite that keep what was deleted; statistics of PostgreSQL; a packed badge; an export."""
    registry, badge, _ = erased
    registry.export(tmp_path / "after.sqlite3")
    files = [path, tmp_path / "after.sqlite3"] if url.startswith("sqlite") else [tmp_path / "after.sqlite3"]
    packed = pack(replace(badge).to_json())[20:60]
    for file in files:
        content = file.read_bytes()
        assert b"Quux" not in content and b"quux" not in content and packed not in content, file
    if not url.startswith("sqlite"):
        values = rows_of(url, "SELECT * FROM pg_stats WHERE schemaname LIKE 'people%'")
        assert all("Quux" not in str(row) for row in values)


def test_nothing_in_the_log_can_be_tried_against_a_name(erased, url):
    """Catches: a hash of the record without a salt, which anyone who guesses the name can make again."""
    badge = erased[1]
    entries = rows_of(url, f"SELECT time, record_sha256 FROM log WHERE subject = '{badge.id}' ORDER BY seq")
    guess = new_record(badge, "x", entries[0]["time"])
    assert guess.digest() not in {entry["record_sha256"] for entry in entries}


def test_the_badge_is_nobodys_from_then_on(erased):
    """Catches: an identity issued again, to the same or to another; an erased person taken for a stranger."""
    registry, badge, _ = erased
    for again in (badge, replace(badge, name="Eve")):
        with pytest.raises(RegistryError, match="whose holder was erased, and is never issued again"):
            registry.enroll(again)
        with pytest.raises(RegistryError, match="never issued again"):
            registry.enroll_many([badge_of("Di"), again])
    assert registry.count() == 2
    with pytest.raises(RegistryError, match=r"holder of badge .* was erased from registry") as caught:
        registry.find(str(badge.id))
    assert caught.value.details["code"] == "erased" and "Quux" not in str(caught.value)
    by_file = claimed_by_file(registry, badge)
    assert by_file.barred and "erased" in by_file.barred.reason and by_file.barred.at
    holder = holder_of(registry, badge.id)
    assert holder is not None and holder.name == "somebody who was erased" and holder.barred


def test_a_tombstone_cannot_be_made_or_taken_away(erased, url):
    """Catches: a row deleted with no entry; an entry of erasure that the authority did not sign; a row put back."""
    registry = erased[0]
    ada = registry.find("Ada")
    tamper(url, f"DELETE FROM badges WHERE id = '{ada.id}'")
    assert {finding.code for finding in registry.audit().findings} == {"record_missing"}
    tamper(url, f"UPDATE log SET subject = '{ada.id}' WHERE action = 'erase'")
    codes = {finding.code for finding in registry.audit().findings}
    assert "entry_hash" in codes
    with pytest.raises(RegistryError, match="tampered with"):
        registry.erased_at(ada.id)


@pytest.mark.usefixtures("machines")
def test_an_import_erases_too_and_never_brings_back(registry, url, target, tmp_path, keys):
    """Catches: a person who comes back from a copy that did not learn of it; a copy that keeps them."""
    for name in ("Ada", NAME):
        registry.enroll(badge_of(name))
    registry.export(tmp_path / "before.sqlite3")
    import_registry(tmp_path / "before.sqlite3", target)
    registry.erase(NAME)
    registry.export(tmp_path / "after.sqlite3")
    with open_registry(target, create=False) as copy:
        assert import_registry(tmp_path / "after.sqlite3", target) == 1
        assert [record.name for record in copy.records()] == ["Ada"]
        seen = copy.audit()
        assert (seen.sound, seen.erased) == (True, 1)
    import_registry(tmp_path / "before.sqlite3", url)
    assert [record.name for record in registry.records()] == ["Ada"] and registry.audit().sound


def test_the_command_asks_for_yes_and_can_be_given_again(registry, url):
    """Catches: an erasure by a slip; a second one that fails after the first could not clean."""
    registry.enroll(badge_of(NAME))
    badge_id = str(badge_of(NAME).id)
    refused = CliRunner().invoke(moireid, ["registry", "erase", NAME, "--registry", url])
    assert refused.exit_code == 2 and "--yes" in refused.stderr and registry.count() == 1
    done = CliRunner().invoke(moireid, ["registry", "erase", NAME, "--yes", "--registry", url, "--json"])
    answer = json.loads(done.stdout)
    assert (answer["subject"], answer["cleaned"]) == (badge_id, True)
    again = CliRunner().invoke(moireid, ["registry", "erase", badge_id, "--yes", "--registry", url, "--json"])
    assert json.loads(again.stdout) == answer and registry.audit().erased == 1
    audit = CliRunner().invoke(moireid, ["registry", "audit", "--registry", url])
    assert audit.exit_code == 0 and "1 erased" in audit.stdout
