"""Times of frames as they are in files.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import pytest

from moireid.verifier.camera import smoothing
from moireid.verifier.measuring import MAX_GAP_S
from moireid.verifier.timeline import BREAK_S, JOINT_S, RESTART_S, FilmTime, restart_findings
from moireid.verifier.tracking.smeared_frames import LOST_S


def placed(*times_s: float) -> tuple[list[float], list[bool], int]:
    clock = FilmTime()
    found = [clock.place(time_s) for time_s in times_s]
    return [time_s for time_s, _ in found], [restarted for _, restarted in found], clock.restarts


def test_rising_times_stay_what_they_are():
    """Catches: an origin taken off, a time that is rounded, a gap taken for a restart."""
    times = [1.4, 1.4 + 1 / 30, 1.5, 60.0, 1e6]
    assert placed(*times) == (times, [False] * 5, 0)


def test_a_repeated_or_badly_told_time_is_no_restart():
    """Catches: a chapter for each repeated time; a time that falls."""
    times, restarted, count = placed(0.0, 0.0, 0.0, 0.1, 0.1 - 0.9 * RESTART_S, 0.15)
    assert times == [0.0, 0.0, 0.0, 0.1, 0.1, 0.15] and not any(restarted) and count == 0


def test_after_a_restart_times_go_on_behind_a_gap():
    """Catches: times that fall, or run together; an offset that is forgotten, or added once a frame."""
    times, restarted, count = placed(5.0, 5.5, 0.0, 0.1, 0.2, -3.0, -2.9)
    later = 5.5 + JOINT_S
    assert times == pytest.approx([5.0, 5.5, later, later + 0.1, later + 0.2, later + 0.2 + JOINT_S, later + 0.8])
    assert restarted == [False, False, True, False, False, True, False] and count == 2


def test_nothing_reaches_across_a_joint():
    """Catches: a gap that a course is smoothed over, a phase unwrapped over, or a smeared badge followed over."""
    assert max(smoothing.GAP_S, MAX_GAP_S, LOST_S, BREAK_S) < JOINT_S


def test_findings_tell_restarts_and_what_no_piece_judges():
    """Catches: a note on every film; frames that nobody judged and nobody names."""
    assert restart_findings(0, 500, 30) == ()
    assert [reason.level for reason in restart_findings(2, 29, 30)] == ["note"]
    assert [(reason.code, reason.level) for reason in restart_findings(1, 30, 30)] == [
        ("times", "note"),
        ("piece", "undecided"),
    ]
