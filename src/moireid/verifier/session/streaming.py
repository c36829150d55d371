"""Verification frame by frame: a running verdict for live video, and the final one at the end.

Each pushed frame is tracked at once.  About every second the last few seconds are judged.  This running verdict is
*causal*: it uses past frames only.  `finish` judges the chapter that is still open.  Its verdict is the verdict of the
film; it may differ from the running one.
If several badges are in view, each is judged by itself, and the verdict is about one of them (`judged_badge`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from moireid.question import CheckLevel, KnownCamera, Question
from moireid.verifier.limits import MIN_FRAMES, WINDOW_FRAMES
from moireid.verifier.measuring import FOCAL_KEPT_SHARE, MAX_UNSEARCHED_S
from moireid.verifier.picture import Frame
from moireid.verifier.reasons import Reason, Verdict, worst
from moireid.verifier.session.badge_session import (
    BrokenBadge,
    ChapterTracker,
    broken_findings,
    judged_badge,
    others_note,
    reasons_of,
)
from moireid.verifier.session.chapters import CHAPTER_FRAMES, OVERLAP_FRAMES, Chapter, judge_chapter
from moireid.verifier.session.cover import Cover, cover_of
from moireid.verifier.timeline import FilmTime, restart_findings
from moireid.verifier.tracking.badge_tracker import BadgeTracker
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.tracking.track import Track

#: The running verdict uses this many of the last tracked frames, and is renewed after this time.
RUNNING_FRAMES, RUNNING_S = 240, 1.0


@dataclass(frozen=True)
class Running:
    """A verdict on the last seconds of a film or a live picture.

    Attributes
    ----------
    time_s : float
        Time of the frame at which it was made, s.
    span_s : (float, float)
        Times of the first and the last frame that it is based on, s.
    verdict : {"accept", "reject", "inconclusive"}
        The outcome on those seconds alone.
    reasons : tuple of Reason
        Findings with measured value, limit and unit.
    tracked : int
        Frames of those seconds that show the badge.

    Notes
    -----
    Convention: it uses no later frame, and is not the verdict of the film.
    Source: judged in the same way as a chapter of a film.
    """

    time_s: float
    span_s: tuple[float, float]
    verdict: Verdict
    reasons: tuple[Reason, ...]
    tracked: int


class Verifier:
    """Take a film frame by frame; memory does not grow with its length.

    Notes
    -----
    Convention: each badge in view is judged by itself; the verdict is about one of them (`judged_badge`).
    Source: `moireid.verifier.session.chapters`.
    """

    def __init__(
        self,
        question: Question,
        *,
        running: bool = True,
        aside: Executor | None = None,
        marks: Sequence[int] = b"",
    ) -> None:
        """Begin a film.

        Parameters
        ----------
        question : Question
            What the film is checked against.
        running : bool
            Make running verdicts; they are not needed for a film that is judged at its end.
        aside : Executor, optional
            Judges while `push` goes on, so that a camera's frames need not wait half a second (`threads`): chapters,
            with the same results, and running verdicts, one at a time, which a later `push` returns.
        marks : sequence of int
            Which frames are damaged, by their index, as `DamageWatch.marks`; it grows while frames are pushed.

        Raises
        ------
        SpecError
            If the badge cannot be read at all.
        """
        self._aside = aside
        self._pending: Future[Running] | None = None
        self._begun = 0.0
        self._question, self._running = question, running
        self._times = FilmTime()
        self._first_s, self._pushed = math.inf, 0
        #: Time of the last frame, on a clock that never goes back.
        self.now_s = 0.0
        self._view = SceneTracker(question.badge)
        self._marks = marks
        self._lines = [self._new_line(self._view.trackers[0])]
        #: Lost badges: their number, the identities that were read on them, those that were rejected, and of all of
        #: them the one of least rank and the largest that passes.
        self._gone, self._gone_read = 0, set[str]()
        self._gone_broken: list[BrokenBadge] = []
        self._kept: list[ChapterTracker] = []
        self._due_s: float | None = None
        self._camera, self._focal_frames = question.camera, 0

    @property
    def judged(self) -> ChapterTracker:
        """The badge that the verdict is about, as far as it is judged by now."""
        if not self._kept and len(self._lines) == 1:
            # Its rank would wait for a chapter that is being judged.
            return self._lines[0]
        return judged_badge([*self._lines, *self._kept], self._broken)

    @property
    def _broken(self) -> list[BrokenBadge]:
        """The rejected badges, as far as they are judged by now."""
        return [*self._gone_broken, *(one for line in self._lines for one in line.broken())]

    @property
    def chapters(self) -> list[Chapter]:
        """The chapters of that badge that are judged by now."""
        return self.judged.chapters

    @property
    def in_view(self) -> list[tuple[BadgeTracker, NDArray[np.float64]]]:
        """The badges seen in the last frame, and their boards' corners (4, 2) px, as `BadgeTracker.corners_px`."""
        trackers = [line.tracker for line in self._lines]
        return [(one, one.corners_px(one.place)) for one in trackers if one.place is not None]

    @property
    def unsearched(self) -> int:
        """Frames in which a badge was due to be looked for, and the whole picture was not searched."""
        return self._view.unsearched

    @property
    def others(self) -> tuple[Reason, ...]:
        """Findings on the badges that the verdict is not about, if there are any."""
        judged = self.judged
        others = [line for line in self._lines if line is not judged and line.tracker.ends.first is not None]
        read = set[str]().union(self._gone_read, *(line.read() for line in others))
        count = len(others) + self._gone - (judged in self._kept)
        note = others_note(count, read, judged.region)
        return note + broken_findings(judged, self._broken)

    @property
    def cover(self) -> Cover:
        """How much of the film so far the chapters of the judged badge cover."""
        if not self._pushed:
            return Cover(0.0, (), 0.0)
        chapters = self.chapters
        judged = [span for chapter in chapters for span in chapter.judged_s]
        seen = [span for chapter in chapters for span in chapter.seen_s]
        tracked = sum(chapter.tracked for chapter in chapters)
        return cover_of(judged, self._first_s, self.now_s, self._pushed, seen, tracked)

    @property
    def long_unsearched(self) -> tuple[Reason, ...]:
        """A finding if no badge was followed or searched for so long that one may have been missed."""
        longest_s = self._view.unsearched_s
        if longest_s <= MAX_UNSEARCHED_S:
            return ()
        text = (
            f"For {longest_s:.1f} s in a row the badge was not searched, as so much in the picture looks like markers "
            "that a search takes longer than decoding. What the badge did then is not known."
        )
        return (Reason("unsearched", "undecided", longest_s, MAX_UNSEARCHED_S, "s", text),)

    @property
    def restarts(self) -> tuple[Reason, ...]:
        """Findings on times that start anew, if they do."""
        unjudged = sum(chapter.tracked for chapter in self.chapters if not chapter.signals)
        return restart_findings(self._times.restarts, unjudged, WINDOW_FRAMES)

    def push(self, frame: Frame) -> Running | None:
        """Take in the next frame.

        Parameters
        ----------
        frame : Frame
            Frames come in order, with times in seconds.

        Returns
        -------
        Running or None
            A running verdict if one is due, about once a second of the film.  With `aside` less often if one takes
            longer than that, so that judging takes at most half of a processor.

        Raises
        ------
        SpecError
            If a time is not finite.

        Notes
        -----
        Convention: if the times start anew, a chapter ends (`PIECE_FRAMES`), and the times are shifted so that they
        rise (`FilmTime`).
        """
        self.now_s, restarted = self._times.place(frame.time_s)
        self._first_s = min(self._first_s, self.now_s)
        self._pushed += 1
        frame = frame.at(self.now_s)
        if restarted:
            for line in self._lines:
                line.end_piece()
        self._view.push(frame)
        self._renew_lines()
        for line in self._lines:
            if line.tracker.tracked >= CHAPTER_FRAMES:
                line.close(OVERLAP_FRAMES)
        if not self._running:
            return None
        if self._due_s is None:
            self._due_s = frame.time_s + RUNNING_S
        done = self._pending if self._pending is not None and self._pending.done() else None
        if done is not None:
            # A slow machine waits as long as the last verdict took, so that time is left for the frames.
            self._due_s = max(self._due_s, frame.time_s + time.perf_counter() - self._begun)
            self._pending = None
        if frame.time_s >= self._due_s and self._pending is None:
            self._due_s = frame.time_s + RUNNING_S
            looks = self._looks()
            if self._aside is None:
                return self._judge_last(looks, frame.time_s)
            self._begun = time.perf_counter()
            self._pending = self._aside.submit(self._judge_last, looks, frame.time_s)
        return done.result() if done is not None else None

    def finish(self) -> list[Chapter]:
        """Judge what is still open.

        Returns
        -------
        list of Chapter
            All chapters of the badge that the verdict is about, at least one.

        Notes
        -----
        Convention: the chapter that the report plots keeps its track.
        """
        if self._pending is not None:
            self._pending.cancel()
        for line in self._lines:
            line.finish()
        return self.chapters

    def _renew_lines(self) -> None:
        """Judge the badges that were lost, and keep what may count of them; add the badges that are new."""
        for tracker in self._view.given_up:
            line = next(line for line in self._lines if line.tracker is tracker).finish()
            self._lines.remove(line)
            self._gone_broken += line.broken()
            self._gone, self._gone_read = self._gone + 1, self._gone_read | set(sorted(line.read())[:1])
            kept = sorted([line, *self._kept], key=ChapterTracker.rank)
            passing = sorted((one for one in kept if one.verdict == "accept"), key=lambda one: -one.tracker.shown)
            self._kept = list(dict.fromkeys((*kept[:1], *passing[:1])))
        self._view.given_up.clear()
        for tracker in self._view.trackers[len(self._lines) :]:
            self._lines.append(self._new_line(tracker))

    def _new_line(self, tracker: BadgeTracker) -> ChapterTracker:
        return ChapterTracker(self._question, tracker, executor=self._aside, marks=self._marks)

    def _looks(self) -> list[tuple[ChapterTracker, Track]]:
        """The last frames of the badges that are in view now."""
        lines = [line for line in self._lines if line.tracker.place is not None] or [self.judged]
        # The largest first: the focal length is estimated on it.
        lines.sort(key=lambda line: -line.tracker.shown)
        return [(line, line.tracker.look(RUNNING_FRAMES)) for line in lines]

    def _judge_last(self, tracks: list[tuple[ChapterTracker, Track]], now_s: float) -> Running:
        """The verdict on the last seconds."""
        # As in `verify`.
        with threadpool_limits(limits=1, user_api="blas"):
            chapters = [(line, self._judged_now(track)) for line, track in tracks if track.tracked >= MIN_FRAMES]
        if not chapters:
            most = max(track.tracked for _, track in tracks)
            text = (
                "The badge was not in view long enough yet; show it to the camera with its four corner markers or its "
                "frame."
            )
            reason = Reason("badge_absent", "undecided", float(most), float(MIN_FRAMES), "frames", text)
            return Running(now_s, (now_s, now_s), "inconclusive", (reason,), most)
        lines = [ChapterTracker(self._question, line.tracker, [chapter]) for line, chapter in chapters]
        broken = [one for line in lines for one in line.broken()]
        judged = judged_badge(lines, broken)
        read = set[str]().union(*(line.read() for line in lines if line is not judged))
        note = others_note(len(tracks) - 1, read, judged.region)
        (chapter,) = judged.done
        reasons = reasons_of([chapter]) + note + broken_findings(judged, broken)
        return Running(now_s, chapter.span_s, worst(list(reasons)), reasons, chapter.tracked)

    def _judged_now(self, track: Track) -> Chapter:
        # Estimating the focal length is half of the work, so it is repeated only when there are twice as many frames.
        anew = self._question.camera is None and track.tracked >= 2 * self._focal_frames
        camera = None if anew else self._camera
        # A few seconds mostly do not show the figures of enrolment; unless asked for, only the end checks them.
        level: CheckLevel = "enrolled" if self._question.level == "enrolled" else "record"
        asked = replace(self._question, camera=camera, level=level, earlier=())
        chapter = judge_chapter(track, asked)
        if anew and chapter.measurement is not None and max(chapter.measurement.camera.tangent_sd) < FOCAL_KEPT_SHARE:
            self._camera, self._focal_frames = KnownCamera(chapter.measurement.camera.focal_px), track.tracked
        return chapter
