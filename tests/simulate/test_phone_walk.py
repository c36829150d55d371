"""A phone's measured walk, changed to a walk around the badge.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from moireid.simulate.motion import motion_named
from moireid.simulate.phone_walk import DEPTH, RISE, TANGENT, around_badge, fast_turns_rad, to_and_fro_s

#: Longer than the run to and fro.
LONG_S = np.arange(0, 100, 1 / 30)


@pytest.mark.parametrize("distance_mm", [700.0, 2300.0])
def test_the_walk_reaches_its_tangent_at_any_distance(distance_mm):
    """Catches: a walk in millimetres, whose badge leaves the picture nearby; a reach that counts both sides."""
    camera = motion_named("walk", distance_mm=distance_mm, seed=3)(LONG_S).camera_mm
    view = np.abs(camera[:, :2] / -camera[:, 2:]).max(axis=0)
    assert view[0] == pytest.approx(TANGENT, abs=1e-3) and 0.01 < view[1] <= RISE * TANGENT
    assert np.abs(-camera[:, 2] / distance_mm - 1).max() == pytest.approx(TANGENT * DEPTH, abs=1e-3)


def test_the_badge_stays_in_the_picture():
    """Catches: the phone's look about the room kept in its aim; a camera that does not turn at all."""
    poses = motion_named("walk", distance_mm=1000.0, seed=3)(LONG_S)
    seen = -np.einsum("tij,tj->ti", poses.rotation, poses.camera_mm)
    # A picture of 1280 x 720 reaches to 0.66 and 0.37; the badge is 0.1 wide to either side of its centre.
    off = np.abs(seen[:, :2] / seen[:, 2:])
    assert np.all(off.max(axis=0) < [0.5, 0.25]) and np.all(off.std(axis=0) > 0.02)
    roll = np.degrees(np.arctan2(poses.rotation[:, 1, 0], poses.rotation[:, 0, 0]))
    assert 1 < np.std(roll) < 5 and np.abs(roll).max() < 15


def test_the_seed_chooses_where_in_the_run_a_film_begins():
    """Catches: a seed that is not used; one that changes the path."""
    one, other = (motion_named("walk", distance_mm=1000.0, seed=seed) for seed in (5, 6))
    start = [np.random.default_rng(seed).uniform(0.0, 45.96667) for seed in (5, 6)]
    later = np.arange(3.0) + 2.0
    assert np.abs(one(later).camera_mm - other(later).camera_mm).max() > 10
    apart = start[0] - start[1]
    # The later one meets the other's path where its time is reached.
    early, late = (one, other) if apart < 0 else (other, one)
    assert late(later).camera_mm == pytest.approx(early(later + abs(apart)).camera_mm, abs=1e-3)


def test_no_step_is_faster_than_a_hand():
    """Catches: a jump where the run ends; quaternions of both signs in one mean, which turn a camera right round."""
    poses = motion_named("walk", distance_mm=1000.0, seed=3)(LONG_S)
    assert np.linalg.norm(np.diff(poses.camera_mm, axis=0), axis=1).max() * 30 < 250
    turned = Rotation.from_matrix(poses.rotation[1:] @ np.swapaxes(poses.rotation[:-1], 1, 2))
    assert np.degrees(turned.magnitude()).max() * 30 < 120


def test_time_goes_to_and_fro_without_a_jump_in_speed():
    """Catches: time that turns round at once; one that leaves the run."""
    times = np.arange(0, 25, 0.01)
    clock = to_and_fro_s(times, 10.0)
    assert clock.min() == pytest.approx(0.25) and clock.max() == pytest.approx(9.75)
    assert to_and_fro_s(np.array([3.0, 17.0, 23.0]), 10.0) == pytest.approx(3.0)
    speed = np.diff(clock) / 0.01
    assert speed[300] == pytest.approx(1) and speed[1700] == pytest.approx(-1)
    assert np.abs(np.diff(speed)).max() < 0.025


def test_a_walk_to_the_right_of_who_looks_is_one_to_positive_x():
    """Catches: a mirrored path; heights that count down; near and far exchanged.  World x right, y up, z backwards."""
    places = np.array([[-1000.0, 0, 0], [1000.0, 0, 0], [0.0, 100, 0], [0.0, -100, 0], [0.0, 0, 500], [0.0, 0, -500]])
    left, right, high, low, far, near = around_badge(places)
    assert left == pytest.approx([-TANGENT, 0, -1]) and right == pytest.approx([TANGENT, 0, -1])
    assert high == pytest.approx([0, -TANGENT / 10, -1]) and low == pytest.approx([0, TANGENT / 10, -1])
    assert far[2] == pytest.approx(-1 - TANGENT * DEPTH) and near[2] == pytest.approx(-1 + TANGENT * DEPTH)


def test_heights_reach_no_farther_than_their_share():
    """Catches: a limit on heights that is left out, with which a climb would leave the picture."""
    places = np.array([[-1000.0, 0, 0], [1000.0, 0, 0], [0.0, 900, 0], [0.0, -900, 0], [0.0, 0, 10], [0.0, 0, -10]])
    assert np.abs(around_badge(places)[:, 1]).max() == pytest.approx(RISE * TANGENT)


@pytest.mark.parametrize(("phone_axis", "axis"), [((0, -1, 0), 0), ((1, 0, 0), 1), ((0, 0, 1), 2)])
def test_a_fast_turn_is_halved_and_turned_upright(phone_axis, axis):
    """Catches: turns about the axes of a phone that lies on its side; turns the wrong way; slow turns that are kept.

    The phone's right is its camera's -y, its down is +x.  Turning back and forth at 2 Hz is fast, a tilt is slow.
    """
    times = np.arange(0, 12, 1 / 30)
    swing = 0.1 * np.sin(4 * np.pi * times)
    held = Rotation.from_euler("x", 40, degrees=True) * Rotation.from_rotvec(swing[:, None] * np.array(phone_axis))
    quaternions = held.as_quat()
    quaternions[100:200] *= -1
    found = fast_turns_rad(times, quaternions)
    # `_aimed` turns what is seen, the other way round than the camera.
    assert found[60:-60, axis] == pytest.approx(-0.5 * swing[60:-60], abs=2e-3)
    assert np.abs(np.delete(found, axis, axis=1)).max() < 1e-6
