"""Measured figures in the registry: what may take the place of what, and what stays on record.

Each test states the wrong implementation that it catches.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from kit.registries import badge_of, tamper
from moireid.asbuilt import AsBuilt
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.registry import Record, Registry, claimed, open_registry
from moireid.registry.bundle.held import Bundle
from moireid.registry.canonical import pack
from moireid.registry.changes import MOST_SETS

FIRST, OTHER, THIRD = ({"tilt_rad": tilt} for tilt in (0.01, 0.5, 0.02))


@pytest.fixture
def ada(registry: Registry) -> Record:
    """Ada's badge with figures."""
    registry.enroll(badge_of("Ada"))
    return registry.store_as_built(badge_of("Ada").id, json.dumps(FIRST))


def on_record(record: Record) -> list[object]:
    return [one["as_built"] for one in record.earlier_figures]


def test_figures_in_use_are_never_replaced_without_a_word(registry, ada):
    """Catches: figures that anyone who may enroll a capture can exchange; an agreement with other figures than those in
    use taken for one with these."""
    head = registry.head()
    for given in ({}, {"refines": json.dumps(OTHER)}):
        with pytest.raises(RegistryError, match=r"has measured figures since .*replace= and reason=") as refused:
            registry.store_as_built(ada.id, json.dumps(OTHER), **given)
        assert refused.value.details["code"] == "figures_known"
    for empty in ("", " ", "two\nlines"):
        with pytest.raises(RegistryError, match="plain words"):
            registry.store_as_built(ada.id, json.dumps(OTHER), reason=empty)
    assert registry.find("Ada") == ada and registry.head() == head


def test_figures_of_before_stay_on_record_with_the_reason_in_record_and_log(registry, ada):
    """Catches: a history that loses a set, its day or its reason; an entry that looks like a first measurement."""
    registry.store_as_built(ada.id, json.dumps(OTHER), reason="the sheet was put on again")
    now = registry.store_as_built(ada.id, json.dumps(THIRD), refines='{"tilt_rad":0.5}')
    assert json.loads(now.as_built) == THIRD and on_record(now) == [FIRST, OTHER]
    assert [one["as_built_reason"] for one in now.figure_sets] == [None, "the sheet was put on again", None]
    assert now.earlier_figures[0]["as_built_at"] == ada.as_built_at
    actions = [entry["action"] for entry in registry.entries("Ada")]
    assert actions == ["as_built_refined", "as_built_replaced", "as_built", "enroll"]
    assert registry.revoke("Ada", "lost").earlier_figures == now.earlier_figures and registry.audit().sound


def test_a_badge_has_no_more_sets_than_a_film_may_be_compared_with(registry, ada):
    """Catches: a flood of figures, one of which any copy agrees with."""
    for k in range(MOST_SETS - 1):
        registry.store_as_built(ada.id, json.dumps({"n": k}), reason="again")
    with pytest.raises(RegistryError, match="the most that one can have"):
        registry.store_as_built(ada.id, json.dumps({"n": -1}), reason="again")


def test_an_audit_finds_an_earlier_set_that_was_taken_out(url, registry, ada):
    """Catches: a history that is not signed; one that the holder of the key can shorten, as the log does not count."""
    now = registry.store_as_built(ada.id, json.dumps(OTHER), reason="measured anew")
    tamper(url, "UPDATE badges SET as_built_earlier = NULL")
    assert [one.code for one in registry.audit().findings] == ["record_signature"]
    with pytest.raises(RegistryError, match="tampered"):
        registry.find("Ada")
    tamper(url, "UPDATE badges SET as_built_earlier = :text", text=pack(json.dumps([])))
    assert [one.code for one in registry.audit().findings] == ["record_signature"]
    # One who has the key signs the shorter record and enters it as a revocation.
    tamper(url, "UPDATE badges SET as_built_earlier = :text", text=pack(now.as_built_earlier))
    with registry._ledger.writing("Eve") as transaction:
        transaction.change(replace(now, as_built_earlier=None), "revoke")
    assert [one.code for one in registry.audit().findings] == ["figures_missing"]


def test_a_claim_knows_the_earlier_figures_by_registry_and_bundle(url, tmp_path: Path):
    """Catches: a verifier that knows the figures in use alone; a bundle that gives an identity or a reason away."""
    badge = badge_of("Ada")
    first, other = (AsBuilt(str(badge.id), 0.03, 1e-4, at, 0.01, 1e-4, 1e-5, 0.98, 0.01) for at in (0.5, 2.5))
    with open_registry(url, create=True) as registry:
        registry.enroll(badge)
        at = registry.store_as_built(badge.id, first.to_json()).as_built_at
        registry.store_as_built(badge.id, other.to_json(), reason="secret words")
        registry.publish(tmp_path / "b", specimen_of, days=7)
        known = claimed(registry, "Ada")
    assert (known.as_built, [one.as_built for one in known.earlier]) == (other, [first])
    assert known.earlier[0].at == at and known.as_built_at is not None
    with Bundle(tmp_path / "b") as bundle:
        held = bundle.claimed("Ada")
    assert [(one.as_built.offset_rad, one.as_built.badge_id, one.at) for one in held.earlier] == [(0.5, "", at)]
    assert held.as_built_at == known.as_built_at
    whole = (tmp_path / "b").read_bytes()
    assert str(badge.id).encode() not in whole and b"secret words" not in whole
