"""Of which seconds a verdict speaks.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.session.cover import cover_finding, cover_of, judged_spans

STEP = 1 / 30


def signal(times_s: np.ndarray, unread: slice = slice(0, 0)) -> GratingSignal:
    sd = np.full(len(times_s), 0.01)
    sd[unread] = np.inf
    return GratingSignal(np.zeros(len(times_s)), np.zeros(len(times_s)), sd, 0.01, np.zeros(1), times_s)


def test_a_badge_all_film_long_covers_it():
    """Catches: the last frame's own time forgotten, by which no film is ever covered whole."""
    times = np.arange(300) * STEP
    cover = cover_of(judged_spans([signal(times)]), times[0], times[-1], 300)
    assert cover.share == pytest.approx(1.0) and cover.longest_gap_s == pytest.approx(0.0, abs=1e-9)
    assert len(cover.spans_s) == 1 and cover_finding(cover, 0.9).level == "pass"


def test_two_seconds_of_thirty_are_named_and_are_too_few():
    """Catches: the share of tracked frames among those that were tracked; a gap at the film's end overlooked."""
    times = 4.0 + np.arange(60) * STEP
    cover = cover_of(judged_spans([signal(times)]), 0.0, 30.0 - STEP, 900)
    assert cover.share == pytest.approx(2 / 30, rel=0.01)
    assert cover.longest_gap_s == pytest.approx(24.0, abs=0.1)
    finding = cover_finding(cover, 0.5)
    assert finding.level == "undecided" and "4.0 to 6.0 s" in finding.text


def test_unread_frames_are_not_covered():
    """Catches: frames whose fringes a hand hides counted as judged."""
    times = np.arange(300) * STEP
    spans = judged_spans([signal(times, slice(100, 190))])
    cover = cover_of(spans, times[0], times[-1], 300)
    assert len(spans) == 2 and cover.share == pytest.approx(0.7) and cover.longest_gap_s == pytest.approx(3.0)


def test_chapters_that_overlap_count_once():
    """Catches: seconds that two chapters hold counted twice."""
    cover = cover_of([(0.0, 6.0), (5.0, 9.0)], 0.0, 10.0 - STEP, 300)
    assert cover.spans_s == ((0.0, 9.0),) and cover.share == pytest.approx(0.9, abs=0.01)
