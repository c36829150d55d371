"""The level of a check: reached, and asked for.  Each test states what it would catch."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kit.registries import run
from moireid.badge import load_badge
from moireid.verifier import Question, verify
from moireid.verifier.session.check_level import level_finding, level_reached


def test_a_level_is_reached_only_by_what_is_accepted() -> None:
    """Catches: a rejected film with a level; a challenge that was begun and not passed taken for a live check."""
    assert level_reached("accept", "not_known") == level_reached("accept", "differs") == "record"
    assert level_reached("accept", "agrees") == "enrolled"
    assert level_reached("accept", "not_known", challenged=True) == "live"
    for verdict in ("reject", "inconclusive"):
        assert level_reached(verdict, "agrees", challenged=True) is None  # type: ignore[arg-type]


@pytest.mark.claim("A film that reaches less than the level asked for is inconclusive")
def test_less_than_was_asked_for_is_undecided_and_more_passes() -> None:
    """Catches: a level compared as text; a default that asks for something; a finding without advice; a live check of
    a printed copy that passes for the enrolled badge."""
    assert level_finding("record", None, "not_known") == ()
    assert [one.level for one in level_finding("enrolled", "live", "agrees")] == ["pass"]
    assert [one.level for one in level_finding("live", "live", "not_known")] == ["pass"]
    for asked, reached, built, advice in (
        ("enrolled", "record", "not_known", "Enroll the badge"),
        ("enrolled", "live", "not_known", "Enroll the badge"),
        ("live", "enrolled", "agrees", "Make a live check"),
        ("live", None, "not_known", "the film itself is not accepted"),
    ):
        (found,) = level_finding(asked, reached, built)  # type: ignore[arg-type]
        assert (found.code, found.level) == ("level", "undecided") and advice in found.text and found.text.endswith(".")


@pytest.mark.slow
def test_a_plain_film_is_never_a_live_check(films: Path) -> None:
    """Catches: an option that changes a verdict unasked; a verdict worse or better than inconclusive; a wrong exit."""
    film, badge = films / "genuine_1.0m.mp4", load_badge(films / "badge.json")
    assert verify(film, Question(badge)).level == "record"
    words = ("verify", film, "--badge", films / "badge.json", "--json", "--level")
    assert json.loads(run(*words, "record").stdout)["verdict"] == "accept"
    for level in ("enrolled", "live"):
        document = json.loads(run(*words, level, code=3).stdout)
        assert (document["verdict"], document["level"]) == ("inconclusive", "record")
        assert [one["code"] for one in document["reasons"] if one["level"] == "undecided"] == ["level"]
    forged = ("verify", films / "forged_reversed_1.0m.mp4", *words[2:])
    assert json.loads(run(*forged, "live", code=1).stdout)["level"] is None
    assert "leave one of them out" in run(*words, "live", "--pipeline", "published", code=2).stderr
