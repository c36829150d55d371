"""Where badge and camera are: a wearer who sways, a camera that walks, a measured hand.

A course says both poses in a world whose axes are those of a badge that faces the camera: x right, y down, z away from
the camera, origin at the badge, mm.  `Course.views` gives what a tracer needs: the camera in the badge's frame.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
#: Time (n,) -> six figures (n, 6): rotations about x, y and z in radians, then x, y and z in mm.
Six = Callable[[Array], Array]
KINDS = ("sway", "arc", "measured")
#: A real hand's run by motion capture, and a phone carried about a room; see THIRD_PARTY.md.  Data alone, nothing of
#: the simulator.
DATA = Path(__file__).parents[2] / "src" / "moireid" / "simulate" / "data"
MEASURED, WALK = DATA / "handheld_tum_fr1_xyz.csv", DATA / "phone_walk.csv"
#: How far the camera goes to either side in a measured run, as the tangent of its view.
REACH, WALK_REACH = 0.3, (0.2, 0.45)
#: How far the camera turns away from the badge at most in a walk, rad: the person who films keeps it in view.
MOST_TURN = 0.2


@dataclass(frozen=True)
class Course:
    """Poses over time; `kind` for people."""

    kind: str
    badge: Six
    camera: Six

    def views(self, t: Array) -> tuple[Array, Array]:
        """The camera's place (n, 3) in the badge's frame, mm, and the matrix (n, 3, 3) that turns its rays there."""
        back = _rotation(self.badge(t)).inv()
        place = back.apply(self.camera(t)[:, 3:] - self.badge(t)[:, 3:])
        return place, (back * _rotation(self.camera(t))).as_matrix()

    def in_badge(self, points: Array, t: Array) -> Array:
        """Points (..., 3) of the world in the badge's frame at one time (1,), mm."""
        found: Array = _rotation(self.badge(t)).inv().apply(points - self.badge(t)[:, 3:])
        return found

    def in_world(self, points: Array, t: Array) -> Array:
        """Points of the badge's frame in the world: the way back of `in_badge`."""
        found: Array = _rotation(self.badge(t)).apply(points) + self.badge(t)[:, 3:]
        return found

    def gaze(self, t: float) -> Array:
        """The camera's pose in the world at one time, (6,); the background is fixed there."""
        found: Array = self.camera(np.array([t]))[0]
        return found


def _rotation(six: Array) -> Rotation:
    """Yaw about y last, then pitch about x, then roll about z, as a head turns."""
    return Rotation.from_euler("YXZ", six[:, [1, 0, 2]])


def course(kind: str, distance_mm: float, seconds: float, rng: np.random.Generator) -> Course:
    """One of `KINDS`, or `walk`, at about that distance, with a tremor, and a badge that hangs at a slight angle."""
    hang = np.array([rng.uniform(-8, 8), rng.uniform(-4, 4), rng.uniform(-3, 3)]) * math.pi / 180
    if kind == "sway":
        badge, camera = _swaying(distance_mm, hang, rng), _held(distance_mm, rng)
    elif kind == "arc":
        badge, camera = _breathing(hang, rng), _walking(distance_mm, rng)
    elif kind in ("measured", "walk"):
        run = (MEASURED, REACH, np.inf) if kind == "measured" else (WALK, rng.uniform(*WALK_REACH), MOST_TURN)
        badge, camera = _breathing(hang, rng), _recorded(*run, distance_mm, seconds, rng)
    else:
        raise ValueError(f"motion {kind!r} is not known; choose one of {', '.join(KINDS)}")
    return Course(kind, badge, camera)


def _tremor(rng: np.random.Generator, degrees: float, mm: float) -> Six:
    """A hand's tremor: twelve sines each, 0.3 to 9 Hz, weaker as they get faster; root mean squares as given."""
    hz = np.exp(rng.uniform(math.log(0.3), math.log(9), (6, 12)))
    phase = rng.uniform(0, 2 * math.pi, (6, 12))
    size = rng.normal(size=(6, 12)) / hz
    size *= np.array([math.radians(degrees)] * 3 + [mm] * 3)[:, None] / np.sqrt(np.sum(size**2 / 2, axis=1))[:, None]

    def six(t: Array) -> Array:
        found: Array = np.einsum("ik,tik->ti", size, np.sin(2 * math.pi * hz * t[:, None, None] + phase))
        return found

    return six


def _waves(rng: np.random.Generator, sizes: Array, hz: float) -> Six:
    """Slow waves of those sizes, at about that frequency each, with a weaker one at about twice of it."""
    each = hz * rng.uniform(0.85, 1.15, 6)
    phase, second = rng.uniform(0, 2 * math.pi, (2, 6))
    ratio = rng.uniform(1.7, 2.4, 6)

    def six(t: Array) -> Array:
        angle = 2 * math.pi * each * t[:, None]
        found: Array = sizes * (np.sin(angle + phase) + 0.2 * np.sin(ratio * angle + second)) / 1.1
        return found

    return six


def _added(*parts: Six | Array) -> Six:
    def six(t: Array) -> Array:
        found: Array = sum(part(t) if callable(part) else np.broadcast_to(part, (len(t), 6)) for part in parts)  # type: ignore[assignment]
        return found

    return six


def _swaying(distance_mm: float, hang: Array, rng: np.random.Generator) -> Six:
    """A wearer who turns 15 to 25 degrees to either side and shifts from foot to foot."""
    turn, d = math.radians(rng.uniform(15, 25)), distance_mm
    shift = [rng.uniform(0.01, 0.05) * d, 0.01 * d, rng.uniform(0.005, 0.03) * d]
    sizes = np.array([0.25 * turn, turn, 0.12 * turn, *shift])
    return _added(_waves(rng, sizes, rng.uniform(0.2, 0.45)), np.array([*hang, 0, 0, 0]), _tremor(rng, 0.15, 0.7))


def _breathing(hang: Array, rng: np.random.Generator) -> Six:
    """A wearer who stays still."""
    sizes = np.array([math.radians(1.0), math.radians(1.5), math.radians(0.5), 3.0, 1.5, 2.0])
    return _added(_waves(rng, sizes, 0.3), np.array([*hang, 0, 0, 0]), _tremor(rng, 0.05, 0.3))


def _held(distance_mm: float, rng: np.random.Generator) -> Six:
    """A camera held still by a hand, not quite level, not quite in the middle."""
    aim = [rng.uniform(-0.06, 0.06), rng.uniform(-0.1, 0.1), rng.uniform(-0.05, 0.05)]
    place = np.array([*aim, 0.04 * distance_mm * rng.normal(), 0.05 * distance_mm * rng.normal(), -distance_mm])
    # It looks at the badge from where it is, except for the error of its aim.
    place[:2] += np.arctan2([place[4], -place[3]], distance_mm)
    return _added(place, _tremor(rng, 0.25, 2.0))


def _walking(distance_mm: float, rng: np.random.Generator) -> Six:
    """A camera that walks sideways in an arc of 15 to 20 degrees and back, with the bob of steps."""
    wide, hz = math.radians(rng.uniform(15, 20)), rng.uniform(0.12, 0.2)
    phase, step_hz, bob = rng.uniform(0, 2 * math.pi), rng.uniform(1.6, 2.1), rng.uniform(4, 15)
    # Nearby cameras are carried by an arm, and bob less.
    bob *= min(1.0, distance_mm / 1500)
    near, rise = rng.uniform(0.01, 0.06), rng.uniform(-0.1, 0.1)

    def six(t: Array) -> Array:
        angle = wide * (np.sin(2 * math.pi * hz * t + phase) + 0.1 * np.sin(5.3 * hz * t + 2 * phase))
        radius = distance_mm * (1 + near * np.sin(2 * math.pi * 0.7 * hz * t))
        y = rise * distance_mm + bob * np.sin(2 * math.pi * step_hz * t)
        x, z = radius * np.sin(angle), -radius * np.cos(angle)
        roll = 0.02 * np.sin(math.pi * step_hz * t)
        return np.stack([np.arctan2(y, radius), -angle, roll, x, y, z], axis=1)

    aim = np.array([rng.uniform(-0.04, 0.04), rng.uniform(-0.04, 0.04), rng.uniform(-0.05, 0.05), 0, 0, 0])
    slow = np.array([0.015, 0.02, 0.01, 0.0, 0.0, 0.0])
    return _added(six, aim, _waves(rng, slow, 0.3), _tremor(rng, 0.25, 1.5))


def _recorded(
    path: Path, most: float, most_turn: float, distance_mm: float, seconds: float, rng: np.random.Generator
) -> Six:
    """A stretch of a real hand's run, scaled so that the tangent of its view is `most`; the badge stays in view."""
    with path.open(encoding="utf-8") as file:
        rows = np.array([[float(v) for v in row.values()] for row in csv.DictReader(file)])
    # Half a second to spare at the end, for shutters.
    start = rng.uniform(0.1, max(rows[-1, 0] - seconds - 0.5, 0.2))
    rows = rows[(rows[:, 0] >= start - 0.1) & (rows[:, 0] <= start + seconds + 0.4)]
    turns = Rotation.from_quat(rows[:, 4:])
    level = turns.mean().inv()
    # In the mean camera's axes, which are those of a world that faces it.
    place, turned = level.apply(rows[:, 1:4] - rows[:, 1:4].mean(axis=0)), (level * turns).as_euler("YXZ")
    turned *= min(1.0, most_turn / np.abs(turned).max())
    # A hand's widest motion goes sideways here; up and down, and to and fro, at most half as far.
    wide = np.argsort(-place[:, :2].std(axis=0))
    place[:, :2] = place[:, wide]
    turned[:, :2] = turned[:, wide]
    reach = np.abs(place).max(axis=0)
    place *= most * distance_mm * np.minimum(1 / reach[0], np.array([1.0, 0.5, 0.4]) / reach)
    place[:, 2] -= distance_mm
    yaw, pitch = np.arctan2(-place[:, 0], -place[:, 2]), np.arctan2(place[:, 1], -place[:, 2])
    six = np.column_stack([pitch + 0.5 * turned[:, 1], yaw + 0.5 * turned[:, 0], turned[:, 2], place])
    return CubicSpline(rows[:, 0] - start, six)  # type: ignore[no-any-return]
