"""What a film shows of the badge, frame by frame: the truth, or a forgery of any kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.simulate.forgeries.courses import COURSES, KINDS, false_camera
from moireid.simulate.forgeries.flat import PHOTO_PX_PER_MM, SCREEN_PX_PER_MM, SquaredUp, held_frames
from moireid.simulate.forgeries.patches import Generative, OwnClocks
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
#: A false place this near the true one, mm, at every frame shows the same fringes, within 0.001 rad from 0.5 m on.
SAME_MM = 0.01


@dataclass(frozen=True)
class Shown:
    """camera_mm (T, 3): from where the fringes are shown; sight_mm (T, 3): from where the sheet above the page is seen.

    The two differ where only the fringes are forged.  A flat picture has both from the place where it was taken.
    field, picture: of a frame, as in `scene.Instant`.
    """

    camera_mm: Array
    sight_mm: Array
    field: Callable[[int], Array | None] = lambda frame: None
    picture: Callable[[int], NDArray[np.float32] | None] = lambda frame: None


def shown_in(kind: str | None, scene: Scene, motion: Motion, camera_mm: Array, fps: float, seed: int) -> Shown:
    """What is shown in a film.

    Parameters: kind: one of `courses.KINDS`, None for a true film; camera_mm (T, 3): the true centres of every frame.
    Convention: the board frame of `motion`.
    Raises: SpecError for an unknown kind, and for a false course that equals the true one.
    Source: `courses`, `patches` and `flat`.
    """
    if kind is None:
        return Shown(camera_mm, camera_mm)
    if kind in COURSES:
        false_mm = false_camera(kind, camera_mm, fps, seed)
        # A course has the true one's spread; if that is zero, a film labelled as forged would show the truth.
        if np.abs(false_mm - camera_mm).max() < SAME_MM:
            raise SpecError(
                f"a {kind} forgery of this motion shows the true fringes, as the camera does not move enough; "
                "choose another motion, a longer film, or another forgery"
            )
        return Shown(false_mm, camera_mm)
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
        return Shown(held, held, picture=_Replay(SquaredUp(scene, SCREEN_PX_PER_MM), held).at)
    raise SpecError(f"forgery {kind!r} is not known; choose one of {', '.join(KINDS)}")


class _Replay:
    """The screen's picture at each frame; a picture that is held is computed once."""

    def __init__(self, screen: SquaredUp, held_mm: Array) -> None:
        self._screen, self._held = screen, held_mm
        # No place equals NaN, so the first picture is always computed.
        self._place: Array = np.full(3, np.nan)
        self._picture = np.empty((0, 0), np.float32)

    def at(self, frame: int) -> NDArray[np.float32]:
        """Radiance (rows, columns) over the board."""
        place = self._held[frame]
        if not np.array_equal(place, self._place):
            self._place, self._picture = place, self._screen.picture(place)
        return self._picture
