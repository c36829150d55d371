"""What a film shows of the badge, frame by frame: the truth, or a forgery of any kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.simulate.flat import PHOTO_PX_PER_MM, SCREEN_PX_PER_MM, SquaredUp, held_frames
from moireid.simulate.forge import COURSES, KINDS, false_camera
from moireid.simulate.motion import Motion
from moireid.simulate.patches import Generative, OwnClocks
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shown:
    """camera_mm (T, 3): from where the fringes are shown; sight_mm (T, 3): from where the sheet above the page is seen.

    The two differ in a film whose fringes alone are forged.  A flat picture holds both from the place it was taken.
    field, picture: of a frame, as in `scene.Instant`.
    """

    camera_mm: Array
    sight_mm: Array
    field: Callable[[int], Array | None] = lambda frame: None
    picture: Callable[[int], NDArray[np.float32] | None] = lambda frame: None


def shown_in(kind: str | None, scene: Scene, motion: Motion, camera_mm: Array, fps: float, seed: int) -> Shown:
    """What is shown in a film.

    Parameters: kind: one of `forge.KINDS`, None for a true film; camera_mm (T, 3): the true centres of every frame.
    Convention: the board frame of `motion`.
    Raises: SpecError for a kind that is none.
    Source: `forge`, `patches` and `flat`.
    """
    if kind is None:
        return Shown(camera_mm, camera_mm)
    if kind in COURSES:
        return Shown(false_camera(kind, camera_mm, fps, seed), camera_mm)
    if kind == "patchy":
        clocks = OwnClocks(motion, seed)
        return Shown(camera_mm, camera_mm, field=lambda frame: clocks.at(frame / fps))
    if kind == "generative":
        made_up = Generative(scene.badge, camera_mm, fps, seed)
        return Shown(made_up.camera_mm, camera_mm, field=made_up.at)
    if kind == "photo":
        place = np.array([0.0, 0.0, camera_mm[0, 2]])
        photograph = SquaredUp(scene, PHOTO_PX_PER_MM).picture(place)
        held = np.broadcast_to(place, camera_mm.shape)
        return Shown(held, held, picture=lambda frame: photograph)
    if kind == "screen":
        held = false_camera("splice", camera_mm, fps, seed)[held_frames(len(camera_mm), fps)]
        return Shown(held, held, picture=_replay(SquaredUp(scene, SCREEN_PX_PER_MM), held))
    raise SpecError(f"forgery {kind!r} is not known; choose one of {', '.join(KINDS)}")


def _replay(screen: SquaredUp, held: Array) -> Callable[[int], NDArray[np.float32]]:
    """The screen's picture at each frame; one that is held is not made again."""
    last: list[tuple[bytes, NDArray[np.float32]]] = []

    def picture(frame: int) -> NDArray[np.float32]:
        place = held[frame].tobytes()
        if not last or last[0][0] != place:
            last[:] = [(place, screen.picture(held[frame]))]
        return last[0][1]

    return picture
