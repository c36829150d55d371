"""The overlap protocol: does the badge pass in front of the face, and does the law hold meanwhile?

A badge next to a face proves nothing about the face.  If the badge covers part of it, a forger must combine both in
every frame: a face swap must work on a partly covered face, and a pasted badge shows at its border.  So badge and
face must overlap for a while, and the fringes must obey the law in each frame of it.

1. Follow the face (`faces`) and the badges in view, and record the times at which they overlap.
2. Take the longest of these intervals of the badge that the verdict is about.
3. Check each of its frames against the law with the gain of the film, and the seconds around it if the badge moves
   enough in them.

Convention: the overlap in a frame is the common area of badge and face box, divided by the smaller of the two.
Source: the second mitigation of Qing et al. (2026): overlap of badge and face.
"""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakKeyDictionary

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.verifier.decision.figures import figures_of
from moireid.verifier.decision.judge import judge
from moireid.verifier.decision.sheet_gain import SheetGain
from moireid.verifier.explanations.residuals import residual_limit_rad
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MIN_EXCITATION_RAD, SEGMENT_S, WINDOW_FRAMES
from moireid.verifier.measuring import MIN_AGREEING_SHARE, MIN_OVERLAP_S, MIN_OVERLAP_SHARE, MIN_READ_SHARE
from moireid.verifier.picture import Frame
from moireid.verifier.reasons import Level, Reason
from moireid.verifier.session.chapters import Chapter
from moireid.verifier.session.faces import Box, FaceFollower
from moireid.verifier.session.result import Overlap
from moireid.verifier.timeline import Spans
from moireid.verifier.tracking.badge_tracker import BadgeTracker

Array = NDArray[np.float64]


class OverlapWatch:
    """Records when the face was seen and when each badge covered it; memory grows with the number of intervals.

    Raises: MissingExtraError where dlib is not installed.
    """

    def __init__(self) -> None:
        self._follower = FaceFollower()
        self._faces = Spans()
        # When a lost badge is dropped, its times go with it.
        self._overlaps: WeakKeyDictionary[BadgeTracker, Spans] = WeakKeyDictionary()
        self.face: Box | None = None
        #: Badges that overlap the face in the present frame.
        self.over: list[BadgeTracker] = []

    def push(self, frame: Frame, in_view: Sequence[tuple[BadgeTracker, Array]]) -> None:
        """Take a frame.  in_view: the badges seen in it, with the corners (4, 2) px of their boards."""
        self.face = self._follower.follow(frame.luma, frame.time_s, hidden=bool(self.over))
        self.over = []
        if self.face is None:
            return
        self._faces.add(frame.time_s)
        for tracker, corners in in_view:
            if overlap_share(corners, self.face) >= MIN_OVERLAP_SHARE:
                self.over.append(tracker)
                self._overlaps.setdefault(tracker, Spans()).add(frame.time_s)

    def judge(self, tracker: BadgeTracker, chapters: Sequence[Chapter]) -> Overlap:
        """The outcome of the protocol for one badge and its judged chapters."""
        overlaps = self._overlaps.get(tracker) or Spans()
        if not self._follower.seen:
            return Overlap((_no_face(self._follower.looks),), self._faces, overlaps)
        long_enough = _long_enough(overlaps)
        if long_enough.level != "pass":
            return Overlap((long_enough,), self._faces, overlaps)
        assert overlaps.longest is not None
        reason, agreeing = law_through(overlaps.longest, chapters)
        return Overlap((long_enough, reason), self._faces, overlaps, agreeing)


def overlap_share(corners: Array, face: Box) -> float:
    """Common area of a badge (corners (4, 2) px, convex) and a face, over the smaller area; 0 to 1.

    Source: OpenCV's intersection of convex polygons.
    """
    x0, y0, x1, y1 = face
    box = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], np.float32)
    board = corners.astype(np.float32)
    if not cv2.isContourConvex(board):
        return 0.0
    shared, _ = cv2.intersectConvexConvex(board, box)
    smaller = min(abs(cv2.contourArea(board)), abs(cv2.contourArea(box)))
    return float(shared / smaller) if smaller > 0 else 0.0


def law_through(interval_s: tuple[float, float], chapters: Sequence[Chapter]) -> tuple[Reason, float | None]:
    """Whether the law holds in an interval: in each frame, and over the seconds around it if there is enough motion.

    Convention: a frame agrees if every grating with a readable phase does; each grating has the gain and offset of its
        chapter, so an interval with still fringes, or with those of another badge, deviates.
    Returns: the finding, and the share of the readable frames that agree (None if none is readable).
    """
    frames, readable, agreeing = 0, 0, 0
    broken: Reason | None = None
    for chapter in chapters:
        times = chapter.signals[0].times_s if chapter.signals else np.zeros(0)
        own = (times >= interval_s[0]) & (times <= interval_s[1])
        if not own.any():
            continue
        knows, holds = np.array([_held(signal, own, chapter.sheet) for signal in chapter.signals]).swapaxes(0, 1)
        known = knows.any(axis=0)
        frames, readable = frames + int(own.sum()), readable + int(known.sum())
        agreeing += int((known & (holds | ~knows).all(axis=0)).sum())
        broken = broken or _broken(chapter, times, interval_s)
    share = agreeing / readable if readable else None
    return (broken if broken is not None else _agreement(frames, readable, share)), share


def _held(signal: GratingSignal, own: NDArray[np.bool_], sheet: SheetGain) -> NDArray[np.bool_]:
    """For each frame of the interval (mask `own`): is the phase readable, and does it agree with the law? (2, N)."""
    figures = figures_of(signal)
    # The measured gain, limited to what builds and lenses can give; in a film that hardly moves it is noise.
    gain = 1.0
    if figures.excitation_rad >= MIN_EXCITATION_RAD:
        gain = float(np.clip(figures.gain_ratio, *sheet.possible(signal.lens_room)))
    law_rad = gain * signal.predicted_rad + figures.air_share * signal.air_rad
    deviation = np.abs(signal.measured_rad - law_rad)[own]
    sd = signal.phase_sd_rad[own]
    error = np.hypot(np.where(np.isfinite(sd), sd, 0.0), signal.pose_sd_rad)
    limit = [3 * residual_limit_rad(float(one)) for one in error]
    return np.array([np.isfinite(sd), deviation <= limit])


def _broken(chapter: Chapter, times: Array, interval_s: tuple[float, float]) -> Reason | None:
    """The finding if the seconds around the interval break the law by themselves, or move otherwise than the film;
    otherwise None.
    """
    middle, half = sum(interval_s) / 2, max(interval_s[1] - interval_s[0], SEGMENT_S) / 2
    around = np.flatnonzero(np.abs(times - middle) <= half)
    if len(around) < WINDOW_FRAMES:
        return None
    judged = judge([signal.part(around) for signal in chapter.signals], chapter.sheet, whole=False)
    failing = [reason for reason in judged.reasons if reason.level == "fail"]
    if judged.broken_but_for_noise:
        failing += [one for one in judged.reasons if one.code in ("parts", "residual") and one.level == "undecided"]
    if failing:
        why = failing[0]
        text = f"While the badge is before the face, its fringes do not follow the optics: {why.text}"
        return Reason("overlap_law", why.level, why.measured, why.limit, why.unit, text)
    why = judged.gain_apart_from(chapter.invariant)  # type: ignore[assignment]
    if why is None:
        return None
    text = f"While the badge is before the face, its fringes move otherwise than in the rest of the film: {why.text}"
    return Reason("overlap_law", "undecided", why.measured, why.limit, why.unit, text)


def _agreement(frames: int, readable: int, share: float | None) -> Reason:
    if share is None or readable < MIN_READ_SHARE * frames:
        text = (
            f"While the badge is before the face, its fringes can be read in {readable} of {frames} frames only; keep "
            "its markers in view and free of fingers."
        )
        return Reason("overlap_law", "undecided", readable / max(frames, 1), MIN_READ_SHARE, "share", text)
    level: Level = "pass" if share >= MIN_AGREEING_SHARE else "fail"
    text = (
        f"While the badge is before the face, its fringes follow the optics in {share:.0%} of {readable} frames; "
        f"{MIN_AGREEING_SHARE:.0%} are needed."
    )
    return Reason("overlap_law", level, share, MIN_AGREEING_SHARE, "share", text)


def _no_face(looks: int) -> Reason:
    text = (
        f"No face was found in the {looks} frames that were searched; show the face from the front, well lit and at "
        "least an eighth of the picture wide."
    )
    return Reason("face", "undecided", 0.0, 1.0, "faces", text)


def _long_enough(overlaps: Spans) -> Reason:
    longest = overlaps.longest
    seconds = longest[1] - longest[0] if longest else 0.0
    if seconds >= MIN_OVERLAP_S:
        text = f"The badge is before the face for {seconds:.1f} s without a break; {MIN_OVERLAP_S:g} s are needed."
        return Reason("overlap", "pass", seconds, MIN_OVERLAP_S, "s", text)
    text = (
        f"The badge is before the face for {seconds:.1f} s at most; {MIN_OVERLAP_S:g} s are needed. Hold it so that it "
        "covers a quarter of the face, with all four markers, or its frame, in view, while it moves."
    )
    return Reason("overlap", "undecided", seconds, MIN_OVERLAP_S, "s", text)
