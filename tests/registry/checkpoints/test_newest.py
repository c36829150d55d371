"""A record that was put back, with its later entries taken from the log.  Each test says what it catches."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from kit.registries import badge_of, rows_of, tamper
from moireid.errors import RegistryError
from moireid.registry import Registry, claimed, claimed_by_file, holder_of, open_registry
from moireid.registry.claimed import People
from moireid.registry.log import entry_hash

BACK = "UPDATE badges SET revoked_at = NULL, revoked_reason = NULL, signature = :signature WHERE id = :id"


@pytest.fixture
def revoked(url: str) -> str:
    """The id of Ada's badge, which was revoked and then put back as it was before; her entries are still there."""
    with open_registry(url, create=True) as registry:
        registry.enroll(badge_of("Bo"))
        ada = registry.enroll(badge_of("Ada")).id
        signature = rows_of(url, f"SELECT signature FROM badges WHERE id = '{ada}'")[0]["signature"]
        registry.revoke("Ada", "lost on the train")
        registry.enroll(badge_of("Cy"))
    tamper(url, BACK, signature=signature, id=ada)
    return ada


def taken_out(url: str) -> None:
    tamper(url, "DELETE FROM log WHERE action = 'revoke'")


def given_to_another(url: str) -> None:
    tamper(url, "UPDATE log SET subject = 'ff' WHERE action = 'revoke'")


def written_anew(url: str) -> None:
    """Another entry in the place, whose hash fits it; the tree is over the old hash."""
    entry = rows_of(url, "SELECT * FROM log WHERE action = 'revoke'")[0] | {"subject": "ff", "action": "enroll"}
    change = "UPDATE log SET subject = 'ff', action = 'enroll', hash = :hash WHERE action = 'revoke'"
    tamper(url, change, hash=entry_hash(entry))


def numbered_anew(url: str) -> None:
    """Taken out, and the entry after it moved into its place."""
    taken_out(url)
    tamper(url, "UPDATE log SET seq = seq - 1 WHERE seq = 5", "UPDATE authority SET head_seq = 4")


@pytest.mark.parametrize("hidden", [taken_out, given_to_another, written_anew])
def test_a_badge_that_was_put_back_is_not_believed(url: str, revoked: str, hidden: Callable[[str], None]) -> None:
    """Catches: a look at the log's end and at the record's own entry alone, between which the revocation was."""
    with open_registry(url, create=False) as registry:
        with pytest.raises(RegistryError, match="not the version that the log has last"):
            claimed(registry, "Ada")
        hidden(url)
        # The record itself looks sound now; a program that relies on it must not accept it.
        assert registry.find("Ada").revoked_at is None and registry.standing() is not None
        asking: list[Callable[[], object]] = [
            lambda: claimed(registry, "Ada"),
            lambda: claimed(registry, revoked),
            lambda: claimed_by_file(registry, badge_of("Ada")),
            lambda: holder_of(registry, revoked),
            lambda: People(registry).holds(revoked),
        ]
        for ask in asking:
            with pytest.raises(RegistryError, match=r"tampered with or is damaged: (log entry [45]|.*entries from 3)"):
                ask()
        # A record that was entered after the gap is in the tree.
        assert claimed(registry, "Cy").badge.name == "Cy"


def test_a_head_that_was_moved_with_it_is_no_head(url: str, revoked: str) -> None:
    """Catches: entries numbered anew up to a head that no one signed."""
    numbered_anew(url)
    with open_registry(url, create=False) as registry, pytest.raises(RegistryError, match="authority's signature"):
        claimed(registry, "Ada")


def test_what_is_sound_is_believed(full: Registry) -> None:
    """Catches: a walk that trips over revocations and measurements, or takes an older entry for the newest."""
    assert holder_of(full, full.find("Ada").id) is not None and People(full).holds(full.find("Ada").id)
    assert claimed(full, "Bo").barred.reason == "lost on the train \u2014 twice"
    assert not People(full).holds(full.find("Bo").id) and People(full).holds(full.find("Zo\u00eb").id)
