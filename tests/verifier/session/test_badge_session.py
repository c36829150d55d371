"""Badges next to the judged one.  Each test states what it would catch."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from moireid.verifier.session.badge_session import ChapterTracker, breaking_finding


def chapter(verdict: str, decoded: str | None, *spans: tuple[float, float]) -> SimpleNamespace:
    return SimpleNamespace(
        invariant=SimpleNamespace(verdict=verdict),
        identity=SimpleNamespace(decoded_id=decoded),
        judged_s=spans,
        signals=(),
    )


def line(*chapters: SimpleNamespace) -> ChapterTracker:
    return ChapterTracker(claim=None, tracker=None, done=list(chapters))


@pytest.mark.parametrize(
    ("chapters", "found"),
    [
        ([chapter("reject", None, (4.0, 9.0))], ((4.0, 9.0),)),
        ([chapter("reject", "ab", (4.0, 9.0))], ()),
        ([chapter("accept", None, (4.0, 9.0))], ()),
        ([chapter("reject", None, (4.0, 9.0)), chapter("accept", "ab", (9.0, 12.0))], ()),
    ],
    ids=["nameless and false", "another person's", "nameless and true", "named elsewhere"],
)
def test_a_badge_without_a_name_that_breaks_the_law_is_remembered(chapters, found):
    """Catches: another person's forged badge held against this one; one with its code painted over forgotten."""
    assert line(*chapters).breaking() == found


def test_what_happens_while_the_judged_badge_is_away_leaves_the_film_open():
    """Catches: a frozen badge with a hidden code that follows a true spell; a neighbour's board blamed on it."""
    (reason,) = breaking_finding([(6.0, 10.0)], [(0.0, 6.5)])
    assert reason.code == "others_break" and reason.level == "undecided"
    assert reason.measured == pytest.approx(3.5) and "6 and 10 s" in reason.text
    assert breaking_finding([(2.0, 6.0)], [(0.0, 6.5)]) == ()
    assert breaking_finding([(6.0, 7.2)], [(0.0, 6.5)]) == ()
    assert breaking_finding([], [(0.0, 6.5)]) == ()
