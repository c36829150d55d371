"""A take made up: a page that slides and turns a little before a camera, for tests of effects."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from moireid.simulate.effects.effect import Step, Take
from moireid.simulate.effects.table import effect_named
from moireid.simulate.motion import Poses

OUTLINE_MM = (0.0, 0.0, 100.0, 120.0)
SIZE, FOCAL_PX, AWAY_MM, CENTRE_MM = (640, 360), 480.0, 800.0, (50.0, 60.0)


def a_take(frames: int = 90, fps: float = 30.0, seed: int = 3) -> Take:
    """A camera that sways by 80 mm and shakes by 2 degrees before a page, whose middle lies at the board's origin."""
    times = np.arange(frames) / fps
    camera = np.column_stack([80 * np.sin(2 * times), 20 * np.cos(1.3 * times), np.full(frames, -AWAY_MM)])
    shake = np.radians(2.0) * np.column_stack([np.sin(7 * times), np.cos(9 * times), np.sin(8 * times)])
    turn = Rotation.from_rotvec(shake).as_matrix()
    lens = np.array([[FOCAL_PX, 0, (SIZE[0] - 1) / 2], [0, FOCAL_PX, (SIZE[1] - 1) / 2], [0, 0, 1]])
    board = np.array([[1, 0, -CENTRE_MM[0]], [0, 1, -CENTRE_MM[1]], [0, 0, 1.0]])
    local = np.stack([turn[:, :, 0], turn[:, :, 1], -np.einsum("tij,tj->ti", turn, camera)], axis=-1)
    return Take(lens @ local @ board, Poses(camera, turn), FOCAL_PX, CENTRE_MM, OUTLINE_MM, SIZE, fps, seed)


def step_of(name: str) -> Step:
    """What an effect of that name does to the pictures of `a_take`."""
    begin = effect_named(name).begin
    assert begin is not None
    return begin(a_take())[0]


def dotted(take: Take, number: int) -> np.ndarray:
    """A picture of a soft white dot, at the middle of the gratings, on grey."""
    (x, y), (width, height) = take.centres_px[number], take.size
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    dot = np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * 4.0**2))
    return np.asarray(np.rint(60 + 150 * dot), np.uint8)


def dot_of(luma: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Where the dot is within 30 px of a place (2,), px."""
    rows, columns = np.indices(luma.shape)
    weight = np.clip(luma.astype(float) - 90, 0, None) * (np.hypot(columns - near[0], rows - near[1]) < 30)
    return np.array([(weight * columns).sum(), (weight * rows).sum()]) / weight.sum()
