"""A live check of any stream, whose verdict is reported as that of a film: with all keys of `verify --json`.

Two kinds of streams, two clocks.  Of a camera or a call each picture comes when it was taken, so its time is checked
against our own clock; so it is of a pipe by which prompts are answered.  A film, or a pipe without prompts, may come
faster, or in pieces of seconds: only its own times say how the badge moved.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from moireid.question import Question
from moireid.verifier.picture import Frame, Picture
from moireid.verifier.reasons import Reason
from moireid.verifier.session.chapters import Chapter, identity_of, invariant_of
from moireid.verifier.session.claim import barred_finding
from moireid.verifier.session.cover import cover_findings
from moireid.verifier.session.overlap import OverlapWatch
from moireid.verifier.session.result import Report
from moireid.verifier.tracking.badge_tracker import BadgeTracker
from moireid.verifier.tracking.track import no_track
from moireid_studio.challenge.challenge import draw_prompts
from moireid_studio.challenge.clock import BoundedClock, StreamClock
from moireid_studio.challenge.session import Draw, Event, LiveCheck

#: What is not looked at in any stream.
LEFT_OUT = ("colour", "the picture away from the badge once it is found")


class NoWatch(OverlapWatch):
    """Searches for no face, for checks that need none: the detector is an optional package, and takes time."""

    def __init__(self) -> None:
        self.face, self.over = None, []

    def push(self, frame: Frame, in_view: Sequence[tuple[BadgeTracker, NDArray[np.float64]]]) -> None:
        """Ignore the frame."""


class StreamCheck(LiveCheck):
    """A live check of a stream.

    Parameters
    ----------
    claim : Question
        What is held against it.
    live : bool
        Whether each picture comes when it was taken, so that its time is checked against our clock.
    challenged : bool
        Whether prompts will be asked for; only then the face is looked for.
    draw, now, aside
        As in `LiveCheck`.

    Raises
    ------
    SpecError
        The badge cannot be read at all.
    MissingExtraError
        Prompts will be asked for, and the face detector is missing.
    """

    def __init__(
        self,
        claim: Question,
        *,
        live: bool = True,
        challenged: bool = False,
        draw: Draw = draw_prompts,
        now: Callable[[], float] = time.monotonic,
        aside: Executor | None = None,
    ) -> None:
        # Our clock begins with the first picture, so that seconds in a report are those of the stream.
        self._origin_s: float | None = None
        super().__init__(
            claim,
            draw=draw,
            now=lambda: now() - (self._origin_s or 0.0),
            aside=aside,
            clock=BoundedClock() if live else StreamClock(),
            watch=OverlapWatch() if challenged else NoWatch(),
        )
        self._size = (0, 0)
        self._begun = time.perf_counter()

    def push(self, luma: NDArray[np.uint8] | Picture, claimed_s: float, arrival_s: float) -> list[Event]:
        """Take a picture.

        Parameters
        ----------
        luma : array (height, width) of uint8, or Picture
            Brightness; all pictures are of one size.
        claimed_s : float
            When it was taken, by the sender's clock, s.
        arrival_s : float
            When it came, by our clock, s.

        Returns
        -------
        list of dict
            The events that it causes.
        """
        self._size = luma.shape[1], luma.shape[0]
        if self._origin_s is None:
            self._origin_s = arrival_s
        events = super().push(luma, claimed_s, arrival_s - self._origin_s)
        if self._claim.barred is None:
            return events
        # However well the fringes move: a badge that was revoked is never shown as accepted.
        said = barred_finding(self._claim.barred).to_json()
        return [
            one | {"verdict": "reject", "reasons": [said, *one["reasons"]]} if one["event"] == "status" else one
            for one in events
        ]

    def finish(self) -> Event:
        """End the session.

        Returns
        -------
        dict
            The event of the verdict, with all keys of ``verify --json`` but `input`.

        Notes
        -----
        Convention: a verdict without prompts is of as much of the stream as the claim asks (`cover`), as of a film.
        """
        event = super().finish()
        return self._report(event).to_json() | event

    def _weighed(self, reasons: tuple[Reason, ...], chapters: Sequence[Chapter]) -> tuple[Reason, ...]:
        """The findings of a live check without those that mean nothing here, and those of a film."""
        if not self._clock.checked:
            reasons = tuple(one for one in reasons if one.code != "clock")
        if self._prompts is None:
            # Pictures that come too late are a lie only where they could answer a prompt; else this machine is slow.
            reasons = tuple(
                replace(one, level="undecided") if (one.code, one.level) == ("clock", "fail") else one
                for one in reasons
            )
        reasons += self._verifier.restarts
        if self._prompts is None and any(chapter.tracked for chapter in chapters):
            reasons += (*cover_findings(self._verifier.cover, self._claim.cover_share), *self._verifier.long_unsearched)
        return reasons if self._claim.barred is None else (*reasons, barred_finding(self._claim.barred))

    def _report(self, event: Event) -> Report:
        """What a film's report holds of this stream, besides what the event of the verdict says."""
        chapters = self._verifier.chapters
        invariant, (identity, _) = invariant_of(chapters), identity_of(chapters)
        shown = next((chapter for chapter in chapters if chapter.track is not None), None)
        return Report(
            event["verdict"],
            (),
            invariant,
            identity,
            {},
            event["frames"],
            {"total_s": round(time.perf_counter() - self._begun, 4), "stages": _stages(chapters)},
            LEFT_OUT,
            (shown.track if shown else None) or no_track(self._claim.badge, self._index, self._size),
            shown.measurement if shown else None,
            segments=tuple(segment for chapter in chapters for segment in chapter.segments),
            region=self._verifier.judged.region,
            cover=self._verifier.cover,
            claim_source=self._claim.provenance.source,
            registry=self._claim.provenance.standing,
        )


def _stages(chapters: Sequence[Chapter]) -> dict[str, float]:
    found: dict[str, float] = {}
    for chapter in chapters:
        for name, seconds in chapter.stages_s.items():
            found[name] = round(found.get(name, 0.0) + seconds, 4)
    return found
