"""What excuses a failure.  Beside each test: what it would catch."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from moireid.verifier.decision.excuses import without_camera_s_blame

from moireid.verifier.decision.figures import Figures
from moireid.verifier.decision.judge import _likely_true
from moireid.verifier.reasons import Reason


def found(excitation_rad: float, limit_rad: float, gain: float) -> list[Reason]:
    """Findings of a film whose likelihood fails after enough motion."""
    return [
        Reason("motion", "pass", excitation_rad, limit_rad, "rad", ""),
        Reason("correlation", "undecided", 0.92, 0.95, "", ""),
        Reason("gain", "pass" if gain == 0.9 else "fail", gain, 0.15, "ratio", ""),
        Reason("likelihood", "fail", -1.3, 0.8, "log10", ""),
    ]


def levels(excitation_rad: float, doubt: float, gain: float = 0.9) -> dict[str, str]:
    """The level of each finding after the excuses, by its code."""
    signal = SimpleNamespace(mixed_share=0.0, lasting_px=0.0, zoom=1.0, doubt=doubt)
    sheet = SimpleNamespace(expected=1.0)
    return {one.code: one.level for one in without_camera_s_blame(found(excitation_rad, 0.43, gain), [signal], sheet)}  # type: ignore[list-item, arg-type]


@pytest.mark.parametrize(
    ("excitation_rad", "doubt", "rejected"),
    [(0.575, 1.6, False), (0.575, 1.0, True), (0.9, 1.6, True)],
)
def test_a_tiny_badge_is_rejected_only_after_much_motion(excitation_rad, doubt, rejected):
    """Catches: a true film of a small badge called forged; an excuse for large markers, or for any amount of motion."""
    told = levels(excitation_rad, doubt)
    assert (told["likelihood"] == "fail") is rejected
    assert ("small" in told) is not rejected


@pytest.mark.parametrize(("possible", "level"), [(-0.38, "undecided"), (-1.07, "fail")])
def test_a_film_is_rejected_only_if_it_would_be_with_all_the_error_that_poses_may_have(possible, level):
    """Catches: a rejection by the told error bar, which a saving coder exceeds for a second."""
    assert _likely_true(Figures(score=-1.9, possible_score=possible, suspected="spell")).level == level


@pytest.mark.parametrize(("gain", "rejected"), [(0.62, False), (0.03, True), (1.6, True)])
def test_poor_poses_lower_a_gain_somewhat_and_do_not_take_it_away(gain, rejected):
    """Catches: fringes that hardly move excused by a small badge."""
    assert (levels(0.575, 1.6, gain)["gain"] == "fail") is rejected
