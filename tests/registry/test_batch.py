"""Many badges at once.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from kit.registries import badge_of
from moireid.badge import Badge
from moireid.errors import RegistryError, SpecError
from moireid.registry import Registry, engine, open_registry
from moireid.registry.record import new_record


@pytest.fixture
def small_chunks(monkeypatch):
    monkeypatch.setattr(engine, "CHUNK", 4)


def people(count: int, **request: object) -> list[Badge]:
    return [badge_of(f"Al {k:02}", bytes([k, 7, 255 - k]), **request) for k in range(count)]


def with_cell(badge: Badge, **figures: object) -> Badge:
    grating = badge.gratings[0]
    return replace(
        badge, gratings=(replace(grating, cells=(*grating.cells[:-1], replace(grating.cells[-1], **figures))),)
    )


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (lambda badge: replace(badge, id="ABCDEF"), SpecError),
        (lambda badge: replace(badge, id=None), RegistryError),
        (lambda badge: replace(badge, name=" "), RegistryError),
        (lambda badge: replace(badge, name="a\ud800"), RegistryError),
        (lambda badge: with_cell(badge, pitch_mm=math.nan), (RegistryError, SpecError)),
        (lambda badge: with_cell(badge, edge_mm=math.inf), SpecError),
        (lambda badge: with_cell(badge, edge_mm=True), SpecError),
        (lambda badge: with_cell(badge, rect_mm=[1.0, 2.0, 3.0, 4.0]), SpecError),
        (lambda badge: replace(badge, print={"by": "\ud800"}), RegistryError),
    ],
)
def test_a_bad_badge_is_refused(wrong, error):
    """Catches: a figure that the schema refuses, and that is signed."""
    with pytest.raises(error):
        new_record(wrong(badge_of("Al")), "x", "2030-01-02T03:04:05Z")


# The batch.


def test_batch_is_the_same_as_one_by_one(registry: Registry, tmp_path, small_chunks):
    """Catches: a batch that signs, logs or orders otherwise."""
    badges = people(10)
    steps = []
    assert registry.enroll_many(badges, lambda *step: steps.append(step)) == sorted(
        registry.records(), key=lambda one: one.name
    )
    assert steps == [(4, 10), (8, 10), (10, 10)]
    with open_registry(f"sqlite:///{tmp_path / 'one.sqlite3'}", create=True) as single:
        for badge in badges:
            single.enroll(badge)
        ours, theirs = list(registry.records()), list(single.records())
    assert len({record.salt for record in (*ours, *theirs)}) == 20
    ours, theirs = ([replace(one, issued_at="", salt=None) for one in records] for records in (ours, theirs))
    assert ours == theirs
    seen = registry.audit()
    assert seen.sound and seen.entries == 11


def test_batch_can_be_run_again(registry, small_chunks):
    """Catches: a second date of issue; a revocation undone; an iterator without a length."""
    badges = people(10)
    registry.enroll_many(badges[:5])
    registry.revoke("Al 01", "lost")
    head = registry.head()
    before = list(registry.records())
    assert registry.enroll_many(iter(badges[:5])) == before
    assert registry.head() == head
    steps = []
    assert registry.enroll_many(iter(badges), lambda *step: steps.append(step))[:5] == before
    assert steps == [(4, None), (8, None), (10, None)]
    assert registry.find("Al 01").revoked_reason == "lost" and registry.audit().sound
    assert registry.enroll_many([]) == []


@pytest.mark.parametrize("kind", ["conflict within", "conflict before", "bad badge", "iterator"])
@pytest.mark.parametrize("at", [0, 3, 4, 6])
def test_batch_stops_at_the_first_that_cannot_be_issued(registry, small_chunks, kind, at):
    """Catches: losing the chunks before it; going on after it; half a chunk."""
    badges = people(9)
    wrong = {
        "conflict within": replace(badges[0], name="Eve"),
        "conflict before": badge_of("Eve", bytes(3)),
        "bad badge": replace(badges[0], id=None),
    }.get(kind)
    if kind == "conflict before" or (kind, at) == ("conflict within", 0):
        registry.enroll(badge_of("Zed", bytes(3)) if kind == "conflict before" else badges[0])
    before = registry.count()

    def source():
        yield from badges[:at]
        if wrong is None:
            raise OSError("the list cannot be read on")
        yield wrong
        yield from badges[at:]

    error = OSError if wrong is None else RegistryError
    with pytest.raises(error, match=r"is issued already|has no id|cannot be read on"):
        registry.enroll_many(source())
    whole = at - at % 4
    assert registry.count() == before + whole and registry.audit().sound
    names = [badge.name for badge in badges[:whole]]
    assert [record.name for record in registry.records()][: len(names)] == names
