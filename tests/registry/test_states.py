"""Badges that stop to count.  Each test says what it catches."""

from __future__ import annotations

from functools import partial

import pytest

from kit.registries import badge_of
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import Registry, claimed, holder_of, holds
from moireid.registry.bundle.held import Bundle


@pytest.fixture
def full(registry: Registry) -> Registry:
    """Three badges that were never measured, one of them revoked."""
    for name in ("Ada", "Bo", "Zo\u00eb"):
        registry.enroll(badge_of(name))
    registry.revoke("Bo", "lost on the train")
    return registry


@pytest.mark.claim("A revoked badge counts for nothing, wherever it is looked up")
def test_a_revoked_badge_counts_for_nothing(full, tmp_path):
    """Catches: a revocation that only a list shows; one that a bundle does not hold; one without its reason."""
    barred = claimed(full, "Bo").barred
    assert barred and barred.reason == "lost on the train" and "lost on the train" in barred.text
    holder = holder_of(full, full.find("Bo").id)
    assert holder and holder.barred == barred and not holds(partial(holder_of, full), badge_of("Bo").id)
    assert claimed(full, "Ada").barred is None and holds(partial(holder_of, full), badge_of("Ada").id)
    full.publish(tmp_path / "people.bundle", specimen_of, days=7)
    with Bundle(tmp_path / "people.bundle") as bundle:
        assert bundle.claimed("Bo").barred == barred and bundle.claimed("Ada").barred is None
        assert not holds(bundle.holder_of, badge_of("Bo").id)
    with pytest.raises(RegistryError, match="revoked already"):
        full.revoke("Bo", "again")


def test_a_bundle_of_another_version_is_not_read(full, tmp_path):
    """Catches: one that is read by the rules of this version."""
    later = tmp_path / "later.bundle"
    full.publish(later, specimen_of, days=7)
    whole = later.read_bytes()
    assert whole.startswith(b"moireid bundle 4 ")
    later.write_bytes(whole.replace(b"bundle 4 ", b"bundle 5 ", 1))
    with pytest.raises(RegistryError, match="install a newer moireid"):
        Bundle(later)
