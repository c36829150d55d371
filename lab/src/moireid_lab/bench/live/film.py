"""A simulated person before a webcam: a true badge that follows prompts, before a picture of a face.

Convention: camera frame in mm, x right in the picture, y down, z forward; the camera stands still.
Source: the analytic renderer; the course from place to place is that of least jerk, which hands come near to (Flash and
Hogan 1985).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge
from moireid.simulate.analytic.renderer import AnalyticRenderer
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Camera, Instant, Scene
from moireid.verifier.live.challenge import FACE, WAYS, Prompt

Array = NDArray[np.float64]
#: A laptop's camera, and where the badge is held before it.
WEBCAM = Camera(width=1280, height=720, focal_px=900.0, noise_counts=2.0)
REST_MM = np.array([0.0, 70.0, 640.0])
#: How far a hand goes when it is asked to, sideways, upright and in depth, mm, and how long it takes.
GOES_MM, TAKES_S = (180.0, 80.0, 120.0), 0.9
#: How far a hand turns the badge as it carries it sideways and upright, rad/mm: 7 degrees for 20 cm.
TURNS = math.radians(7.0) / 200.0
#: Tremor: place, mm, and angle, rad, and rates, Hz.
TREMOR_MM, TREMOR_RAD, TREMOR_HZ = 1.5, math.radians(0.7), (0.4, 0.9, 1.7)


@dataclass(frozen=True)
class Answer:
    """Places (K + 1, 3) mm of the badge, and when it sets out for each but the first (K,), s."""

    places_mm: Array
    set_out_s: Array

    def place_mm(self, time_s: float) -> Array:
        """Where the badge is."""
        return course_place_mm(self.places_mm, self.set_out_s, time_s)


class Moving(Protocol):
    """Whatever says where the badge is."""

    def place_mm(self, time_s: float) -> Array:
        """(3,) mm at a time."""
        ...


def course_place_mm(places_mm: Array, set_out_s: Array, time_s: float) -> Array:
    """Where a badge is that sets out for each place but the first; parameters as the fields of `Answer`."""
    way = np.clip((time_s - set_out_s) / TAKES_S, 0, 1)
    share = way**3 * (10 - 15 * way + 6 * way**2)
    return np.asarray(places_mm[0] + share @ np.diff(places_mm, axis=0))


def answer(prompts: Sequence[Prompt], face_mm: Array, *, reaction_s: float = 0.5) -> Answer:
    """The course of a person who follows prompts.  face_mm (2,): place of the face in the badge's plane at rest."""
    places = [REST_MM]
    for prompt in prompts:
        place = places[-1].copy()
        if prompt.move == FACE:
            place[:2] = face_mm * place[2] / REST_MM[2]
        else:
            axis, sign = WAYS[prompt.move]
            # The person's left is the picture's right; up and nearer are less of y and z.
            place[axis] += sign * GOES_MM[axis] * (1 if axis == 0 else -1)
        places.append(place)
    return Answer(np.array(places), np.array([prompt.at_s for prompt in prompts]) + reaction_s)


def frames(
    badge: Badge,
    behind: NDArray[np.uint8],
    course: Moving,
    *,
    length_s: float,
    fps: float = 24.0,
    seed: int = 0,
    frozen: bool = False,
) -> Iterator[NDArray[np.uint8]]:
    """Grey pictures of the badge before `behind` (height, width), one at a time.

    Parameters: frozen: a forged badge, whose fringes do not move.
    """
    scene = Scene(badge, Build.typical(seed), WEBCAM)
    renderer, rng = AnalyticRenderer(scene), np.random.default_rng(seed)
    noise = rng.standard_normal((WEBCAM.height + 64, WEBCAM.width + 64)).astype(np.float32) * WEBCAM.noise_counts
    phases = rng.uniform(0, 2 * math.pi, (6, len(TREMOR_HZ)))
    shown = None
    for number in range(round(length_s * fps)):
        time_s = number / fps
        tremor = np.sin(2 * math.pi * np.array(TREMOR_HZ) * time_s + phases).mean(axis=1)
        place = course.place_mm(time_s) + TREMOR_MM * tremor[3:]
        carried = place - REST_MM
        turn = Rotation.from_rotvec(TREMOR_RAD * tremor[:3] + TURNS * np.array([-carried[1], carried[0], 0.0]))
        camera = turn.inv().apply(-place)
        shown = camera if shown is None or not frozen else shown
        poses = Poses(camera[None], turn.as_matrix()[None])
        board = renderer.render(Instant(poses, poses, shown))
        picture = behind.astype(np.float32)
        if board is not None:
            rows = slice(board.top, board.top + board.radiance.shape[0])
            columns = slice(board.left, board.left + board.radiance.shape[1])
            # A camera codes light by about its square root.
            light = board.coverage * board.radiance + (1 - board.coverage) * (picture[rows, columns] / 255) ** 2
            picture[rows, columns] = 255 * np.sqrt(np.clip(light, 0, 1))
            picture[rows, columns] = cv2.GaussianBlur(picture[rows, columns], (0, 0), 0.6)
        y, x = rng.integers(0, 64, 2)
        picture += noise[y : y + WEBCAM.height, x : x + WEBCAM.width]
        yield np.clip(np.rint(picture), 0, 255).astype(np.uint8)
