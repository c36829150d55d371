"""Frames in, verdict out: `verifier.verify` without a file, for benches that skip, shrink or damage frames."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from moireid.verifier.decision.judge import Invariant
from moireid.verifier.picture import Frame
from moireid.verifier.reasons import Reason, Verdict, worst
from moireid.verifier.session.chapters import Chapter, identity_of, invariant_of
from moireid.verifier.session.claim import Claim
from moireid.verifier.session.streaming import Verifier


@dataclass(frozen=True)
class JudgedFrames:
    """The verdict on some frames with all that it rests on."""

    verdict: Verdict
    reasons: tuple[Reason, ...]
    invariant: Invariant
    decoded_id: str | None
    chapters: tuple[Chapter, ...]

    @property
    def tracked(self) -> int:
        """Frames in which the badge was followed."""
        return sum(chapter.tracked for chapter in self.chapters)

    @property
    def read(self) -> int:
        """Frames that were pushed."""
        return sum(chapter.frames_read for chapter in self.chapters)

    @property
    def why(self) -> list[Reason]:
        """The findings that keep the film from being accepted, failures first."""
        found = [reason for reason in self.reasons if reason.level in ("fail", "undecided")]
        return sorted(found, key=lambda reason: reason.level != "fail")

    @property
    def finite(self) -> bool:
        """Whether no figure of the motion is NaN or infinite; what was not measured is None, and finite."""
        motion = self.invariant
        figures = (
            motion.correlation,
            motion.window_correlation_mean,
            motion.gain_ratio,
            motion.gain_sd,
            motion.phase_residual_rad,
            motion.excitation_rad,
            motion.score,
        )
        found = [*figures, *(reason.measured for reason in self.reasons), *(reason.limit for reason in self.reasons)]
        return all(math.isfinite(value) for value in found if isinstance(value, float))


def judge_frames(frames: Iterable[Frame], claim: Claim) -> JudgedFrames:
    """Steps 2 to 8 of `verifier.verify` on frames that are already there."""
    verifier = Verifier(claim, running=False)
    for frame in frames:
        verifier.push(frame)
    chapters = verifier.finish()
    invariant = invariant_of(chapters)
    identity, built_reasons = identity_of(chapters)
    reasons = invariant.reasons + identity.reasons + built_reasons
    return JudgedFrames(worst(list(reasons)), reasons, invariant, identity.decoded_id, tuple(chapters))
