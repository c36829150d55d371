"""Verify a film against a question, in numbered steps.

Here are steps 1, 2 and 8 of those in ARCHITECTURE.md; steps 3 to 7 run chapter by chapter (`chapters`), and a film of
up to half a minute is one chapter.

Policy: the invariant and the identity must both hold.  If either fails, the film is rejected; if either is in doubt,
the verdict is inconclusive. Figures that differ from those of enrolment are reported, and the film is rejected where
the policy asks for them, which it does by default for a badge that is known as built. With the overlap protocol, the
badge must also pass in front of the face, and obey the law there (`overlap`).
If several badges are in view, the verdict is about one of them (`badge_session`); the report gives its place.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

from threadpoolctl import threadpool_limits

from moireid.badge import Badge
from moireid.files import AnyPath
from moireid.frames import axis_words
from moireid.question import Question
from moireid.verifier.damage import claimed_finding
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.reasons import worst
from moireid.verifier.session.chapters import Chapter, identity_of, invariant_of
from moireid.verifier.session.check_level import level_finding, level_reached
from moireid.verifier.session.claim import barred_finding, claim_reasons, least_strength
from moireid.verifier.session.cover import cover_findings
from moireid.verifier.session.overlap import OverlapWatch
from moireid.verifier.session.result import Report
from moireid.verifier.session.streaming import Verifier
from moireid.verifier.tracking.track import no_track
from moireid.verifier.video import Film, Progress, one_thread


def verify(video: AnyPath, question: Question, *, progress: Progress | None = None) -> Report:
    """Verify a film against a question, in this process.

    A film made to take over its decoder then has this process's rights, and nothing limits its memory and time; the
    commands read films in a sealed process (`moireid.reading`).

    Parameters
    ----------
    video : str or Path
        The film.
    question : Question
        The badge, the identity that must be read, what else is known about them, and what an acceptance needs.
    progress : callable, optional
        Called with the number of frames read, and the number expected (None if the file does not state it).

    Returns
    -------
    Report
        Its verdict "accept" needs both invariant and identity; without a claimed identity the invariant alone.

    Raises
    ------
    SpecError
        The badge cannot be read at all; or the question asks for what is not possible.
    CodeError
        This version cannot read the badge's code.
    MediaError
        The film cannot be read, or was changed while it was read.
    MissingExtraError
        The face detector is missing.

    Notes
    -----
    Convention: if either test fails, the film is rejected; if either is in doubt, the verdict is inconclusive.
    Source: the steps and the policy are those of the module docstring.
    """
    begun = time.perf_counter()
    least_strength(question)
    film = Film(video, track=question.track)  # 1
    if question.camera is not None:
        question.camera.check_size((film.width, film.height))
    # The matrices are small: a second BLAS thread waits far longer than it works, and costs half
    # of a verification's time.
    with threadpool_limits(limits=1, user_api="blas"):
        verifier, watch, chapters, read, stages = _read(film, question, progress)
    invariant = invariant_of(chapters)
    identity, built_reasons = identity_of(chapters)
    reasons = invariant.reasons + identity.reasons + built_reasons + verifier.others + verifier.restarts
    judged = verifier.judged
    watched = watch if film.tracks.judged else None
    overlapped = watched.judge(judged.tracker, chapters) if watched else None
    if overlapped:
        reasons += overlapped.reasons
    if not film.tracks.judged:
        reasons = ()
    reasons += film.findings()
    if any(chapter.claimed for chapter in chapters):
        reasons += (claimed_finding(),)
    cover = verifier.cover
    tracked = sum(chapter.tracked for chapter in chapters)
    if tracked:
        reasons += (*cover_findings(cover, question.cover_share), *verifier.long_unsearched)
    if film.tracks.judged:
        reasons += claim_reasons(question, identity)
    if question.barred is not None:
        reasons += (barred_finding(question.barred),)
    level = level_reached(worst(list(reasons)), identity.built)
    reasons += level_finding(question.level, level, identity.built)
    verdict = worst(list(reasons))  # 8
    timing = {
        "total_s": round(time.perf_counter() - begun, 4),
        "stages": {name: round(seconds, 4) for name, seconds in stages.items()},
    }
    shown = next(chapter for chapter in chapters if chapter.track is not None)
    return Report(
        verdict,
        reasons,
        invariant,
        identity,
        film.described(),
        {
            "read": read + film.damage.lost,
            "tracked": tracked,
            "unsearched": verifier.unsearched,
            "damaged": film.damage.damaged,
        },
        timing,
        _left_out(question.badge, shown.measurement, verifier.unsearched),
        shown.track or no_track(question.badge, read, (film.width, film.height)),
        shown.measurement,
        segments=tuple(segment for chapter in chapters for segment in chapter.segments),
        region=judged.region,
        overlap=overlapped,
        cover=cover,
        claim_source=question.provenance.source,
        registry=question.provenance.standing,
        level=level,
    )


#: A film read to its end: verifier, face watch, chapters, number of frames, seconds of each stage.
_DecodedFilm = tuple[Verifier, OverlapWatch | None, list[Chapter], int, dict[str, float]]


def _read(film: Film, question: Question, progress: Progress | None) -> _DecodedFilm:
    """Steps 2 to 7: push the film into a verifier, frame by frame."""
    watch = OverlapWatch() if question.overlap else None
    read, stages = 0, {"decode": 0.0} | ({"face": 0.0} if watch else {})
    # A thread judges the chapters, unless the process may use only one; none is started before it is needed.
    with ThreadPoolExecutor(1, "chapters") as thread:
        aside = None if one_thread() else thread
        verifier = Verifier(question, running=False, aside=aside, marks=film.damage.marks)
        clock = time.perf_counter()
        # Decoding runs in parallel, so this counts only the time that the loop waits for a frame.
        for frame in film.frames_ahead():
            stages["decode"] += time.perf_counter() - clock
            read += 1
            if not film.tracks.judged:
                break
            verifier.push(frame)  # 2, and 3 to 7 where a chapter is full
            if watch:
                begin = time.perf_counter()
                watch.push(frame.at(verifier.now_s), verifier.in_view)
                stages["face"] += time.perf_counter() - begin
            if progress:
                progress(read, film.frames_expected)
            clock = time.perf_counter()
        chapters = verifier.finish()  # 3 to 7
    for chapter in chapters:
        for name, seconds in chapter.stages_s.items():
            stages[name] = stages.get(name, 0.0) + seconds
    return verifier, watch, chapters, read, stages


def _left_out(badge: Badge, measurement: Measurement | None, unsearched: int) -> tuple[str, ...]:
    """Steps that this film and badge did not need, or that would cost more than decoding allows."""
    parts = ["colour", "the picture away from the badge once it is found"]
    if unsearched:
        parts.append(
            f"the whole picture in {unsearched} frames without the badge, or one of several, as looking may cost a "
            "share of decoding"
        )
    if measurement and measurement.camera.focal_given:
        parts.append("solving for the focal length")
    if len({grating.axis for grating in badge.gratings}) == 1:
        parts.append(f"motion along the lines, square to {axis_words(badge.gratings[0].axis)}, as no fringes sense it")
    if all(grating.code is None for grating in badge.gratings):
        parts.append("decoding, as the board carries no code")
    return tuple(parts)
