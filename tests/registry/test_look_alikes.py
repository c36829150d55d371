"""Names that the eye takes for one another.  Beside each test: the wrong implementation it would catch."""

from __future__ import annotations

from dataclasses import replace

import pytest

from kit.registries import badge_of, url_of
from moireid.errors import RegistryError
from moireid.registry import claimed, claimed_by_file, open_registry
from moireid.registry.look_alikes import alike_within, looks_like, skeleton

CYRILLIC = "\u0410d\u0430 L\u043ev\u0435l\u0430\u0441\u0435"


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("Ada Lovelace", CYRILLIC),
        ("Ada Lovelace", "\u0391da Lovelace"),
        ("Al Modern", "A1 Modem"),
        ("Ada\u200d Lovelace", "Ada Lovelace"),
        ("Ada\ufe0f Lovelace", "Ada Lovelace"),
        ("Ada  Lovelace", "Ada\u00a0Lovelace"),
        ("O'Neil", "O\u2019Neil"),
        ("\ufb01sh", "fish"),
        # The package sets marks around what is written from right to left.
        ("Dov \u05f0", "Dov \u05d5\u05d5"),
    ],
)
def test_names_that_look_alike_have_one_skeleton(one: str, other: str) -> None:
    """Catches: pairs read from the wrong side, marks left in, letters that are drawn as nothing, runs of spaces."""
    assert one != other and skeleton(one) == skeleton(other)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("Ada", "Ida"),
        ("Zo\u00eb", "Zoe"),
        ("ada", "Ada"),
        ("\u5c71\u7530", "\u5c71\u672c"),
        ("Ada", ""),
        ("Bob", "Rob"),
    ],
)
def test_other_names_do_not(one: str, other: str) -> None:
    """Catches: case or accents folded, and a table that makes one letter of all."""
    assert skeleton(one) != skeleton(other)


def test_only_others_look_alike() -> None:
    """Catches: everybody told to look like themself, and a name in NFD taken for another than in NFC."""
    assert looks_like("Ada Lovelace", CYRILLIC) and not looks_like("Zoe\u0308", "Zo\u00eb")
    assert alike_within(["Ada Lovelace", "Bob", "Ada Lovelace"]) == []
    assert alike_within(["Ada Lovelace", "Bob", CYRILLIC]) == [(CYRILLIC, "Ada Lovelace")]


def test_a_claim_in_look_alike_letters_names_who_is_enrolled(tmp_path, keys) -> None:
    """Catches: a claim that fails, or passes, without a word of the one it poses as."""
    ada, eve = badge_of("Ada Lovelace"), badge_of(CYRILLIC)
    with open_registry(url_of(tmp_path / "r.sqlite3"), create=True) as registry:
        registry.enroll(ada)
        assert claimed(registry, "Ada Lovelace").provenance.alike == ()
        with pytest.raises(RegistryError, match=rf"looks like Ada Lovelace \({ada.id}\)") as nobody:
            claimed(registry, CYRILLIC)
        assert nobody.value.details["ids"] == []
        registry.enroll(eve)
        assert claimed(registry, CYRILLIC).provenance.alike == (f"Ada Lovelace ({ada.id})",)
        assert claimed(registry, ada.id or "").provenance.alike == (f"{CYRILLIC} ({eve.id})",)


def test_a_file_gives_way_to_the_registry(tmp_path, keys) -> None:
    """Catches: the name of a file shown for the registry's, and a record that vouches for what it does not hold."""
    ada, bob = badge_of("Ada Lovelace"), badge_of("Bob")
    with open_registry(url_of(tmp_path / "r.sqlite3"), create=True) as registry:
        registry.enroll(ada)
        edited = claimed_by_file(registry, replace(ada, name="Grace Hopper"))
        assert edited.badge.name == "Ada Lovelace" and edited.provenance.file_name == "Grace Hopper"
        same = claimed_by_file(registry, ada)
        assert (same.provenance.source, same.provenance.file_name) == ("registry", None)
        stranger = claimed_by_file(registry, bob)
        assert (stranger.provenance.source, stranger.badge.name) == ("file", "Bob")
        assert claimed_by_file(registry, replace(ada, id=None)).provenance.source == "file"
