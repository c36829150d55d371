"""Verifying as frames come: a running verdict for live video, and the final one at the end.

Each pushed frame is followed at once.  About every second the last seconds are judged: that verdict is *causal*, it
knows nothing of what comes.  `finish` judges the chapter that is still open with all that it holds; it may refine what
the running verdict said, and it alone is the verdict of the film.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from moireid.verifier.chapters import CHAPTER_FRAMES, MIN_FRAMES, OVERLAP_FRAMES, Chapter, Claim, judge_chapter
from moireid.verifier.reasons import Reason, Verdict, worst
from moireid.verifier.track import BadgeTracker
from moireid.verifier.video import Frame

#: The running verdict is of so many of the last tracked frames, made anew after so much of the film.
RUNNING_FRAMES, RUNNING_S = 240, 1.0
#: A focal length is kept once it errs by so little, as a share of the motion: a kept one has no error bar, and that of
#: a badge that was held still at first is a guess, by which all that follows would look forged.
SURE_FOCAL = 0.03


@dataclass(frozen=True)
class Running:
    """A verdict on the last seconds: causal, and not the film's.

    time_s: of the frame that it was made at; span_s: first and last frame that it rests on.
    """

    time_s: float
    span_s: tuple[float, float]
    verdict: Verdict
    reasons: tuple[Reason, ...]
    tracked: int


class Verifier:
    """Takes a film frame by frame; memory does not grow with its length."""

    def __init__(self, claim: Claim, *, running: bool = True) -> None:
        """Parameters: running: make running verdicts; a film that is judged at its end can leave them out.

        Raises: SpecError where the badge cannot be read at all.
        """
        self._claim, self._running = claim, running
        self._tracker = BadgeTracker(claim.badge)
        self.chapters: list[Chapter] = []
        self._due_s: float | None = None
        self._focal_px, self._focal_frames = claim.focal_px, 0
        self._repeated = 0

    def push(self, frame: Frame) -> Running | None:
        """Take in the next frame; a running verdict where one is due.

        Convention: frames in order, times rising.
        """
        self._tracker.push(frame)
        if self._tracker.tracked >= CHAPTER_FRAMES:
            self._close(OVERLAP_FRAMES)
        if not self._running:
            return None
        if self._due_s is None:
            self._due_s = frame.time_s + RUNNING_S
        if frame.time_s < self._due_s:
            return None
        self._due_s = frame.time_s + RUNNING_S
        return self._judge_last(frame.time_s)

    def finish(self) -> list[Chapter]:
        """Judge what is still open; all chapters, at least one.  The first that shows most keeps its track."""
        if self._tracker.frames_read or not self.chapters:
            self._close(0)
        return self.chapters

    def _close(self, keep: int) -> None:
        """Judge the open chapter; only the chapter that is worth a picture keeps what a picture needs."""
        self.chapters.append(judge_chapter(self._tracker.take(keep), self._claim, repeated=self._repeated))
        self._repeated = keep
        shown = min(self.chapters, key=_telling)
        self.chapters = [chapter if chapter is shown else chapter.light() for chapter in self.chapters]

    def _judge_last(self, now_s: float) -> Running:
        track = self._tracker.look(RUNNING_FRAMES)
        if track.tracked < MIN_FRAMES:
            text = "The badge is not seen long enough yet; hold it, with its four corner markers, before the camera."
            reason = Reason("badge_absent", "undecided", float(track.tracked), float(MIN_FRAMES), "frames", text)
            return Running(now_s, (now_s, now_s), "inconclusive", (reason,), track.tracked)
        # Solving for the focal length is half of the work, so what it was is kept until there is twice as much to
        # solve it on.
        anew = self._claim.focal_px is None and track.tracked >= 2 * self._focal_frames
        focal_px = None if anew else self._focal_px
        chapter = judge_chapter(track, replace(self._claim, focal_px=focal_px))
        if anew and chapter.measurement is not None and max(chapter.measurement.camera.tangent_sd) < SURE_FOCAL:
            self._focal_px, self._focal_frames = chapter.measurement.camera.focal_px, track.tracked
        reasons = chapter.invariant.reasons + chapter.identity.reasons + chapter.built_reasons
        return Running(now_s, chapter.span_s, worst(list(reasons)), reasons, track.tracked)


def _telling(chapter: Chapter) -> tuple[bool, bool, int]:
    """Order of chapters by what their plots would show: a broken law first, then the law kept, then most frames."""
    return chapter.invariant.verdict != "reject", chapter.invariant.verdict != "accept", -chapter.tracked
