"""Judging a film in chapters, so that memory does not grow with its length and every frame is still examined.

Steps 3 to 7 of ARCHITECTURE.md; where the figures are not those in use, and earlier ones are on record, the same by
each earlier set.

A film of up to `CHAPTER_FRAMES` is one chapter.  In a longer film each chapter is judged by itself, and then all of
them together.  So an hour of true motion cannot average away one forged minute.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from moireid.question import Question
from moireid.verifier.damage import CLAIMED
from moireid.verifier.decision.judge import Invariant, Segment, gain_of, judge, judge_segments
from moireid.verifier.decision.sheet_gain import DESIGNED, SheetGain
from moireid.verifier.fringes.grating_signal import GratingSignal, joined
from moireid.verifier.fringes.signals import Measurement, measure
from moireid.verifier.identity.cell_slip import RowsApart
from moireid.verifier.identity.compare_built import Comparison, compare_built, filmed_built
from moireid.verifier.identity.decode import Identity, judge_identity
from moireid.verifier.limits import MAX_DOUBTFUL_SHARE, MAX_RIVAL_LOG10, MIN_FRAMES
from moireid.verifier.reasons import Level, Reason, Verdict, worst
from moireid.verifier.session.claim import least_strength, sheet_of
from moireid.verifier.session.cover import judged_spans, seen_spans
from moireid.verifier.timeline import Span
from moireid.verifier.tracking.track import Track

#: Tracked frames of a chapter: half a minute at 60 frames a second, 6 MB of profiles.
CHAPTER_FRAMES = 1800
#: Each chapter begins with this many frames of the last one.  So no end of a film is too short to be judged, and no cut
#: can hide at a border.
OVERLAP_FRAMES = 240
#: Where a film's times restart, a chapter ends if it has this many tracked frames.  A shorter chapter goes on after a
#: gap in time.  Otherwise a forger could restart the times to get chapters of two seconds, too short to show slow
#: drifts.
PIECE_FRAMES = OVERLAP_FRAMES

FIGURES_NOT_SHOWN = (
    "The film does not show whether its figures are those measured at enrolment. Film the badge nearer and with more "
    "motion, or do not require them."
)


@dataclass(frozen=True)
class Chapter:
    """One chapter: what was found in it.

    tracked: number of frames that are not in an earlier chapter; signals: of these frames; track, measurement: of all
    its frames, None once they are dropped; sheet: the gains that the badge may have (the signals are computed with the
    expected one); judged_s, seen_s: the spans that were judged, and those that show the badge;
    earlier: the same by each earlier set of figures, the newest first, where the film does not agree with those in use;
    claimed: as it was rejected with the frames that only the container says are damaged, where it is not without them.
    """

    frames_read: int
    tracked: int
    span_s: Span
    seen_s: tuple[Span, ...]
    stages_s: dict[str, float]
    track: Track | None
    invariant: Invariant
    identity: Identity
    built_reasons: tuple[Reason, ...] = ()
    segments: tuple[Segment, ...] = ()
    signals: tuple[GratingSignal, ...] = ()
    measurement: Measurement | None = None
    judged_s: tuple[Span, ...] = ()
    sheet: SheetGain = DESIGNED
    earlier: tuple[Chapter, ...] = ()
    claimed: Chapter | None = None

    @property
    def breaks_law(self) -> bool:
        """Whether its fringes are not those of the badge as usual: rejected, or would be but for noise, its page off,
        or of a gain that is not.
        """
        own = self.invariant
        if own.verdict == "accept":
            return False
        unusual = any(one.moved and not one.usual for one in own.compared)
        return own.verdict == "reject" or own.broken_but_for_noise or self.identity.page_off or unusual

    def light(self) -> Chapter:
        """The chapter without track and measurement, which only the plots of the report need."""
        claimed = self.claimed.light() if self.claimed else None
        earlier = tuple(one.light() for one in self.earlier)
        return replace(self, track=None, measurement=None, earlier=earlier, claimed=claimed)


def judge_marked(track: Track, question: Question, repeated: int, marks: Sequence[int]) -> Chapter:
    """As `judge_chapter`, without damaged frames; marks: of each frame of the film, as `DamageWatch.marks`."""
    mark = np.array([marks[number] for number in track.frame_numbers], int)

    def judged(most: int) -> Chapter:
        kept = mark <= most
        return judge_chapter(track.only(kept), question, repeated=int(kept[:repeated].sum()))

    chapter = judged(CLAIMED)
    if (mark == CLAIMED).any() and _verdict(chapter) == "reject":
        sound, rejected = judged(0), chapter.light()
        if _verdict(sound) != "reject":
            # By whichever figures the film is judged in the end, it is doubted.
            earlier = tuple(replace(one, claimed=rejected) for one in sound.earlier)
            return replace(sound, claimed=rejected, earlier=earlier)
    return chapter


def _verdict(chapter: Chapter) -> Verdict:
    """Of law, identity and figures of enrolment, by one chapter alone."""
    return worst([*chapter.invariant.reasons, *chapter.identity.reasons, *chapter.built_reasons])


def judge_chapter(track: Track, question: Question, *, repeated: int = 0) -> Chapter:
    """Steps 3 to 7 for a track, whose first `repeated` frames were in the last chapter too.

    Convention: as `film.verify`.
    Source: module docstring.
    """
    chapter = _judged_by(track, question, repeated)
    if not chapter.signals or chapter.identity.built == "agrees":
        return chapter
    return replace(chapter, earlier=tuple(_judged_by(track, one, repeated) for one in question.by_earlier()))


def by_figures_that_agree(chapters: Sequence[Chapter]) -> list[Chapter]:
    """The chapters as judged by one set of figures for the whole film: that in use, or the newest earlier one that the
    film agrees with.

    Convention: a chapter that agrees with the figures in use decides for them, so no film is joined of two badges.
    """
    judged = [chapter for chapter in chapters if chapter.signals]
    for number in range(min((len(chapter.earlier) for chapter in judged), default=0)):
        under = [chapter.earlier[number] if chapter.earlier else chapter for chapter in chapters]
        if identity_of(under)[0].built == "agrees":
            return under
    return list(chapters)


def _judged_by(track: Track, question: Question, repeated: int) -> Chapter:
    """Steps 3 to 7, by one set of figures."""
    chapter = _unjudged(track, question, repeated)
    if track.tracked < MIN_FRAMES or track.tracked == repeated:
        return chapter
    sheet = sheet_of(question)
    maps = question.as_built.place_maps if question.as_built else ()
    measured = measure(track, camera=question.camera, enrolled_maps=maps)
    measurement = measured.under(sheet.expected)
    stages = track.stages_s | measurement.stages_s
    clock = time.perf_counter()
    identity = judge_identity(track, measurement, claimed_id=question.badge_id, seal=question.seal)
    compared = _compared_built(track, measurement, identity, question)
    constant = compared.constant_room_rad if compared is not None and question.original_required else None
    stages["identity"] = time.perf_counter() - clock
    clock = time.perf_counter()
    invariant = judge(
        measurement.gratings,
        sheet,
        constant_room_rad=constant,
        code_apart=identity.rows_apart,
        page_off=identity.page_off,
        least_strength=least_strength(question),
    )
    segments = judge_segments(measurement, repeated, sheet)
    stages["invariant"] = time.perf_counter() - clock
    identity, built_reasons = _judge_built(identity, compared, invariant, question)
    signals = tuple(signal.part(slice(repeated, None)) for signal in measurement.gratings)
    return replace(
        chapter,
        invariant=invariant,
        identity=identity,
        built_reasons=built_reasons,
        segments=segments,
        signals=signals,
        stages_s=stages,
        measurement=measurement,
        judged_s=judged_spans(signals),
        sheet=sheet,
    )


def _unjudged(track: Track, question: Question, repeated: int) -> Chapter:
    """A chapter of which nothing is known but its frames."""
    times, identity = track.times_s, Identity("unreadable" if question.names_someone else "not_claimed", ())
    return Chapter(
        track.frames_read,
        track.tracked - repeated,
        (float(times[0]), float(times[-1])) if track.tracked else (0.0, 0.0),
        seen_spans(times),
        dict(track.stages_s),
        track,
        Invariant("inconclusive", (_badge_absent(track),)),
        replace(identity, claimed_id=question.badge_id),
    )


def invariant_of(chapters: Sequence[Chapter]) -> Invariant:
    """The motion invariant of all chapters together: their evidence added up.

    Convention: each chapter's signals have mean 0, so a drift from one chapter to the next does not count.  A chapter
        that is rejected rejects the film, and one that a rival explains far better leaves it inconclusive, so an hour
        of true motion hides no forged minute.
    """
    seen = [chapter for chapter in chapters if chapter.signals]
    if len(seen) <= 1:
        return (seen or list(chapters))[0].invariant
    together = tuple(joined(signals) for signals in zip(*(chapter.signals for chapter in seen), strict=True))
    sheet = seen[0].sheet
    each = [chapter.identity.rows_apart for chapter in seen]
    film, coherent = np.sqrt(np.mean(np.square([(one.film, one.coherent) for one in each]), axis=0))
    apart = RowsApart(float(film), max(one.second for one in each), float(coherent))
    compared = [chapter.invariant.compared for chapter in seen if chapter.invariant.compared]
    off = all(chapter.identity.page_off for chapter in seen)
    whole = judge(together, sheet, code_apart=apart, page_off=off, chapters=compared)
    # Of many chapters, one is more easily the worst by chance.
    limit = MAX_RIVAL_LOG10 + math.log10(len(seen))
    doubtful = [chapter for chapter in seen if _is_doubtful(chapter)]
    several = len(doubtful) > MAX_DOUBTFUL_SHARE * len(seen)
    broken = [_broken_chapter(c) for c in seen if _is_broken(c, whole, limit) or (several and c in doubtful)]
    reasons = (*whole.reasons, *(reason for reason in broken if reason is not None))
    return replace(whole, verdict=worst(list(reasons)), reasons=reasons)


def _is_broken(chapter: Chapter, whole: Invariant, limit_log10: float) -> bool:
    """Whether a chapter is rejected or would be but for noise, page or sheet, has a gain that is surely another one
    than the film's and is not accepted by itself, or a rival explains it better than the law by more than that power of
    ten.
    """
    own = chapter.invariant
    odds = [one.log10_odds for one in own.explanations if one.log10_odds is not None]
    if own.verdict == "reject" or own.broken_but_for_noise:
        return True
    if chapter.identity.page_off and own.verdict != "accept":
        return True
    return own.gain_apart_from(whole) is not None or min(odds, default=0.0) < -limit_log10


def identity_of(chapters: Sequence[Chapter]) -> tuple[Identity, tuple[Reason, ...]]:
    """The identity of all chapters together, and the findings on the badge as built.

    The first chapter whose figures differ from those of enrolment decides; otherwise the first with another identity
    than the claimed one; otherwise the first with a readable identity, where chapters whose figures agree come first.
    A code that stays still in any chapter counts.
    """
    order = {"mismatch": 0, "match": 1, "not_claimed": 2, "unreadable": 3}

    built_order = {"differs": 0, "agrees": 1, "not_known": 2}

    def rank(chapter: Chapter) -> tuple[bool, int, bool, int]:
        built = chapter.identity.built
        unread = chapter.identity.decoded_id is None
        return built != "differs", order[chapter.identity.verdict], unread, built_order[built]

    first = min(chapters, key=rank)
    still = tuple(
        _in_chapter(chapter, reason)
        for chapter in chapters
        for reason in chapter.identity.reasons
        if chapter is not first and (reason.code, reason.level) == ("cells_move", "fail")
    )
    found = sorted({chapter.identity.decoded_id for chapter in chapters if chapter.identity.decoded_id})
    if len(found) < 2 or first.identity.verdict == "mismatch":
        return replace(first.identity, reasons=(*first.identity.reasons, *still)), first.built_reasons
    text = "The codes of different badges are read in different parts of the film."
    several = Reason("identities", "fail", ", ".join(found), None, "", text)
    return replace(first.identity, reasons=(*first.identity.reasons, *still, several)), first.built_reasons


def _is_doubtful(chapter: Chapter) -> bool:
    """Whether a chapter with enough motion is inconclusive."""
    return chapter.invariant.verdict == "inconclusive" and any(one.moved for one in chapter.invariant.compared)


def _broken_chapter(chapter: Chapter) -> Reason | None:
    """The most serious finding of a chapter, with its time; None if none fails or is undecided."""
    order: dict[Level, int] = {"fail": 0, "undecided": 1, "pass": 2, "note": 2}
    why = min(chapter.invariant.reasons, key=lambda reason: order[reason.level])
    if order[why.level] > 1:
        return None
    return _in_chapter(chapter, why)


def _in_chapter(chapter: Chapter, reason: Reason) -> Reason:
    """A finding with its chapter's time."""
    start, end = chapter.span_s
    return replace(reason, text=f"Between {start:.0f} and {end:.0f} s: {reason.text}")


def _compared_built(
    track: Track, measurement: Measurement, identity: Identity, question: Question
) -> Comparison | None:
    """The film's figures compared with those of enrolment; None if there are none, or another badge is shown."""
    gain = gain_of(measurement.gratings)
    if question.as_built is None or identity.verdict != "match" or gain is None:
        return None
    expected = sheet_of(question).expected
    filmed, moved = filmed_built(track, measurement, expected * gain[0], expected * gain[1])
    return compare_built(filmed, question.as_built, track.badge, moved)


def _judge_built(
    identity: Identity, compared: Comparison | None, invariant: Invariant, question: Question
) -> tuple[Identity, tuple[Reason, ...]]:
    """The identity with the result for the badge as built, and the findings on that.

    Convention: if the law does not explain the fringes, their constants are no figures of a badge.
    """
    as_built = question.as_built
    if as_built is not None:
        identity = replace(identity, expected_beat_period_mm=as_built.beat_period_mm)
    reasons: tuple[Reason, ...] = ()
    if compared is not None and invariant.law_fits:
        identity = replace(identity, built=compared.built, built_since=question.as_built_at)
        reasons = compared.reasons
        if question.replaced_at is not None and compared.built == "agrees":
            reasons = (*reasons, _by_earlier(question))
    if not question.original_required or identity.verdict != "match":
        return identity, reasons
    level: Level = "pass" if identity.built == "agrees" else "fail" if identity.built == "differs" else "undecided"
    text = {
        "agrees": "The figures of this film are those measured at enrolment; a badge that was built anew has others.",
        "differs": "The figures of this film are not those measured at enrolment, as of a copy that was built anew.",
    }.get(identity.built, FIGURES_NOT_SHOWN)
    if as_built is not None and as_built.witnessed:
        text += " Those of enrolment were seen in a live check, whose prompts the badge followed."
    return identity, (*reasons, Reason("built", level, identity.built, "agrees", "", text))


def _by_earlier(question: Question) -> Reason:
    since, until = (str(at)[:10] for at in (question.as_built_at, question.replaced_at))
    text = (
        f"The figures of this film are those on record since {since}. Others took their place on {until}; those of "
        "before still count, as a film's own date proves nothing."
    )
    return Reason("as_built_earlier", "note", since, until, "", text)


def _badge_absent(track: Track) -> Reason:
    text = f"Of {track.frames_read} frames, {track.tracked or 'none'} show the badge; {MIN_FRAMES} are needed. "
    if track.tracked and track.frames_read < MIN_FRAMES:
        text += "Film for longer: ten seconds, say."
    else:
        text += "Film the whole badge with its four corner markers or its frame, from nearer or in better light."
    return Reason("badge_absent", "undecided", float(track.tracked), float(MIN_FRAMES), "frames", text)
