"""Chapters judged while the film goes on.  Each test states what it would catch."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from moireid.errors import SpecError
from moireid.verifier.session import badge_session
from moireid.verifier.session.badge_session import ChapterTracker


class Tracker:
    """Hands out chapters by number."""

    frames_read = tracked = 1

    def __init__(self) -> None:
        self.taken = 0

    def take(self, keep: int = 0) -> int:
        self.taken += 1
        return self.taken


def chapter(number: int) -> SimpleNamespace:
    found = SimpleNamespace(number=number, invariant=SimpleNamespace(verdict="accept"), tracked=1, signals=())
    found.light = lambda: found
    return found


@pytest.fixture
def executor():
    with ThreadPoolExecutor(1) as one_thread:
        yield one_thread


def test_one_chapter_is_judged_while_the_film_goes_on_and_they_stay_in_order(monkeypatch, executor):
    """Catches: chapters that pile up in memory behind a slow judge, or come out in another order."""
    going, free = threading.Semaphore(0), threading.Semaphore(0)

    def judge(track: int, claim: None, *, repeated: int) -> SimpleNamespace:
        assert repeated == (0 if track == 1 else 7)
        going.release()
        assert free.acquire(timeout=20)
        return chapter(track)

    monkeypatch.setattr(badge_session, "judge_chapter", judge)
    line = ChapterTracker(None, Tracker(), executor=executor)
    line.close(7)
    assert going.acquire(timeout=20) and line.done == []
    free.release()
    line.close(7)
    assert [one.number for one in line.done] == [1]
    free.release()
    free.release()
    assert [one.number for one in line.finish().chapters] == [1, 2, 3]


def test_an_error_of_a_chapter_is_raised_where_it_is_asked_for(monkeypatch, executor):
    """Catches: a fault in another thread that is lost, and a film judged without one of its chapters."""

    def judge(track: int, claim: None, *, repeated: int) -> None:
        raise SpecError("told by the test")

    monkeypatch.setattr(badge_session, "judge_chapter", judge)
    line = ChapterTracker(None, Tracker(), executor=executor)
    line.close(7)
    with pytest.raises(SpecError, match="told by the test"):
        _ = line.chapters
