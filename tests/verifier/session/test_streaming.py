"""Films judged frame by frame, in chapters, and by time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from kit.places import FILMS
from moireid.badge import Badge
from moireid.question import KnownCamera
from moireid.verifier import Question, Running, Verifier, verify
from moireid.verifier.identity.decode import Identity
from moireid.verifier.measuring import MAX_UNSEARCHED_S
from moireid.verifier.picture import Frame
from moireid.verifier.reasons import Reason
from moireid.verifier.session import chapters
from moireid.verifier.session import streaming as stream
from moireid.verifier.session.chapters import identity_of, invariant_of, judge_chapter
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.tracking.track import no_track
from moireid.verifier.video import Film


def frames_of(*paths: Path) -> Iterator[Frame]:
    """The frames of films, one film after another as if they were one."""
    index, start = 0, 0.0
    for path in paths:
        time_s = 0.0
        for frame in Film(path).frames():
            time_s = frame.time_s
            yield Frame(index, start + time_s, frame.luma)
            index += 1
        start += time_s + 1 / 60


@pytest.fixture(scope="module")
def whole(films: Path, prototype: Badge):
    """The tracks of the genuine film: all of it, and by halves."""
    view = SceneTracker(prototype)
    tracker = view.trackers[0]
    halves = []
    for frame in frames_of(films / "genuine_1.0m.mp4"):
        view.push(frame)
        if tracker.tracked == 120:
            halves.append(tracker.take())
    return halves


@pytest.fixture(scope="module")
def films() -> Path:
    """As the session's fixture, for the module's."""
    return FILMS


@pytest.fixture(scope="module")
def prototype(films: Path) -> Badge:
    """As the session's fixture, for the module's."""
    from moireid.badge import load_badge

    return load_badge(films / "badge.json")


@pytest.fixture(scope="module")
def true(whole, prototype: Badge) -> chapters.Chapter:
    """The first half, judged."""
    return judge_chapter(whole[0], Question(prototype))


def test_a_moment_that_breaks_the_law_is_not_averaged_away(true):
    """Catches: minutes of truth in which two forged seconds drown."""
    backwards = tuple(replace(signal, measured_rad=-signal.measured_rad) for signal in true.signals)
    forged = replace(true, invariant=chapters.judge(backwards), signals=backwards)
    assert forged.invariant.verdict == "reject"
    together = invariant_of([true] * 100 + [forged])
    assert together.verdict == "reject"
    assert "Between 0 and 2 s" in together.reasons[-1].text and together.reasons[-1].level == "fail"


def test_badges_that_change_within_a_film_are_told(true):
    """Catches: the first chapter's identity taken for the whole film's."""

    def reading(verdict: str, found: str | None) -> chapters.Chapter:
        return replace(true, identity=Identity(verdict, (), decoded_id=found, claimed_id="aa"))

    assert identity_of([reading("unreadable", None), reading("match", "aa")])[0].verdict == "match"
    assert identity_of([reading("match", "aa"), reading("mismatch", "bb")])[0].verdict == "mismatch"
    several, _ = identity_of([reading("not_claimed", "aa"), reading("not_claimed", "bb")])
    assert [reason.level for reason in several.reasons] == ["fail"]


def test_a_code_that_stays_still_in_one_chapter_counts(true):
    """Catches: whether the code moves taken from one chapter, so that an hour of true film hides a painted minute."""

    def moving(level: str) -> chapters.Chapter:
        reason = Reason("cells_move", level, 1.0, 0.6, "ratio", "The code moves.")
        return replace(true, identity=Identity("match", (reason,), decoded_id="aa", claimed_id="aa"))

    found, _ = identity_of([moving("pass"), moving("fail"), moving("pass")])
    assert [reason.level for reason in found.reasons] == ["pass", "fail"] and "Between" in found.reasons[1].text
    assert identity_of([moving("pass"), moving("undecided")])[0].reasons == moving("pass").identity.reasons


@pytest.mark.slow
def test_a_film_in_chapters_is_judged_as_the_whole_is(films, prototype, monkeypatch):
    """Catches: frames lost between chapters, pictures kept of all of them, a verdict of the last one alone."""
    monkeypatch.setattr(stream, "CHAPTER_FRAMES", 110)
    monkeypatch.setattr(stream, "OVERLAP_FRAMES", 60)
    whole = verify(films / "genuine_1.0m.mp4", Question(prototype))
    assert whole.verdict == "accept" and whole.frames == {"read": 240, "tracked": 240, "unsearched": 0, "damaged": 0}
    # Chapters of 110, 110 - 60 and so on; the last has the remaining frames and those that it repeats.
    assert [segment.tracked for segment in whole.segments] == [110, 50, 50, 30]
    assert 60 < whole.track.tracked <= 110
    verifier = Verifier(Question(prototype), running=False)
    for frame in frames_of(films / "genuine_1.0m.mp4", films / "forged_drift_1.0m.mp4"):
        verifier.push(frame)
        assert sum(chapter.track is not None for chapter in verifier.chapters) <= 1
    assert invariant_of(verifier.finish()).verdict == "reject"


@pytest.mark.slow
def test_a_running_verdict_comes_every_second_and_knows_no_future(films, prototype):
    """Catches: a verdict that waits for the end, one that looks ahead, a focal length that is solved anew each time."""

    def run(most: int) -> list[Running]:
        verifier = Verifier(Question(prototype))
        told = []
        for frame, _ in zip(frames_of(films / "genuine_1.0m.mp4"), range(most), strict=False):
            verdict = verifier.push(frame)
            if verdict is not None:
                told.append(verdict)
        return told

    told, cut = run(240), run(130)
    assert [round(verdict.time_s, 2) for verdict in told] == [1.0, 2.0, 3.0]
    assert cut == told[:2]
    assert told[0].verdict in ("inconclusive", "accept") and told[-1].verdict == "accept"
    assert all(verdict.span_s[1] <= verdict.time_s for verdict in told)


def test_an_empty_and_a_still_stream_stay_open(prototype):
    """Catches: a crash where nothing was pushed, or the badge leaves as a chapter ends; a verdict without a badge."""
    assert invariant_of(Verifier(Question(prototype)).finish()).verdict == "inconclusive"
    verifier = Verifier(Question(prototype))
    for index in range(40):
        running = verifier.push(Frame(index, index / 30, np.full((90, 160), 128, np.uint8)))
        assert running is None or running.verdict == "inconclusive"
    assert invariant_of(verifier.finish()).reasons[0].code == "badge_absent"


@pytest.mark.parametrize(("longest_s", "level"), [(MAX_UNSEARCHED_S, None), (MAX_UNSEARCHED_S + 0.1, "undecided")])
def test_seconds_in_which_nobody_looked_leave_a_film_open(ada, longest_s, level):
    """Catches: a forged badge shown while a chessboard beside it makes looking too dear, in a film that is accepted."""
    verifier = Verifier(Question(ada))
    verifier._view.unsearched_s = longest_s
    assert [reason.level for reason in verifier.long_unsearched] == ([level] if level else [])


@pytest.mark.parametrize("sd", [0.15, 0.01])
def test_a_focal_length_that_is_a_guess_is_not_kept(prototype, monkeypatch, sd):
    """Catches: the guess made while a badge is held still, taken as given from then on: no error bar, never anew."""
    asked: list[KnownCamera | None] = []
    empty = judge_chapter(no_track(prototype, 240, (64, 64)), Question(prototype))
    camera = SimpleNamespace(focal_px=1500.0, tangent_sd=(sd, sd))

    def judged(track, claim):
        asked.append(claim.camera)
        return replace(empty, measurement=SimpleNamespace(camera=camera))

    monkeypatch.setattr(stream, "judge_chapter", judged)
    live = Verifier(Question(prototype))
    for tracked in (60, 90, 130, 240, 240, 240):
        live._judged_now(replace(no_track(prototype, tracked, (64, 64)), times_s=np.arange(tracked) / 30))
    found = KnownCamera(1500.0)
    kept = [None, found, None, found, found, found]
    assert asked == (kept if sd < 0.03 else [None] * 6)
