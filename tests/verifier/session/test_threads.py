"""Judging in the background while frames come in.  Each test states what it would catch."""

from __future__ import annotations

import threading
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest

from moireid.badge import load_badge
from moireid.verifier import Film, Question, Verifier
from moireid.verifier.session import badge_session, streaming


def test_no_frame_waits_for_a_chapter_in_a_live_session(films: Path, monkeypatch):
    """Catches: a chapter's end, or the question which badge is judged, that holds up `push` until it is judged."""
    monkeypatch.setattr(streaming, "CHAPTER_FRAMES", 40)
    monkeypatch.setattr(streaming, "OVERLAP_FRAMES", 20)
    free, begun, judge = threading.Event(), threading.Event(), badge_session.judge_chapter

    def slow(*given, **named):
        begun.set()
        assert free.wait(timeout=60)
        return judge(*given, **named)

    monkeypatch.setattr(badge_session, "judge_chapter", slow)
    with ThreadPoolExecutor(1) as threads:
        verifier = Verifier(Question(load_badge(films / "badge.json")), aside=threads)
        for frame in Film(films / "genuine_1.0m.mp4").frames():
            if frame.index == 55:
                break
            verifier.push(frame)
            assert verifier.judged.tracker is verifier.in_view[0][0]
        # Fifteen frames went on while the first chapter waited for its judge.
        assert begun.is_set() and verifier.judged.done == []
        free.set()
        assert [chapter.tracked for chapter in verifier.finish()] == [40, 15]


@pytest.mark.slow
def test_verdicts_rest_for_as_long_as_they_took(films: Path, monkeypatch):
    """Catches: a slow machine that judges all the time, so that no time is left for the frames."""
    clock = [0.0]
    monkeypatch.setattr(streaming, "time", SimpleNamespace(perf_counter=lambda: clock[0]))

    class Slow(Executor):
        def submit(self, fn, /, *args, **kwargs):
            clock[0] += 1.5
            made = Future()
            made.set_result(fn(*args, **kwargs))
            return made

    verifier, told = Verifier(Question(load_badge(films / "badge.json")), aside=Slow()), []
    for frame in Film(films / "genuine_1.0m.mp4").frames():
        if frame.time_s > 3.0:
            break
        told.append(verifier.push(frame))
    first, second = [running.time_s for running in told if running is not None]
    assert first == pytest.approx(1.0, abs=0.05) and second == pytest.approx(first + 1.5, abs=0.1)
