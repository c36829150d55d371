"""Of which seconds a verdict speaks.  Each test states what it would catch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import MIN_PRESENT_SHARE
from moireid.verifier.session.cover import cover_findings, cover_of, judged_spans

STEP = 1 / 30


def signal(times_s: np.ndarray, unread: slice = slice(0, 0)) -> GratingSignal:
    sd = np.full(len(times_s), 0.01)
    sd[unread] = np.inf
    sway = 0.4 * np.sin(2 * np.pi * 0.5 * times_s)
    return GratingSignal(sway, sway, sd, 0.01, np.zeros(1), times_s)


def test_a_badge_all_film_long_covers_it():
    """Catches: the last frame's own time forgotten, by which no film is ever covered whole."""
    times = np.arange(300) * STEP
    cover = cover_of(judged_spans([signal(times)]), times[0], times[-1], 300)
    assert cover.share == pytest.approx(1.0) and cover.longest_gap_s == pytest.approx(0.0, abs=1e-9)
    assert len(cover.spans_s) == 1 and [one.level for one in cover_findings(cover, 0.9)] == ["pass"]


@pytest.mark.claim("Two seconds of a true badge in a long film are inconclusive")
def test_two_seconds_of_thirty_are_named_and_are_too_few():
    """Catches: the share of tracked frames among those that were tracked; a gap at the film's end overlooked."""
    times = 4.0 + np.arange(60) * STEP
    cover = cover_of(judged_spans([signal(times)]), 0.0, 30.0 - STEP, 900)
    assert cover.share == pytest.approx(2 / 30, rel=0.01)
    assert cover.longest_gap_s == pytest.approx(24.0, abs=0.1)
    (finding,) = cover_findings(cover, 0.5)
    assert finding.level == "undecided" and "4.0 to 6.0 s" in finding.text


@pytest.mark.parametrize(("tracked", "shown"), [(300, 1.0), (240, 0.8), (150, 0.5)])
def test_a_badge_that_is_in_some_frames_only_makes_a_film_inconclusive(tracked, shown):
    """Catches: frames between which anything may be shown; a film that loses a tenth of its frames to blur."""
    times = np.arange(300) * STEP
    span = [(float(times[0]), float(times[-1]))]
    cover = cover_of(judged_spans([signal(times)]), times[0], times[-1], 300, span, tracked)
    assert cover.present_share == pytest.approx(shown, rel=0.01)
    codes = [one.code for one in cover_findings(cover, 0.5) if one.level == "undecided"]
    assert codes == (["flicker"] if shown < MIN_PRESENT_SHARE else [])


def test_unread_frames_are_not_covered():
    """Catches: frames whose fringes a hand hides counted as judged."""
    times = np.arange(300) * STEP
    spans = judged_spans([signal(times, slice(100, 190))])
    cover = cover_of(spans, times[0], times[-1], 300)
    assert len(spans) == 2 and cover.share == pytest.approx(0.7) and cover.longest_gap_s == pytest.approx(3.0)


def test_a_badge_at_rest_after_a_cut_covers_nothing():
    """Catches: a print that lies still for hours after two seconds of a true badge, counted as judged."""
    times = np.arange(300) * STEP
    moving = signal(times)
    stretch = (times >= 6.0).astype(np.int64)
    rest = np.where(stretch == 1, 0.01, 1.0) * moving.predicted_rad
    one, two = replace(moving, predicted_rad=rest), replace(moving, predicted_rad=rest, stretch=stretch)
    assert cover_of(judged_spans([two]), 0.0, times[-1], 300).share == pytest.approx(0.6, abs=0.01)
    # Without a cut the same badge is followed from its motion into its rest.
    assert cover_of(judged_spans([one]), 0.0, times[-1], 300).share == pytest.approx(1.0)
