"""Frames of a calm badge that are not measured.  Beside each test: what it catches."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest

from kit.drawn_pages import draw, filmed, seen_from
from moireid.verifier.picture import Frame
from moireid.verifier.tracking.frame_skipping import FULL_FRAMES
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


def followed(
    badge, frames: int, fps: float, lie_rad=lambda k: 0.0, shift_px=lambda k: (0.0, 0.0), painted=lambda k, one: one
):
    """The tracker of a film of the badge; painted: what a forger makes of a picture."""
    view = SceneTracker(badge)
    for k in range(frames):
        picture = shown(badge, TURN_RAD_S * k / fps + lie_rad(k), shift_px(k))
        assert view.push(Frame(k, k / fps, painted(k, picture)))
    return view.trackers[0]


def timed(badge, times_s) -> np.ndarray:
    """Times of the frames that are measured, in a film of these times whose fringes hardly turn."""
    view = SceneTracker(badge)
    pictures = [shown(badge, 0.002 * k) for k in range(8)]
    for k, time_s in enumerate(times_s):
        assert view.push(Frame(k, time_s, pictures[abs(k % 14 - 7)]))
    return view.trackers[0].look().times_s


def box_px(rect_mm) -> tuple[int, int, int, int]:
    """A rectangle of the page in `shown`: left, top, right, bottom."""
    page = seen_from(px_per_mm=2.0, turn_deg=0.0, tilt=(0.0, 0.0), at=(-20.0, -105.0))
    return tuple(cv2.perspectiveTransform(np.array(rect_mm).reshape(1, 2, 2), page).round().astype(int).ravel())


@pytest.mark.parametrize(("fps", "frames"), [(60.0, 300), (120.0, 600)])
def test_a_calm_badge_is_measured_thirty_times_a_second(ada, fps, frames):
    """Catches: frames that are all measured; ones that are left out without end, or with gaps between."""
    tracker = followed(ada, frames, fps)
    track = tracker.look()
    assert track.tracked + track.passed == frames
    assert np.diff(track.times_s) == pytest.approx(1 / 30, abs=1e-6)
    assert len(track.profiles[0]) == track.tracked


def test_a_lie_between_measured_frames_is_measured(ada):
    """Catches: pictures of another badge put where nobody looks; frames left out while they are there."""
    begin = FULL_FRAMES + 60
    track = followed(ada, begin + 90, 60.0, lambda k: 0.5 * (k >= begin and k % 2 == 1)).look()
    measured = set(track.frame_numbers.tolist())
    assert all(k in measured for k in range(begin + 1, begin + 90))
    assert any(k not in measured for k in range(FULL_FRAMES, begin))


@pytest.mark.slow
def test_a_shaken_badge_is_measured_in_full(ada):
    """Catches: a trembling hand seen at half the rate, at which its motion hides between the frames."""
    rng = np.random.default_rng(1)
    course = rng.normal(0, 2.0, (20, 2))
    assert followed(ada, 330, 60.0, shift_px=lambda k: tuple(course[k % 20])).passed == 0


def painted_between_rows(badge, rows: int):
    """The gratings turned upside down, but for a few true lines: those at which a grating of so many rows is read."""

    def painted(picture: np.ndarray) -> np.ndarray:
        lie = picture.copy()
        for grating in badge.gratings:
            x0, y0, x1, y1 = box_px(grating.rect_mm)
            lie[y0:y1, x0:x1] = 255 - picture[y0:y1, x0:x1]
            for row in y0 + (np.arange(rows) + 0.5) / rows * (y1 - y0):
                true = slice(int(row) - 1, int(row) + 3)
                lie[true, x0:x1] = picture[true, x0:x1]
        return lie

    return painted


def painted_over(badge, place: int):
    """The marker of that place painted white."""
    (x, y), half = badge.markers.centers_mm[place], badge.markers.size_mm / 2 + 1
    x0, y0, x1, y1 = box_px((x - half, y - half, x + half, y + half))

    def painted(picture: np.ndarray) -> np.ndarray:
        lie = picture.copy()
        lie[y0:y1, x0:x1] = 230
        return lie

    return painted


def painted_band(badge):
    """A twentieth of each grating's height turned upside down: a forged strip among true ones."""

    def painted(picture: np.ndarray) -> np.ndarray:
        lie = picture.copy()
        for grating in badge.gratings:
            x0, y0, x1, y1 = box_px(grating.rect_mm)
            y1 = y0 + round((y1 - y0) / 20)
            lie[y0:y1, x0:x1] = 255 - picture[y0:y1, x0:x1]
        return lie

    return painted


@pytest.mark.parametrize("lie", [lambda b: painted_between_rows(b, 8), lambda b: painted_over(b, 2), painted_band])
def test_no_place_of_a_badge_is_free_for_a_lie(ada, lie):
    """Catches: frames compared at some places alone, without their markers, or as a whole, in which a strip is lost."""
    begin, painted = FULL_FRAMES + 60, lie(ada)
    forged = followed(ada, begin + 40, 60.0, painted=lambda k, one: painted(one) if k >= begin and k % 2 else one)
    measured = set(forged.look().frame_numbers.tolist())
    assert all(k in measured for k in range(begin + 1, begin + 30))
    assert any(k not in measured for k in range(FULL_FRAMES, begin))


def test_no_more_is_left_out_where_times_slow_down(ada):
    """Catches: a rate that is taken from the first seconds, so that of 30 frames a second every fourth is measured."""
    fast = np.arange(FULL_FRAMES + 160) / 120
    times = np.concatenate([fast, fast[-1] + np.arange(1, 61) / 30])
    measured = timed(ada, times)
    assert len(measured) < len(times)
    assert np.all(np.isin(times[len(fast) :], measured))


def test_a_few_close_times_do_not_thin_out_what_was_apart(ada):
    """Catches: frames of 60 a second thinned out to 15, as some later ones have the times of a fast camera."""
    slow = np.arange(FULL_FRAMES + 260) / 60
    times = np.concatenate([slow, slow[-1] + np.arange(1, 9) / 480, slow[-1] + 8 / 480 + np.arange(1, 40) / 60])
    assert np.diff(timed(ada, times)).max() < 0.05
