"""Names that the eye takes for one another.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

from dataclasses import replace

import pytest
from click.testing import CliRunner

from kit.registries import badge_of, url_of
from moireid.cli.main import moireid
from moireid.errors import RegistryError, SpecError
from moireid.provenance import Provenance
from moireid.question import Question
from moireid.registry import claimed, claimed_by_file, open_registry
from moireid.registry.look_alikes import alike_within, folded_skeleton, skeleton
from moireid.verifier.identity.decode import Identity
from moireid.verifier.session.claim import claim_reasons
from moireid_studio.jobs.orders import VisitorOrder, checked

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
        ("\u5c71\u7530", "\u5c71\u672c"),
        ("Ada", ""),
        ("Bob", "Rob"),
    ],
)
def test_other_names_do_not(one: str, other: str) -> None:
    """Catches: accents folded, and a table that makes one letter of all."""
    assert skeleton(one) != skeleton(other)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("Ada Lovelace", "ADA LOVELACE"),
        ("Ada Lovelace", "\uff21\uff44\uff41 \uff2c\uff4f\uff56\uff45\uff4c\uff41\uff43\uff45"),
        ("Ada Lovelace", "\u0410D\u0410 LOVELACE"),
        ("Gro\u00df", "GROSS"),
        ("AI Modern", "Al Modern"),
    ],
)
def test_case_and_width_hide_no_one(one: str, other: str) -> None:
    """Catches: a search that folds neither, or folds first and so loses what capitals look like."""
    assert alike_within([one, other]) == [(other, one)] and alike_within([other, one]) == [(one, other)]
    assert alike_within(["Ada", "Ida", "Ali", "All", "Ada"]) == []
    assert folded_skeleton("Zo\u00eb") != folded_skeleton("Zoe")


@pytest.mark.claim("A name that looks like another is warned about")
def test_a_claim_in_look_alike_letters_names_who_is_enrolled(tmp_path, keys) -> None:
    """Catches: a claim that fails, or passes, without a word of the one it poses as."""
    ada, eve = badge_of("Ada Lovelace"), badge_of(CYRILLIC)
    with open_registry(url_of(tmp_path / "r.sqlite3"), create=True) as registry:
        registry.enroll(ada)
        assert claimed(registry, "Ada Lovelace").provenance.alike == ()
        with pytest.raises(RegistryError, match=rf"looks like Ada Lovelace \({ada.id}\)") as refused:
            claimed(registry, CYRILLIC)
        assert refused.value.details["ids"] == []
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


@pytest.mark.claim("Hidden letters are refused at entry")
@pytest.mark.parametrize("letter", ["\u200b", "\u202e", "\u200f", "\u2066", "\u00ad", "\u3164"])
def test_invisible_letters_are_refused_in_every_way_in(tmp_path, keys, letter) -> None:
    """Catches: one way in that forgets to look: the library, a batch, the command, a list, the studio's order."""
    name = f"Ada{letter} Lovelace"
    bad = replace(badge_of("Ada Lovelace"), name=name)
    (tmp_path / "badge.json").write_text(bad.to_json(), encoding="utf-8")
    (tmp_path / "people.csv").write_text(f"name\n{name}\n", encoding="utf-8")
    url = url_of(tmp_path / "r.sqlite3")
    with open_registry(url, create=True) as registry:
        for way in (lambda: registry.enroll(bad), lambda: registry.enroll_many([bad])):
            with pytest.raises(RegistryError, match="invisible letters"):
                way()
        with pytest.raises(SpecError, match="invisible"):
            checked(VisitorOrder(name), registry, {})
        out = str(tmp_path / "out")
        ways = [["enroll", str(tmp_path / "badge.json")], ["print", name, "--out", out]]
        for way in (*ways, ["print", "--people", str(tmp_path / "people.csv"), "--out", out]):
            done = CliRunner().invoke(moireid, [*way, "--registry", url])
            assert done.exit_code == 2 and "invisible" in done.stderr, done.output
        assert registry.count() == 0 and not (tmp_path / "out").exists()


def test_a_claim_with_hidden_letters_is_noted(tmp_path, keys) -> None:
    """Catches: a name of a bundle, a file or an old registry that passes for another without a word."""
    badge = replace(badge_of("Ada"), name="Ada\u200b")
    reasons = claim_reasons(Question(badge, badge.id, provenance=Provenance("bundle")), Identity("unreadable", ()))
    (found,) = [reason for reason in reasons if reason.code == "hidden_letters"]
    assert found.level == "note" and "ZERO WIDTH SPACE" in found.text
    plain = claim_reasons(
        Question(badge_of("Ada"), badge.id, provenance=Provenance("bundle")), Identity("unreadable", ())
    )
    assert "hidden_letters" not in {reason.code for reason in plain}


def test_a_mistyped_claim_names_who_may_be_meant(registry):
    """Catches: "no one named Ada" where one Ada is enrolled; a suggestion of someone unlike."""
    registry.enroll(badge_of("Ada Lovelace"))
    for claim in ("Ada", "lovelace", "Ada Lovelacce"):
        with pytest.raises(RegistryError, match=r"did you mean 'Ada Lovelace'\?"):
            registry.find(claim)
    with pytest.raises(RegistryError) as refused:
        registry.find("Zed")
    assert "did you mean" not in str(refused.value)
