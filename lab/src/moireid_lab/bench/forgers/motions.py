"""Trajectories of attacks, in addition to those of `simulate.motion`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.motion import Motion, Poses, motion_named

Array = NDArray[np.float64]


def one_way(distance_mm: float, seed: int, *, length_s: float, reach_mm: float = 250.0) -> Motion:
    """One steady sweep sideways, as the published renderings and prompts ask for; the camera's hand trembles a little.

    Source: Qing et al. 2026, "strictly horizontally at constant speed".
    """
    tremor = motion_named("linear", distance_mm=distance_mm, seed=seed)
    rng = np.random.default_rng(seed)
    way = reach_mm * float(rng.choice([-1.0, 1.0])) * rng.uniform(0.8, 1.2)

    def poses(times_s: Array) -> Poses:
        shaken = tremor(times_s)
        share = 2 * times_s / length_s - 1
        camera = np.column_stack([way * share, np.zeros_like(share), np.full_like(share, -distance_mm)])
        # The tremor of the linear course, about the new direction.
        straight = np.arctan2(-camera[:, 0], distance_mm) - np.arctan2(-shaken.camera_mm[:, 0], distance_mm)
        cos, sin = np.cos(straight), np.sin(straight)
        turn = np.zeros((len(times_s), 3, 3))
        turn[:, 0, 0], turn[:, 0, 2], turn[:, 2, 0], turn[:, 2, 2], turn[:, 1, 1] = cos, -sin, sin, cos, 1.0
        return Poses(camera, shaken.rotation @ turn)

    return poses


def in_turns(distance_mm: float, seed: int, *, tangents: Array, hold_s: float, gap_s: float = 0.0) -> Motion:
    """The badge held at one view after another, with plain cuts between, or gaps in which it is out of the picture.

    tangents: parallax coordinates along x of the views; a hand's sway of 1 cm lies over each.
    """
    sway = motion_named("handheld", distance_mm=distance_mm, seed=seed)
    away = math.radians(60.0)

    def poses(times_s: Array) -> Poses:
        hand = sway(times_s)
        turn_s = hold_s + gap_s
        # Many frames lie on a cut, and rounding must not put some before it and some behind.
        number, within_s = np.divmod(times_s + 1e-6, turn_s)
        gone = within_s >= hold_s
        angle = np.arctan(np.asarray(tangents)[number.astype(int) % len(tangents)])
        small = hand.camera_mm * [0.1, 0.1, 0.0] + [0.0, 0.0, -distance_mm]
        cos, sin = np.cos(angle), np.sin(angle)
        camera = np.column_stack(
            [cos * small[:, 0] - sin * small[:, 2], small[:, 1], sin * small[:, 0] + cos * small[:, 2]]
        )
        rotation = np.empty((len(times_s), 3, 3))
        for k, (a, leave) in enumerate(zip(angle.tolist(), gone.tolist(), strict=True)):
            turn = a + (away if leave else 0.0)
            c, s = math.cos(turn), math.sin(turn)
            rotation[k] = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        return Poses(camera, rotation)

    return poses


def in_steps(motion: Motion, hold_s: float) -> Motion:
    """The same course, of which each place is held for so long."""
    # Many frames lie on a step, and rounding must not put some before it and some behind.
    return lambda times_s: motion(np.floor(np.asarray(times_s) / hold_s + 1e-6) * hold_s)
