"""Frames of a calm badge that are not measured.  Beside each test: what it catches."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest

from kit.drawn_pages import draw, filmed, seen_from
from moireid.verifier.picture import Frame
from moireid.verifier.tracking.calm import FULL_FRAMES, RESTLESS_S
from moireid.verifier.tracking.scene_tracker import SceneTracker

SHAPE = (400, 440)
#: Fringes of a grating, and turns of their phase in a second, rad.
FRINGES, TURN_RAD_S = 4, 1.5


@cache
def drawn(markers, *shift_px: float) -> np.ndarray:
    """The markers alone."""
    page = seen_from(px_per_mm=2.0, turn_deg=0.0, tilt=(0.0, 0.0), at=np.subtract(shift_px, (20.0, 105.0)))
    return draw(page, markers, shape=SHAPE)


def shown(badge, phase_rad: float, shift_px: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """A picture of the badge whose fringes have a phase."""
    page = seen_from(px_per_mm=2.0, turn_deg=0.0, tilt=(0.0, 0.0), at=np.subtract(shift_px, (20.0, 105.0)))
    picture = drawn(badge.markers, *shift_px).copy()
    for grating in badge.gratings:
        corners = cv2.perspectiveTransform(np.array(grating.rect_mm).reshape(1, 2, 2), page).round().astype(int)
        (x0, y0), (x1, y1) = corners[0]
        across = 2 * np.pi * FRINGES * np.linspace(0, 1, x1 - x0) + phase_rad
        picture[y0:y1, x0:x1] = 128 + 60 * np.cos(across)
    return filmed(picture)


def followed(badge, frames: int, fps: float, lie_rad=lambda k: 0.0, shift_px=lambda k: (0.0, 0.0)):
    """The tracker of a film of the badge."""
    view = SceneTracker(badge)
    for k in range(frames):
        assert view.push(Frame(k, k / fps, shown(badge, TURN_RAD_S * k / fps + lie_rad(k), shift_px(k))))
    return view.trackers[0]


@pytest.mark.parametrize(("fps", "frames"), [(60.0, 360), (120.0, 600)])
def test_a_calm_badge_is_measured_thirty_times_a_second(ada, fps, frames):
    """Catches: frames that are all measured; ones that are left out without end, or with gaps between."""
    tracker = followed(ada, frames, fps)
    track = tracker.look()
    assert track.tracked + track.passed == frames
    assert np.diff(track.times_s) == pytest.approx(1 / 30, abs=1e-6)
    assert len(track.profiles[0]) == track.tracked


@pytest.mark.parametrize(("fps", "frames"), [(60.0, FULL_FRAMES - 1), (30.0, 360)])
def test_short_films_and_slow_ones_are_measured_in_full(ada, fps, frames):
    """Catches: frames left out where a verdict has few of them."""
    assert followed(ada, frames, fps).passed == 0


def test_a_lie_between_measured_frames_is_measured(ada):
    """Catches: pictures of another badge put where nobody looks; frames left out while they are there."""
    begin = FULL_FRAMES + 60
    track = followed(ada, begin + 90, 60.0, lambda k: 0.5 * (k >= begin and k % 2 == 1)).look()
    measured = set(track.frame_numbers.tolist())
    assert all(k in measured for k in range(begin + 1, begin + 90))
    assert any(k not in measured for k in range(FULL_FRAMES, begin))


def test_a_shaken_badge_is_measured_in_full(ada):
    """Catches: a trembling hand seen at half the rate, at which its motion hides between the frames."""
    rng = np.random.default_rng(1)
    course = rng.normal(0, 2.0, (20, 2))
    assert followed(ada, 330, 60.0, shift_px=lambda k: tuple(course[k % 20])).passed == 0


def test_after_a_difference_each_frame_is_measured_for_a_while(ada):
    """Catches: fringes that turn fast for a moment, seen at half the rate."""
    begin = FULL_FRAMES + 61
    track = followed(ada, begin + 60, 60.0, lambda k: 0.5 * (k >= begin)).look()
    after = [k for k in range(begin, begin + 60) if k not in set(track.frame_numbers.tolist())]
    assert after and min(after) >= begin + round(60 * RESTLESS_S)
