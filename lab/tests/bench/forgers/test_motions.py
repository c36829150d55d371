"""Trajectories of attacks and mishaps.  Each test states what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.lenticule import view_law
from moireid.simulate.motion import Poses, motion_named
from moireid_lab.bench.forgers.cases import (
    LEAST_SPAN,
    Shoot,
    drift_on_sweep,
    moving,
    slides,
    spell,
    turn_tangent,
)
from moireid_lab.bench.forgers.motions import in_turns, one_way, seen_only

FPS, FRAMES, AWAY = 30.0, 120, 1000.0
TIMES = np.arange(FRAMES) / FPS


def middle_of(poses: Poses) -> np.ndarray:
    """Where the board's middle is seen, as tangents from the picture's middle, (T, 2); NaN behind the camera."""
    seen = -np.einsum("tij,tj->ti", poses.rotation, poses.camera_mm)
    return np.where(seen[:, 2:] > 0, seen[:, :2] / seen[:, 2:], np.nan)


def proper(poses: Poses) -> bool:
    """Whether all rotations are such, and mirror nothing."""
    unit = poses.rotation @ poses.rotation.transpose(0, 2, 1)
    return bool(np.allclose(unit, np.eye(3), atol=1e-9) and np.all(np.linalg.det(poses.rotation) > 0))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_one_sweep_goes_one_way_at_one_speed_and_keeps_the_badge_in_view(seed):
    """Catches: a sweep that turns, a camera that looks past the badge, two ways that are never both drawn."""
    poses = one_way(AWAY, seed, length_s=FRAMES / FPS)(TIMES)
    steps = np.diff(poses.camera_mm[:, 0])
    assert np.ptp(steps) < 1e-9 * AWAY and np.ptp(poses.camera_mm[:, 0]) > 350
    assert not poses.camera_mm[:, 1].any() and (poses.camera_mm[:, 2] == -AWAY).all()
    assert proper(poses) and np.abs(middle_of(poses)).max() < 0.1


def test_the_badge_is_held_at_one_view_after_another(ada):
    """Catches: views that are no whole turn apart, a sway that hides the turn, a badge seen in the gaps."""
    turn = turn_tangent(ada)
    law = view_law(ada.lens, ada.gratings[0].pitch_mm)
    phase = law.phase_rad(np.array([-turn / 2, turn / 2]), np.zeros(2))
    assert abs(phase[1] - phase[0]) == pytest.approx(2 * np.pi, abs=0.01)
    tangents = np.array([-turn / 2, turn / 2])
    for gap_s in (0.0, 0.5):
        poses = in_turns(AWAY, 3, tangents=tangents, hold_s=0.8, gap_s=gap_s)(TIMES)
        number, within = np.divmod(TIMES + 1e-9, 0.8 + gap_s)
        held = within < 0.8
        parallax = poses.camera_mm[:, 0] / np.abs(poses.camera_mm[:, 2])
        assert np.abs(parallax - tangents[number.astype(int) % 2]).max() < 0.1 * turn
        assert proper(poses) and np.abs(middle_of(poses)[held]).max() < 0.1
        # A wide camera sees a tangent of 0.6.
        assert not (np.abs(middle_of(poses)[~held]) < 1.0).all(axis=1).any()


def test_outside_its_spans_the_badge_is_not_seen():
    """Catches: a camera that moves elsewhere, whose parallax would be another; spans the wrong way round."""
    hand = motion_named("handheld", distance_mm=AWAY, seed=1)
    poses = seen_only(hand, [(0.0, 1.0), (3.0, 99.0)])(TIMES)
    seen = (np.abs(middle_of(poses)) < 1.0).all(axis=1)
    assert np.array_equal(seen, (TIMES < 1) | (TIMES >= 3)) and proper(poses)
    assert np.array_equal(poses.camera_mm, hand(TIMES).camera_mm)


def shown_by(make, badge, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Camera centres that are shown, and the true ones."""
    filming = make(Shoot(badge, AWAY, seed, FRAMES))
    true = filming.motion(TIMES).camera_mm
    return filming.show(None, filming.motion, true, FPS).camera_mm, true


def test_a_spell_freezes_its_frames_alone(ada):
    """Catches: fringes frozen to the end; frames of another count; a true course that is changed too."""
    shown, true = shown_by(spell(1.0), ada)
    held = (shown != true).any(axis=1)
    first = int(np.argmax(held))
    assert held.sum() == 29 and held[first : first + 29].all()
    parallax = true[first - 1 : first + 29, 0] / true[first - 1 : first + 29, 2]
    assert np.ptp(parallax) >= LEAST_SPAN
    assert (shown[first - 1 : first + 29] == true[first - 1]).all()


def test_a_drift_has_a_constant_speed_by_chance(ada):
    """Catches: a drift that is the true one, or of one ratio in every film."""
    ratios = []
    for seed in range(6):
        shown, true = shown_by(drift_on_sweep, ada, seed)
        assert np.ptp(np.diff(shown[:, 0])) < 1e-6
        ratios.append((shown[-1, 0] - shown[0, 0]) / (true[-1, 0] - true[0, 0]))
    assert np.ptp(ratios) > 1 and min(ratios) >= -2 and max(ratios) <= 3


def test_a_slide_show_rests_and_steps_to_true_places(ada):
    """Catches: photographs away from the trajectory; a step a frame early or late; a film at another rate."""
    shoot = Shoot(ada, 1000.0, 1, 240)
    filming, times = slides(0.25, 12.0)(shoot), np.arange(36) / 12
    shown, true = filming.motion(times).camera_mm, moving(shoot)(times).camera_mm
    assert filming.fps == 12.0 and filming.show is None
    assert shown == pytest.approx(np.repeat(true[::3], 3, axis=0))
