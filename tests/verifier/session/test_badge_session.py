"""Badges next to the judged one.  Each test states what it would catch."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from moireid.verifier.session.badge_session import (
    BrokenBadge,
    ChapterTracker,
    broken_findings,
    judged_badge,
)


def chapter(
    verdict: str,
    decoded: str | None,
    *spans: tuple[float, float],
    fits: bool | None = None,
    claimed: SimpleNamespace | None = None,
) -> SimpleNamespace:
    """fits: whether the law explains the fringes, by its verdict where that is not said; claimed: as `Chapter`."""
    fits = verdict != "reject" if fits is None else fits
    return SimpleNamespace(
        invariant=SimpleNamespace(verdict=verdict),
        identity=SimpleNamespace(decoded_id=decoded),
        judged_s=spans,
        signals=(),
        breaks_law=not fits,
        claimed=claimed,
    )


def line(*chapters: SimpleNamespace, shown: float = 1.0, verdict: str | None = None, x: float = 5.0) -> ChapterTracker:
    tracker = SimpleNamespace(
        shown=shown,
        ends=SimpleNamespace(first=SimpleNamespace(frame=7, time_s=0.2)),
        outline_px=lambda: np.array([[x, 9.0]] * 4),
    )
    claim = SimpleNamespace(id_if_read=lambda found: "ab")
    return ChapterTracker(question=claim, tracker=tracker, done=list(chapters), _verdict=verdict)


def outcome(*lines: ChapterTracker) -> tuple[ChapterTracker, list[str]]:
    """The judged badge, and the codes that make the film inconclusive for the others."""
    broken = [one for line in lines for one in line.broken()]
    judged = judged_badge(lines, broken)
    return judged, [reason.code for reason in broken_findings(judged, broken)]


@pytest.mark.parametrize(
    ("chapters", "verdict", "found"),
    [
        ([chapter("reject", None, (4.0, 9.0))], "reject", ((4.0, 9.0),)),
        ([chapter("reject", "ab", (4.0, 9.0))], "reject", ((4.0, 9.0),)),
        ([chapter("accept", None, (4.0, 9.0))], "inconclusive", None),
        ([chapter("accept", "ab", (4.0, 9.0))], "accept", None),
        (
            [chapter("reject", None, (4.0, 9.0)), chapter("accept", "ab", (9.0, 12.0))],
            "reject",
            ((4.0, 9.0), (9.0, 12.0)),
        ),
        ([chapter("inconclusive", "ab", (4.0, 9.0))], "inconclusive", None),
        ([chapter("inconclusive", "ab", (4.0, 9.0), fits=False)], "inconclusive", ((4.0, 9.0),)),
        ([chapter("inconclusive", None, (4.0, 9.0), fits=False)], "inconclusive", ((4.0, 9.0),)),
    ],
)
def test_a_rejected_badge_is_remembered(chapters, verdict, found):
    """Catches: one with its code painted over forgotten; a true one held against another."""
    broken = line(*chapters, verdict=verdict).broken()
    assert [one.judged_s for one in broken] == ([] if found is None else [found])


def test_what_happens_while_the_judged_badge_is_away_leaves_the_film_open():
    """Catches: a frozen badge with a hidden code that follows a true spell; a neighbour's board blamed on it."""
    true = line(chapter("accept", "ab", (0.0, 6.5)), verdict="accept")

    def findings(*spans: tuple[float, float]):
        return broken_findings(true, [BrokenBadge(frozenset(), spans, None)])

    (reason,) = findings((6.0, 10.0))
    assert reason.code == "others_break" and reason.level == "undecided"
    assert reason.measured == pytest.approx(3.5) and "6 and 10 s" in reason.text
    assert findings((2.0, 6.0)) == findings((6.0, 7.2)) == findings() == ()


TRUE = chapter("accept", "ab", (0.0, 9.0))


def test_of_two_badges_of_one_identity_neither_decides():
    """Catches: a copy that a bystander moves, which rejects the wearer; a forged badge that a true one excuses; their
    size or order decisive."""
    for sizes in ((1.0, 2.0), (2.0, 1.0)):
        true = line(TRUE, shown=sizes[0], verdict="accept", x=700.0)
        copy = line(chapter("reject", "ab", (1.0, 8.0)), shown=sizes[1], verdict="reject", x=40.0)
        for lines in ((true, copy), (copy, true)):
            assert outcome(*lines) == (true, ["others_break"])
        (found,) = broken_findings(true, copy.broken())
        assert found.level == "undecided" and found.measured == 7.0
        assert "(40, 9)" in found.text and "(700, 9)" in found.text


@pytest.mark.claim("A true badge next to a forged one excuses nothing")
@pytest.mark.parametrize(
    ("spans", "decoded", "rejected"),
    [
        ([(1.0, 8.0), (8.0, 9.9)], "ab", False),
        ([(1.0, 8.0), (9.0, 11.0)], "ab", True),
        ([(20.0, 29.0)], "ab", True),
        ([], "ab", True),
        ([(1.0, 8.0)], "cd", False),
    ],
    ids=["less than a second apart", "two seconds apart", "after a cut", "never judged", "another person's"],
)
def test_a_true_badge_excuses_only_what_is_seen_next_to_it(spans, decoded, rejected):
    """Catches: a true spell before a cut that excuses a forged one after it; another person's badge that counts."""
    true, other = line(TRUE, verdict="accept"), line(chapter("reject", decoded, *spans), verdict="reject", x=300.0)
    judged, codes = outcome(true, other)
    assert judged is (other if rejected else true)
    assert codes == (["others_break"] if not rejected and decoded == "ab" else [])


def test_a_true_badge_excuses_no_other_of_its_identity_that_the_law_does_not_explain():
    """Catches: fringes at half the gain on the speaker, accepted for a true badge in a corner; a badge that is held
    against itself."""
    half = line(chapter("inconclusive", "ab", (0.0, 9.0), fits=False), shown=2.0, verdict="inconclusive", x=300.0)
    true = line(TRUE, verdict="accept")
    assert outcome(half, true) == (true, ["others_break"])
    assert outcome(half) == (half, []) and outcome(true) == (true, [])
