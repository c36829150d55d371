"""Where a clip's camera was, and trajectories that a forger chooses within what the clip shows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.simulate.motion import Motion, Poses, motion_named

Array = NDArray[np.float64]
#: Share by which the distance changes to either side, as in the measured hand's run.
DEPTH = 0.08
TREMOR_DEG = 0.4


def natural(name: str, distance_mm: float, seed: int) -> Motion:
    """A measured motion, begun at a moment that the seed chooses."""
    hand = motion_named(name, distance_mm=distance_mm, seed=seed)
    start = float(np.random.default_rng([seed, 3]).uniform(0, 15))
    return lambda times_s: hand(np.asarray(times_s) + start)


def lively(distance_mm: float, seed: int) -> Motion:
    """A hand's measured run, turned so that it goes sideways and up or down alike; the camera looks at the badge.

    It begins where its first two seconds move the badge most, of some moments that the seed draws: the forger takes a
    clip in which something moves.
    """
    hand = motion_named("handheld", distance_mm=distance_mm, seed=seed)
    rng = np.random.default_rng([seed, 6])
    turn = Rotation.from_euler("z", rng.choice([-1.0, 1.0]) * rng.uniform(30, 60), degrees=True)
    shake = _tremor(rng)

    def begun(start: float) -> Motion:
        def motion(times_s: Array) -> Poses:
            return aimed(turn.apply(hand(np.asarray(times_s) + start).camera_mm), shake(times_s))

        return motion

    span = np.linspace(0, 2, 21)
    every = [begun(start) for start in rng.uniform(0, 15, 8).tolist()]
    return max(every, key=lambda motion: np.ptp(motion(span).camera_mm[:, :2], axis=0).min())


def swaying(views: Array, distance_mm: float, seed: int, *, depth: float = 0.0) -> Motion:
    """Sideways and up and down, all over the parallaxes of some views (N, 3), and nearer and farther by a share."""
    rng = np.random.default_rng([seed, 4])
    low, high = views[:, :2].min(axis=0), views[:, :2].max(axis=0)
    # An axis of each: sideways, up and down, nearer and farther.
    hz, start = np.stack([rng.uniform(0.2, 0.4, 3), rng.uniform(0.5, 0.8, 3)]), rng.uniform(0, 2 * np.pi, (2, 3))
    shake = _tremor(rng)

    def motion(times_s: Array) -> Poses:
        t = 2 * np.pi * np.asarray(times_s)[:, None]
        waves = 0.75 * np.sin(t * hz[0] + start[0]) + 0.25 * np.sin(t * hz[1] + start[1])
        away = distance_mm * (1 + depth * waves[:, 2:])
        parallax = (low + high) / 2 + waves[:, :2] * (high - low) / 2
        return aimed(np.column_stack([parallax * away, -away]), shake(times_s))

    return motion


def _tremor(rng: np.random.Generator) -> Callable[[Array], Array]:
    """Small turns (T, 3) of a hand, rad."""
    turns, start = 2 * np.pi * rng.uniform(0.3, 3.0, (8, 3)), rng.uniform(0, 2 * np.pi, (8, 3))
    return lambda times_s: (
        np.radians(TREMOR_DEG) * np.sin(np.asarray(times_s)[:, None, None] * turns + start).mean(axis=1)
    )


def to_and_fro(motion: Motion, length_s: float, *, speed: float = 0.8) -> Motion:
    """A motion's first seconds, forth and back, at another speed: the same way, and never a new view."""
    span = length_s - 0.05
    return lambda times_s: motion(span - np.abs(np.mod(speed * np.asarray(times_s), 2 * span) - span))


def aimed(camera_mm: Array, error_rad: Array) -> Poses:
    """Upright cameras at (T, 3) that look at the board's centre, but for small turns (T, 3)."""
    forward = -camera_mm / np.linalg.norm(camera_mm, axis=1, keepdims=True)
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    upright = np.stack([right, np.cross(forward, right), forward], axis=1)
    return Poses(camera_mm, Rotation.from_rotvec(error_rad).as_matrix() @ upright)
