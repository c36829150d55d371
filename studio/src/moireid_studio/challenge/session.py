"""A live check: frames with their times in, events out.  Camera, network and threads belong to the caller.

1. Place each frame on our own clock (`clock`).
2. Push it to the verifier, whose running verdict is an event; follow the face (`overlap`).
3. If a challenge was requested: begin it once badge and face are seen, with a new verifier; show each prompt when it is
due, and judge it when its time is over (`challenge`).
4. At the end, judge invariant, identity, overlap, prompts and clock together, all on the same frames.

In a call (`clock.Pace`) each prompt waits for the answer to the last one and for the badge to rest, and the call's tile
is looked at, too (`chance.TileWatch`).

Convention: events are JSON objects with a key "event": status, prompt, prompted, challenge, verdict.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.question import Question
from moireid.verifier.picture import Frame, Picture, as_picture
from moireid.verifier.reasons import Reason, worst
from moireid.verifier.session.chapters import Chapter, identity_of, invariant_of
from moireid.verifier.session.check_level import level_finding, level_reached
from moireid.verifier.session.claim import claim_reasons
from moireid.verifier.session.overlap import OverlapWatch
from moireid.verifier.session.streaming import Running, Verifier
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid_studio.challenge.challenge import (
    ALOUD,
    BEGUN,
    FACE,
    MIN_FRAMES,
    REST_S,
    WORDS,
    Prompt,
    PromptPath,
    draw_prompts,
    judge_challenge,
    judge_delay,
    judge_prompt,
    judge_unbroken,
    over_s,
    place_of,
)
from moireid_studio.challenge.chance import TileWatch, likeliest_chance
from moireid_studio.challenge.clock import CALL_SLACK_S, HERE, MOST_LATE, REST_WAIT_S, BoundedClock, Pace
from moireid_studio.challenge.witnessed import witnessed_figures

Event = dict[str, Any]
Draw = Callable[[float], list[Prompt]]
#: Least time between seeing badge and face and the first prompt.
READY_S = 1.5
#: A challenge that has not begun or ended after this time is given up.
WAIT_S = 60.0


class LiveCheck:
    """One session of one person before a camera.  Memory: the challenge's track, 40 bytes per frame for a minute."""

    def __init__(
        self,
        claim: Question,
        *,
        draw: Draw = draw_prompts,
        pace: Pace = HERE,
        now: Callable[[], float] = time.monotonic,
        aside: Executor | None = None,
        clock: BoundedClock | None = None,
        watch: OverlapWatch | None = None,
        required: bool = False,
    ) -> None:
        """Begin a session in which nothing was seen yet.

        Parameters
        ----------
        draw
            Makes the prompts of a challenge from its earliest start.
        now
            Our clock; both are replaced in tests only.
        pace
            Whether it is a call.
        aside
            As in `Verifier`.
        clock, watch
            None for a `BoundedClock` and an `OverlapWatch`.
        required
            Without a challenge the verdict is inconclusive.

        Raises
        ------
        SpecError
            If the badge cannot be read.
        MissingExtraError
            Without the face detector.
        """
        self._claim, self._draw, self._now, self._pace = claim, draw, now, pace
        self._middle_mm = marker_corners_mm(claim.badge.markers).mean(axis=(0, 1))
        self._clock = clock or (BoundedClock(CALL_SLACK_S) if pace.in_call else BoundedClock())
        self._watch = watch or OverlapWatch()
        self._tile = TileWatch() if pace.in_call else None
        self._aside, self._required = aside, required
        self._verifier = Verifier(claim, aside=aside)
        self._index = 0
        self._asked_s: float | None = None
        self._prompts: list[Prompt] | None = None
        self._shown = self._judged = 0
        self._frames_s: list[float] = []
        self._times: list[float] = []
        self._places: list[NDArray[np.float64]] = []
        self._before_face: list[bool] = []
        self.ended = False

    def ask(self, now_s: float) -> None:
        """Request a challenge; it begins when badge and face are seen.  A second request changes nothing."""
        if self._asked_s is None:
            self._asked_s = now_s

    def push(self, luma: NDArray[np.uint8] | Picture, claimed_s: float, arrival_s: float) -> list[Event]:
        """Take a picture; returns the events that it causes.

        Parameters
        ----------
        claimed_s, arrival_s
            As `BoundedClock.place`.
        """
        if self._tile is not None and self._tile.repeated(as_picture(luma).whole, arrival_s):
            return []
        time_s = self._clock.place(claimed_s, arrival_s)
        if time_s is None or self.ended:
            return []
        frame = Frame(self._index, time_s, luma)
        self._index += 1
        running = self._verifier.push(frame)
        self._watch.push(frame, self._verifier.in_view)
        if self._tile is not None:
            self._tile.push(frame)
        events = [self._status(running)] if running else []
        return events + self._challenged(frame)

    def moved(self) -> Event:
        """End the session as `finish`, because a call's tile is not where it was, or as large: who is in it now?"""
        if self._tile is not None:
            self._tile.moved = True
        return self.finish()

    def finish(self) -> Event:
        """End the session: the verdict on all frames, or on those of the challenge if there was one."""
        self.ended = True
        chapters = self._verifier.finish()
        identity, built_reasons = identity_of(chapters)
        invariant = invariant_of(chapters)
        reasons = invariant.reasons + identity.reasons + built_reasons + self._verifier.others
        reasons += claim_reasons(self._claim, identity)
        overlap = None
        if self._prompts is not None:
            overlap = self._watch.judge(self._verifier.judged.tracker, chapters)
            asked = self._prompts[: self._judged]
            reasons += overlap.reasons + self._judge_prompts(asked)
        reasons += (self._whole(), self._in_time()) + (self._tile.reasons() if self._tile else ())
        reasons = self._weighed(reasons, chapters)
        tracked = sum(chapter.tracked for chapter in chapters)
        challenged = self._prompts is not None
        level = level_reached(worst(list(reasons)), identity.built, challenged=challenged)
        reasons += level_finding(self._claim.level, level, identity.built)
        figures = witnessed_figures(chapters) if self._claim.enrolling and level == "live" else None
        return {
            "event": "verdict",
            "verdict": worst(list(reasons)),
            "level": level,
            "challenged": challenged,
            "in_call": self._pace.in_call,
            "reasons": [reason.to_json() for reason in reasons],
            "claim_source": self._claim.provenance.source,
            "registry": self._claim.stated()["registry"],
            "invariant": invariant.to_json(),
            "explanations": [one.to_json() for one in invariant.explanations],
            "identity": identity.to_json(),
            "overlap": overlap.to_json() if overlap else None,
            "frames": {"read": self._index, "tracked": tracked},
        } | ({} if figures is None else {"as_built": figures})

    def _weighed(self, reasons: tuple[Reason, ...], chapters: Sequence[Chapter]) -> tuple[Reason, ...]:
        """The findings as they count for this check, on which its level depends."""
        return reasons

    def _status(self, running: Running) -> Event:
        return {
            "event": "status",
            "time_s": round(running.time_s, 3),
            "verdict": running.verdict,
            "reasons": [reason.to_json() for reason in running.reasons + (self._tile.reasons() if self._tile else ())],
            "tracked": running.tracked,
            "badge": bool(self._verifier.in_view),
            "face": self._watch.face is not None,
            "late": self._clock.late,
        }

    def _challenged(self, frame: Frame) -> list[Event]:
        """Begin the challenge, record the badge's place, and show and judge the prompts that are due."""
        if self._asked_s is None:
            return []
        now_s = frame.time_s
        if self._prompts is None:
            return self._begin(now_s)
        self._note(frame)
        if self._judged < self._shown:
            return self._judge_next(now_s)
        late_s = now_s - self._prompts[self._shown].at_s
        if late_s < 0:
            return []
        if self._pace.in_call and not self._rests():
            return [self.finish()] if late_s > REST_WAIT_S else []
        return [self._show(now_s)]

    def _rests(self) -> bool:
        """Whether the badge has not moved for a while."""
        since_s = self._frames_s[-1] - REST_S
        last = [place for time_s, place in zip(self._times[-60:], self._places[-60:], strict=True) if time_s >= since_s]
        return len(last) >= MIN_FRAMES and bool(np.abs(np.array(last) - np.median(last, axis=0)).max() <= BEGUN)

    def _show(self, now_s: float) -> Event:
        """Show the prompt that is due."""
        assert self._prompts is not None
        planned = self._prompts[self._shown]
        # The prompt's time is the moment when it is shown: an earlier motion does not follow it.
        prompt = Prompt(planned.move, max(now_s, self._now()))
        self._prompts[self._shown] = prompt
        self._shown += 1
        if self._pace.in_call:
            self._put_off(prompt.at_s - planned.at_s)
        hold = ", and hold it there" if prompt.move == FACE else ""
        event = {"event": "prompt", "number": self._shown, "of": len(self._prompts), "move": prompt.move}
        return event | {"text": f"{WORDS[prompt.move]}{hold}.", "aloud": ALOUD[prompt.move]}

    def _judge_next(self, now_s: float) -> list[Event]:
        """Judge the prompt that is shown, once it is over."""
        assert self._prompts is not None
        prompt = self._prompts[self._judged]
        if not self._pace.in_call and now_s <= over_s(prompt, self._pace):
            return []
        reason = judge_prompt(self._path(), prompt, self._pace, np.array(self._frames_s))
        if now_s <= over_s(prompt, self._pace, reason):
            return []
        self._judged += 1
        events: list[Event] = [{"event": "prompted", "number": self._judged, "reason": reason.to_json()}]
        if reason.level != "pass" or self._judged == len(self._prompts):
            return [*events, self.finish()]
        if self._pace.in_call:
            self._put_off(now_s - prompt.at_s)
        return events

    def _put_off(self, by_s: float) -> None:
        """Let the prompts that were not shown yet come later."""
        assert self._prompts is not None
        self._prompts[self._shown :] = [Prompt(one.move, one.at_s + by_s) for one in self._prompts[self._shown :]]

    def _judge_prompts(self, asked: list[Prompt]) -> tuple[Reason, ...]:
        path, frames_s = self._path(), np.array(self._frames_s)
        answers = judge_challenge(path, asked, self._pace, frames_s)
        if not asked:
            return answers
        unbroken = judge_unbroken(path, asked, frames_s, self._pace)
        return (*answers, unbroken, *((judge_delay(answers),) if self._pace.in_call else ()))

    def _begin(self, now_s: float) -> list[Event]:
        """Draw the prompts once badge and face are both seen."""
        assert self._asked_s is not None
        if now_s - self._asked_s > WAIT_S:
            self._prompts = []
            return [self.finish()]
        if not self._verifier.in_view or self._watch.face is None:
            return []
        self._prompts = self._draw(now_s + READY_S)
        # The challenge is judged on its own frames only.
        self._verifier = Verifier(self._claim, aside=self._aside)
        return [{"event": "challenge", "moves": len(self._prompts)}]

    def _note(self, frame: Frame) -> None:
        self._frames_s.append(frame.time_s)
        place = self._verifier.judged.tracker.place
        if place is None:
            return
        height, width = frame.luma.shape
        self._times.append(frame.time_s)
        self._places.append(place_of(place, self._middle_mm, (width, height)))
        self._before_face.append(self._verifier.judged.tracker in self._watch.over)

    def _path(self) -> PromptPath:
        places = np.array(self._places, float).reshape(-1, 3)
        return PromptPath(np.array(self._times, float), places, np.array(self._before_face, bool))

    def _whole(self) -> Reason:
        """Whether there was a challenge, and whether it was completed."""
        if self._asked_s is None:
            text = "No challenge was made, so it is not known when this was filmed."
            return Reason("challenge", "undecided" if self._required else "note", None, None, "prompts", text)
        asked = len(self._prompts or ())
        if asked and self._judged == asked:
            text = f"All {asked} prompts were made and answered."
            if self._pace.in_call and asked == self._pace.moves:
                tries = _rounded(1 / likeliest_chance(self._pace))
                text += f" An older film would answer them in one of {tries:,} tries at most."
            return Reason("challenge", "pass", float(asked), float(asked), "prompts", text)
        why = "was left before its end" if asked else "did not begin, as badge and face were not seen at once"
        text = f"The challenge {why}; {self._judged} of {asked} prompts were answered. Begin again."
        return Reason("challenge", "undecided", float(self._judged), float(asked), "prompts", text)

    def _in_time(self) -> Reason:
        share = self._clock.late_share
        if share <= MOST_LATE:
            text = f"{share:.0%} of the frames came later than their time stamps say; up to {MOST_LATE:.0%} may."
            return Reason("clock", "pass", share, MOST_LATE, "share", text)
        text = (
            f"{share:.0%} of the frames came later than their time stamps say; up to {MOST_LATE:.0%} may. The "
            "connection or the machine that judges is too slow for a live check, or the sender's clock is wrong; use a "
            "faster connection, or a smaller picture."
        )
        # In a call the sender is the one who asks, and has nothing to gain from a lie about times.
        return Reason("clock", "undecided" if self._pace.in_call else "fail", share, MOST_LATE, "share", text)


def _rounded(count: float) -> int:
    """Down to one digit and zeros."""
    ten = 10 ** (len(str(int(count))) - 1)
    return int(count // ten * ten)
