"""One badge of a film: its track, judged chapter by chapter, and its rank among the badges in view.

Policy: with a claim, the verdict is about one badge that carries the claimed identity; without a claim, or if no badge
carries it, about the badge that is shown largest.  If several carry the claimed identity, a rejected one counts first.
But anyone can move a copy next to a true badge: where one of the same identity passes, and was judged whenever a
rejected one was, the film is inconclusive.  So a true badge excuses no forged one, and a copy rejects no true one.
A note names the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from typing import Any

from moireid.question import Question
from moireid.verifier.measuring import SPELL_S
from moireid.verifier.reasons import Reason, Verdict, json_number, worst
from moireid.verifier.session.chapters import (
    PIECE_FRAMES,
    Chapter,
    by_figures_that_agree,
    identity_of,
    invariant_of,
    judge_chapter,
    judge_marked,
)
from moireid.verifier.session.threads import return_freed_memory
from moireid.verifier.timeline import Span, outside
from moireid.verifier.tracking.badge_tracker import BadgeTracker
from moireid.verifier.tracking.track import Track

#: Of several badges with the claimed identity, a rejected one counts first, then an accepted, then an inconclusive one.
ORDER = {"reject": 0, "accept": 1, "inconclusive": 2}
#: A note names at most this many identities.
MOST_NAMED = 4


@dataclass(frozen=True)
class BrokenBadge:
    """A badge that does not pass by itself.

    read: the identities that were read on it; judged_s: when it was judged, s; region: as `ChapterTracker.region`;
    rejected: whether it is by itself, and not only inconclusive as the law does not explain its fringes.
    """

    read: frozenset[str]
    judged_s: tuple[Span, ...]
    region: dict[str, Any] | None
    rejected: bool = True

    def apart_s(self, judged: Sequence[Span]) -> list[Span]:
        """The parts of its time that are outside those spans, s."""
        return [part for span in self.judged_s for part in outside(span, judged)]


@dataclass(eq=False)
class ChapterTracker:
    """A tracker and its judged chapters; the next chapter begins with `repeated` frames of the last one.

    executor: judges a chapter while the film goes on; one at a time, so that memory stays bounded; marks: as
    `judge_marked`.
    """

    question: Question
    tracker: BadgeTracker
    done: list[Chapter] = field(default_factory=list)
    repeated: int = 0
    executor: Executor | None = None
    marks: Sequence[int] = b""
    _pending: Future[Chapter] | None = None
    _verdict: Verdict | None = None

    @property
    def chapters(self) -> list[Chapter]:
        """The judged chapters, by one set of figures of enrolment; waits for one that is being judged."""
        self.settle()
        return by_figures_that_agree(self.done)

    def settle(self) -> None:
        """Wait for a chapter that is being judged."""
        if self._pending is not None:
            pending, self._pending = self._pending, None
            self._take_in(pending.result())

    def close(self, keep: int = 0) -> None:
        """Judge the open chapter, once the one before it is judged; by the executor if the film goes on."""
        self.settle()
        track = self.tracker.take(keep)
        if self.executor is not None and keep:
            self._pending = self.executor.submit(_judged, track, self.question, self.repeated, self.marks)
        else:
            self._take_in(_judged(track, self.question, self.repeated, self.marks))
        self.repeated = keep

    def _take_in(self, chapter: Chapter) -> None:
        """Only the chapter that the report plots keeps its track and measurement."""
        self.done.append(chapter)
        self._verdict = None
        shown = min(self.done, key=_plot_order)
        self.done = [chapter if chapter is shown else chapter.light() for chapter in self.done]

    def end_piece(self) -> None:
        """The film's times restart: judge the open chapter if it is long enough to be one by itself."""
        if self.tracker.tracked >= PIECE_FRAMES:
            if self.tracker.tracked > self.repeated:
                self.close()
            else:
                self.tracker.take()
                self.repeated = 0

    def finish(self) -> ChapterTracker:
        """Judge what is still open; there is one chapter at least."""
        if self.tracker.frames_read or not self.chapters:
            self.close()
        return self

    def rank(self) -> tuple[bool, int, float]:
        """Sort key: the badge of least rank counts first.  Source: the policy above, on the chapters so far."""
        if all(found != self.question.id_if_read(found) for found in self.read()):
            return True, 0, -self.tracker.shown
        return False, ORDER[self.verdict], -self.tracker.shown

    @property
    def verdict(self) -> Verdict:
        """The outcome on this badge alone, by its chapters so far."""
        chapters = self.chapters
        if self._verdict is None:
            self._verdict = worst(list(reasons_of(chapters)))
        return self._verdict

    @property
    def judged_s(self) -> list[Span]:
        """When it was judged, s."""
        return [span for chapter in self.chapters for span in chapter.judged_s]

    def read(self) -> set[str]:
        """Identities that were read in any chapter, also in frames that are said to be damaged."""
        judged = [one for chapter in self.chapters for one in (chapter, chapter.claimed) if one is not None]
        return {chapter.identity.decoded_id for chapter in judged if chapter.identity.decoded_id}

    def broken(self) -> list[BrokenBadge]:
        """This badge if it is rejected, or the law does not explain its fringes, also in frames that are said to be
        damaged; one that reads no identity may be the judged one with its code hidden, while it breaks the law.
        """
        read, chapters = frozenset(self.read()), [chapter.claimed or chapter for chapter in self.chapters]
        breaking = [chapter for chapter in chapters if chapter.breaks_law]
        whole = bool(read) and self.verdict == "reject"
        if not whole and not breaking:
            return []
        spans = tuple(span for chapter in (chapters if read else breaking) for span in chapter.judged_s)
        return [BrokenBadge(read, spans, self.region, whole or not read)]

    @property
    def region(self) -> dict[str, Any] | None:
        """First frame that shows the badge, and the corners of its board there, px; None if no frame shows it.

        Convention: as `BadgeTracker.outline_px`.
        """
        corners, first = self.tracker.outline_px(), self.tracker.ends.first
        if corners is None or first is None:
            return None
        places = [[json_number(round(float(value), 1)) for value in corner] for corner in corners]
        return {"frame": first.frame, "time_s": json_number(first.time_s), "corners_px": places}


def _judged(track: Track, question: Question, repeated: int, marks: Sequence[int]) -> Chapter:
    """Judge a chapter, and return the memory that this took to the system."""
    if any(marks):
        chapter = judge_marked(track, question, repeated, marks)
    else:
        chapter = judge_chapter(track, question, repeated=repeated)
    return_freed_memory()
    return chapter


def judged_badge(lines: Sequence[ChapterTracker], broken: Sequence[BrokenBadge]) -> ChapterTracker:
    """The badge that the verdict is about.

    Parameters: broken: the rejected badges among these lines, and among those that are no longer followed.
    Convention: rejected badges that are judged for `SPELL_S` while the passing one is not may be that same badge, with
    other fringes meanwhile: they reject the film.
    Source: the policy of the module docstring.
    """
    first = min(lines, key=ChapterTracker.rank)
    if first.verdict != "reject":
        return first
    same = [one for one in broken if one.rejected and one.read & first.read()]
    for line in sorted(lines, key=lambda line: -line.tracker.shown):
        apart = sum(end - start for one in same for start, end in one.apart_s(line.judged_s))
        passes = line.verdict == "accept" and line.read() & first.read()
        if passes and apart < SPELL_S and all(one.judged_s for one in same):
            return line
    return first


def reasons_of(chapters: Sequence[Chapter]) -> tuple[Reason, ...]:
    """All findings on one badge."""
    identity, built_reasons = identity_of(chapters)
    return invariant_of(chapters).reasons + identity.reasons + built_reasons


def others_note(count: int, read: set[str], region: dict[str, Any] | None) -> tuple[Reason, ...]:
    """A note on the badges that the verdict is not about; empty if there are none."""
    if not count or region is None:
        return ()
    named = sorted(read)[:MOST_NAMED]
    which = f", reading {', '.join(named)}{' and more' if len(read) > len(named) else ''}" if named else ""
    text = (
        f"{count} more {'badge was' if count == 1 else 'badges or parts of badges were'} seen{which}. This verdict is "
        f"about one badge only: the one first seen {_place(region)}."
    )
    return (Reason("others", "note", float(count), None, "badges", text),)


def _place(region: dict[str, Any] | None) -> str:
    if region is None:
        return "nowhere"
    x, y = (sum(corner[axis] for corner in region["corners_px"]) / 4 for axis in (0, 1))
    return f"in frame {region['frame']} near ({x:.0f}, {y:.0f}) px"


def broken_findings(judged: ChapterTracker, broken: Sequence[BrokenBadge]) -> tuple[Reason, ...]:
    """Findings if another badge is rejected that has the identity of the judged one, or may be the judged one.

    Convention: a violation shorter than `SPELL_S` of a badge without identity does not count, as for the judged badge.
    """
    own = judged.region
    same = [one for one in broken if one.read & judged.read() and one.region != own]
    if same and judged.verdict != "reject":
        seconds = sum(end - start for one in same for start, end in one.judged_s)
        text = (
            f"The law does not explain the fringes of another badge of the same identity: the one first seen "
            f"{_place(same[0].region)}. The judged one, first seen {_place(own)}, is not that one. Film the badge "
            "without the other."
        )
        return (Reason("others_break", "undecided", seconds, 0.0, "s", text),)
    alone = [part for one in broken if not one.read for part in one.apart_s(judged.judged_s)]
    seconds = sum(end - start for start, end in alone)
    if seconds < SPELL_S:
        return ()
    start, end = max(alone, key=lambda span: span[1] - span[0])
    text = (
        f"Between {start:.0f} and {end:.0f} s a badge is seen whose fringes break the law and whose code cannot be "
        "read. The judged badge is not seen then, so both may be the same badge."
    )
    return (Reason("others_break", "undecided", seconds, SPELL_S, "s", text),)


def _plot_order(chapter: Chapter) -> tuple[bool, bool, int]:
    """Sort key for the chapter to plot: the law broken first, then the law obeyed, then the most frames."""
    return chapter.invariant.verdict != "reject", chapter.invariant.verdict != "accept", -chapter.tracked
