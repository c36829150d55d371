"""A forger with N photographs of a badge: each frame shows the nearest of them, or two of them cross-faded.

The picture of a badge with one axis depends on one parallax, so photographs from N places are a table of it.  The
forger is a good one: he knows from where each picture was taken, squares it up without error, and reads it without
noise.  What he cannot do is to change the fringes within a picture.

Convention: parallax coordinates u = Cx/|Cz| and v = Cy/|Cz| of the board's centre; pictures are radiance (rows,
columns) over the whole board, as `scene.Instant.picture`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.forgeries.rear_layer import ShownViews, SquaredUp
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
Picture = NDArray[np.float32]
#: Fineness of the photographs; a camera of 1450 px focal length sees 1.5 px to the mm at 1 m.
PX_PER_MM = 4.0


@dataclass(frozen=True)
class Photographs:
    """What the forger has and does.

    count: photographs, evenly spaced over the trajectory that is to be shown; blend: cross-fade two neighbours in coded
    brightness, as editing programs do, else show the nearest; distances: from how many distances the photographs were
    taken, evenly over those of the trajectory, so that there are `count` from each; one is the trajectory's mean.
    """

    count: int
    blend: bool = True
    distances: int = 1

    def shown(self, scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        """The film that these photographs make of a course."""
        true = camera_mm[:, :2] / np.abs(camera_mm[:, 2:])
        away = np.abs(camera_mm[:, 2])
        distance = float(away.mean())
        taken = np.linspace(away.min(), away.max(), self.distances) if self.distances > 1 else np.array([distance])
        tables = [Table(scene, true, self.count, each) for each in taken.tolist()]
        # Spacing goes with one over the distance, so the shares of two distances do.
        level = np.interp(-1 / away, -1 / taken, np.arange(len(taken)))
        held = np.column_stack([true * distance, np.full(len(true), -distance)])

        def show(frame: int) -> Picture:
            nearer = min(int(level[frame]), max(len(tables) - 2, 0))
            share = np.float32(level[frame] - nearer if self.blend else round(level[frame] - nearer))
            some = [(1 - share, tables[nearer]), *([(share, tables[nearer + 1])] if share else [])]
            pictures = [weight * table.at(float(true[frame, 0]), blend=self.blend) for weight, table in some]
            return np.asarray(sum(pictures[1:], start=pictures[0]) ** 2, np.float32)

        return ShownViews(held, camera_mm, picture=show)


class Table:
    """Photographs along the diagonal of a course's parallax: places (N, 2)."""

    def __init__(self, scene: Scene, course: Array, count: int, distance_mm: float) -> None:
        low, high = course.min(axis=0), course.max(axis=0)
        steps = np.linspace(0, 1, count)[:, None] if count > 1 else np.full((1, 1), 0.5)
        self.places = low + steps * (high - low)
        squared = SquaredUp(scene, PX_PER_MM)
        # Coded as a camera codes them, since they are cross-faded so.
        self._coded = [
            np.sqrt(squared.picture(np.array([*(place * distance_mm), -distance_mm]))) for place in self.places
        ]

    def at(self, wanted: float, *, blend: bool) -> Picture:
        """One picture, in coded brightness, for the parallax along x."""
        places = self.places[:, 0]
        place = float(np.interp(wanted, places, np.arange(len(places)))) if len(places) > 1 else 0.0
        if not blend:
            return self._coded[round(place)]
        first = min(int(place), max(len(places) - 2, 0))
        share = np.float32(place - first)
        if share == 0:
            return self._coded[first]
        return np.asarray((1 - share) * self._coded[first] + share * self._coded[first + 1], np.float32)


def still(place_mm: Array) -> Callable[[Scene, Motion, Array, float], ShownViews]:
    """One photograph, shown in every frame, wherever the camera is."""

    def shown(scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        picture = SquaredUp(scene, PX_PER_MM).picture(place_mm)
        held = np.broadcast_to(place_mm, camera_mm.shape)
        return ShownViews(held, camera_mm, picture=lambda frame: picture)

    return shown
