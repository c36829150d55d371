"""A capture against the figures that are known of a badge.  Each test states what it would catch."""

from __future__ import annotations

from dataclasses import replace

import pytest

from moireid.asbuilt import AsBuilt, DatedFigures, as_built_from_json, merge
from moireid.badge import Badge
from moireid.question import Question
from moireid.verifier.identity.decode import Identity
from moireid.verifier.reasons import Reason
from moireid.verifier.session import chapters
from moireid.verifier.session.chapters import Chapter, by_figures_that_agree
from moireid.verifier.session.known_figures import compare_capture, side_by_side

KNOWN = AsBuilt("7097c67b0fafc59b", -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.01)
AGAIN = replace(KNOWN, offset_rad=3.05, gain_ratio=1.002, captures=2)
POISON = replace(KNOWN, offset_rad=-1.28, gain_ratio=0.63)


def outcome(new: AsBuilt, known: AsBuilt | None, badge: Badge) -> str:
    return compare_capture(new, known, badge).outcome


def test_a_capture_of_other_figures_is_refused(ada: Badge) -> None:
    """Catches: a gain or an offset that is not compared; error bars that excuse a drawn film."""
    assert outcome(POISON, KNOWN, ada) == "differs"
    for name, value in (("gain_ratio", 0.63), ("gain_ratio", 1.06), ("offset_rad", -1.28), ("twist_rad_per_mm", 0.06)):
        found = compare_capture(replace(KNOWN, **{name: value}), KNOWN, ada)
        assert found.refused and [pair.name for pair in found.pairs if pair.differs] == [name.split("_")[0]]
    table = "\n".join(side_by_side(compare_capture(POISON, KNOWN, ada).pairs))
    assert "0.63" in table and "0.995" in table and table.count("✗") == 2 and "in error bars" in table


def test_a_first_gain_that_no_sheet_explains_is_refused(ada: Badge) -> None:
    """Catches: a first capture that may have any gain, so that a drawn one comes before the true one."""
    assert [outcome(one, None, ada) for one in (KNOWN, replace(KNOWN, gain_ratio=1.3))] == ["new", "new"]
    mask = replace(ada, lens=replace(ada.lens, kind="mask", radius_mm=None, open_fraction=0.5))
    assert outcome(replace(KNOWN, gain_ratio=0.985, gain_sd=0.003), None, mask) == "new"
    odd = compare_capture(replace(KNOWN, gain_ratio=0.5), None, ada)
    assert odd.refused and "no lens sheet" in odd.text and "none" in side_by_side(odd.pairs)[1]


def test_a_first_capture_that_most_copies_agree_with_is_refused(ada: Badge) -> None:
    """Catches: a vague film that is enrolled, after which copies agree: 23 in 100 did at 0.9 rad."""
    vague = compare_capture(replace(KNOWN, offset_sd=0.9), None, ada)
    assert vague.outcome == "vague" and vague.refused and "0.90 rad" in vague.text
    assert outcome(replace(KNOWN, offset_sd=0.2), None, ada) == "new"


def test_a_live_check_is_a_better_witness_than_a_film(ada: Badge) -> None:
    """Catches: figures of a live check that change nothing, or that a film takes the place of; a mean of both that is
    called witnessed."""
    live = replace(AGAIN, witnessed=True)
    assert (outcome(live, KNOWN, ada), outcome(KNOWN, live, ada)) == ("refines", "same")
    assert outcome(live, replace(KNOWN, offset_rad=-1.28), ada) == "differs"
    assert outcome(replace(live, gain_sd=0.05), KNOWN, ada) == "confirms"
    assert merge([live, live]).witnessed and not merge([live, KNOWN]).witnessed
    assert as_built_from_json(live.to_json()).witnessed


def test_a_vague_live_check_confirms_nothing(ada: Badge) -> None:
    """Catches: a drawn film's figures that count as witnessed after a live check of the true badge, too dim or short to
    show where the sheet lies: it agrees with both."""
    dim = replace(AGAIN, offset_sd=0.9, witnessed=True)
    assert outcome(dim, replace(KNOWN, offset_rad=1.5), ada) == outcome(dim, KNOWN, ada) == "same"
    assert outcome(replace(dim, offset_sd=0.2), KNOWN, ada) == "confirms"


def test_equal_figures_leave_those_in_use(ada: Badge) -> None:
    """Catches: a second true capture that is refused; many small steps, or one vague film, that widen what agrees."""
    assert outcome(AGAIN, KNOWN, ada) == "same"
    assert outcome(replace(AGAIN, offset_sd=2.0, gain_sd=0.2), KNOWN, ada) == "same"


# Films against earlier figures.


def chapter(built: str, *earlier: str) -> Chapter:
    """A judged chapter, with what the earlier sets say of it."""
    fields = dict.fromkeys(Chapter.__dataclass_fields__)
    one = replace(Chapter(**fields), identity=Identity("match", (), built=built), built_reasons=())  # type: ignore[arg-type]
    return replace(one, signals=(object(),), earlier=tuple(chapter(name) for name in earlier))  # type: ignore[arg-type]


def chosen(*parts: Chapter) -> list[str]:
    return [part.identity.built for part in by_figures_that_agree(parts)]


def test_a_film_is_of_one_set_of_figures() -> None:
    """Catches: a true film of before rejected as a copy; a film joined of two builds, each half by its own figures."""
    assert chosen(chapter("differs", "differs", "agrees")) == ["agrees"]
    assert chosen(chapter("not_known", "agrees"), chapter("differs", "agrees")) == ["agrees", "agrees"]
    assert chosen(chapter("agrees"), chapter("differs", "agrees")) == ["agrees", "differs"]
    assert "agrees" not in chosen(chapter("differs", "agrees", "differs"), chapter("differs", "differs", "agrees"))
    assert chosen(chapter("differs", "differs")) == ["differs"]
    absent = replace(chapter("not_known"), signals=())
    assert chosen(absent, chapter("differs", "agrees")) == ["not_known", "agrees"]


def test_a_film_that_cannot_be_read_by_the_figures_in_use_is_read_by_earlier_ones(
    ada: Badge, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a poisoned gain under which nothing can be read, so that no earlier figures are asked."""
    asked: list[tuple[float, str | None]] = []

    def judged(track: object, claim: Question, repeated: int) -> Chapter:
        assert claim.as_built is not None
        asked.append((claim.as_built.gain_ratio, claim.replaced_at))
        if claim.as_built == POISON:
            return replace(chapter("not_known"), identity=Identity("unreadable", ()))
        return chapter("agrees" if claim.as_built == KNOWN else "differs")

    monkeypatch.setattr(chapters, "_judged_by", judged)
    earlier = (DatedFigures(KNOWN, "2026-01-01"), DatedFigures(replace(KNOWN, gain_ratio=1.2), "2026-02-01"))
    claim = Question(ada, ada.id, as_built=POISON, as_built_at="2026-03-01", earlier=earlier)
    found = chapters.judge_chapter(None, claim)  # type: ignore[arg-type]
    assert asked == [(0.63, None), (1.2, "2026-03-01"), (0.995, "2026-02-01")]
    assert [one.identity.built for one in by_figures_that_agree([found])] == ["agrees"]


def test_the_report_says_which_figures_it_used(ada: Badge) -> None:
    """Catches: an agreement with figures that are not in use, of which the report says nothing."""
    claim = Question(
        ada, ada.id, as_built=KNOWN, as_built_at="2026-01-01T10:00:00Z", replaced_at="2026-02-03T10:00:00Z"
    )
    note: Reason = chapters._by_earlier(claim)
    assert (note.code, note.level, note.measured, note.limit) == (
        "as_built_earlier",
        "note",
        "2026-01-01",
        "2026-02-03",
    )
    assert "on record since 2026-01-01" in note.text and "on 2026-02-03" in note.text
