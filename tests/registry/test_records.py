"""The registry: who was issued which badge.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from datetime import UTC, datetime

import pytest
from sqlalchemy import event

from kit.registries import badge_of, url_of
from moireid.badge import badge_from_json
from moireid.errors import RegistryError, SpecError
from moireid.registry import open_registry, queries, store

ZOE_NFC, ZOE_NFD = "Zo\u00eb", "Zoe\u0308"


# What comes out is what went in.


def test_issued_at_is_utc_now_to_the_second(registry, monkeypatch):
    """Catches: local time, microseconds, a stamp without its zone."""
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    time.tzset()
    try:
        before = datetime.now(UTC).replace(microsecond=0)
        stamp = registry.enroll(badge_of("Ada")).issued_at
        after = datetime.now(UTC)
    finally:
        monkeypatch.undo()
        time.tzset()
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", stamp)
    assert before <= datetime.fromisoformat(stamp) <= after


def test_enroll_is_idempotent(registry, monkeypatch):
    """Catches: a second row, an error, a second date of issue, or a second log entry for the very same badge."""
    first = registry.enroll(badge_of("Ada"))
    head = registry.head()
    monkeypatch.setattr(store, "utc_now", lambda: "2099-02-03T04:05:06Z")
    assert registry.enroll(badge_from_json(first.badge.to_json())) == first
    assert registry.count() == 1 and registry.head() == head


# Whose id it is.


def test_another_badge_of_the_same_name_and_id_is_refused(registry):
    """Catches: idempotence by id and name alone, which would let a badge of another pitch pass for the issued one."""
    kept = registry.enroll(badge_of("Ada"))
    with pytest.raises(RegistryError, match=r"already to 'Ada' with another badge"):
        registry.enroll(badge_of("Ada", lens="60lpi"))
    assert registry.find("Ada") == kept


@pytest.mark.parametrize("lines", [["\x1b[2JEditor"], ["Edi\u200btor"], ["x" * 3_000_000], [7], "Editor", ["x"] * 5])
def test_lines_that_are_no_plain_text_are_refused(registry, lines):
    """Catches: what a stranger's file holds below the name, in the signed record and on every list; in batches too."""
    badge = replace(badge_of("Ada"), print={"lines": lines})
    for enroll in (registry.enroll, lambda bad: registry.enroll_many([badge_of("Bo"), bad])):
        with pytest.raises(RegistryError, match="below the name 'Ada'"):
            enroll(badge)
    assert {record.name for record in registry.records()} <= {"Bo"}


# Claims.


@pytest.mark.parametrize(("enrolled", "claimed"), [(ZOE_NFC, ZOE_NFD), (ZOE_NFD, ZOE_NFC)])
def test_names_match_after_nfc(registry, enrolled, claimed):
    """Catches: comparing code points, on either side."""
    assert enrolled != claimed
    registry.enroll(replace(badge_of("Zoe"), name=enrolled))
    assert registry.find(claimed).name == ZOE_NFC


def test_ligatures_and_wide_letters_stay_apart(registry):
    """Catches: NFKC, under which two different names would be one."""
    registry.enroll(badge_of("\uff21da"))
    with pytest.raises(RegistryError, match="no one named"):
        registry.find("Ada")


def test_people_of_one_name_are_listed_with_their_lines(registry):
    """Catches: namesakes of whom a user cannot choose one; the first of them taken."""
    for badge_id, line in {"0a0a0a": "Reporter", "0b0b0b": None}.items():
        badge = badge_of("Silva, Ana", bytes.fromhex(badge_id))
        registry.enroll(replace(badge, print={"lines": [line]}) if line else badge)
    with pytest.raises(
        RegistryError, match=r"2 people are named 'Silva, Ana', with ids 0a0a0a \(Reporter\), 0b0b0b;"
    ) as caught:
        registry.find("Silva, Ana")
    assert caught.value.details["ids"] == ["0a0a0a", "0b0b0b"] and registry.find("0A0A0A").line == "Reporter"
    with pytest.raises(RegistryError, match="no one named"):
        registry.find("Silva, Ana, Reporter")


def test_id_of_one_that_is_the_name_of_another(registry):
    """Catches: preferring one kind of claim, so that somebody can take a name that is another's id."""
    registry.enroll(badge_of("Ada", bytes.fromhex("abcdef")))
    registry.enroll(badge_of("ABCDEF", bytes.fromhex("123456")))
    with pytest.raises(RegistryError, match=r"is the id of 'Ada' and also a name: 123456, abcdef") as caught:
        registry.find("ABCDEF")
    assert caught.value.details["ids"] == ["123456", "abcdef"]
    assert registry.find("abcdef").name == "Ada"  # Names keep their case, so this one is an id alone.
    assert registry.find("123456").name == "ABCDEF" and registry.find("Ada").id == "abcdef"


# Lists.


def test_records_are_ordered_and_complete_across_pages(registry, monkeypatch):
    """Catches: paging by name alone, which drops or repeats people of one name at a page's edge."""
    monkeypatch.setattr(queries, "PAGE", 3)
    names = ["Bo"] * 5 + ["Al"] * 2 + ["Cy"] * 2
    pairs = [(name, bytes([200 - k, 0, k])) for k, name in enumerate(names)]
    for name, payload in pairs:
        registry.enroll(badge_of(name, payload))
    listed = [(record.name, record.id) for record in registry.records()]
    assert listed == sorted((name, payload.hex()) for name, payload in pairs)
    assert registry.count() == len(pairs)


def test_records_are_streamed(registry, monkeypatch):
    """Catches: reading the whole table for the first record."""
    monkeypatch.setattr(queries, "PAGE", 2)
    for k in range(6):
        registry.enroll(badge_of("Ada", bytes([0, 0, k])))
    statements = []
    event.listen(registry._ledger.engine, "before_cursor_execute", lambda *args: statements.append(args[2]))
    stream = registry.records()
    assert next(stream).id == "000000"
    assert len([query for query in statements if query.startswith("SELECT badges")]) == 1
    assert len(list(stream)) == 5


def test_enrolling_while_listing(path):
    """Catches: a list that holds a lock as long as its reader takes, and so blocks every enrolment."""
    with open_registry(url_of(path, timeout=0.5), create=True) as registry:
        registry.enroll(badge_of("Ada"))
        stream = registry.records()
        next(stream)
        registry.enroll(badge_of("Bo"))
        assert [record.name for record in stream] in ([], ["Bo"])


def test_search_finds_parts_of_names_and_beginnings_of_ids(registry):
    """Catches: signs of a pattern that act as such, a search that skips or repeats, one without a bound."""
    names = ("Ada Lovelace", "Grace Hopper", "100 % Ada_", "Ágnes Keleti")
    held = {name: registry.enroll(badge_of(name)) for name in names}

    def found(text: str, limit: int = 10) -> set[str]:
        return {record.name for record in registry.search(text, limit)}

    assert found("") == found("  ") == set(names)
    assert found("ada") == {"Ada Lovelace", "100 % Ada_"}
    assert found("%") == {"100 % Ada_"} and found("a_") == {"100 % Ada_"}
    assert found("A\u0301gnes") == {"Ágnes Keleti"}
    assert found(held["Grace Hopper"].id[:9].upper()) == {"Grace Hopper"}
    assert found("nobody") == found("' OR 1=1 --") == found("a\x00") == set()
    assert [record.name for record in registry.search("", 2)] == sorted(names)[:2]


@pytest.mark.parametrize("call", [lambda r: r.find(5), lambda r: r.revoke(None, "lost"), lambda r: r.enroll(None)])
def test_what_is_no_claim_or_badge_is_said_in_a_sentence(registry, call):
    """Catches: Python's own TypeError or AttributeError out of a method of the Registry."""
    with pytest.raises(SpecError, match=r"(claim|badge)=(5|None) is not possible; give (text|a Badge)"):
        call(registry)
