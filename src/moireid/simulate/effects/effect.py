"""An effect: what it changes of the scene, of the pictures, of their times, and of the file.

Convention: effects act in the order in which they are given, each on what the one before it left.  A camera's frames
are numbered from 0; those of the file are made of them by a `Timing`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Rect
from moireid.errors import SpecError
from moireid.simulate.motion import Poses
from moireid.simulate.recording.encode import Recipe
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
#: A picture (height, width) as one effect leaves it, from the camera frame's number and the picture before it.
Step = Callable[[int, Luma], Luma]


@dataclass(frozen=True)
class Take:
    """What an effect may know of a film before its first picture, for all T frames of the camera.

    pages (T, 3, 3): page mm -> px of the pictures that come in; poses: of the middle row; focal_px: of the camera;
    centre_mm: the middle of the gratings, page mm; outline_mm: of the board, x0, y0, x1, y1, page mm; size: width and
    height of the pictures that come in.
    """

    pages: Array
    poses: Poses
    focal_px: float
    centre_mm: tuple[float, float]
    outline_mm: Rect
    size: tuple[int, int]
    fps: float
    seed: int

    def __len__(self) -> int:
        """How many frames the camera takes."""
        return len(self.pages)

    @property
    def rng(self) -> np.random.Generator:
        """Chance of this film."""
        return np.random.default_rng(self.seed)

    @property
    def centres_px(self) -> Array:
        """Where the middle of the gratings is seen (T, 2)."""
        seen = self.pages @ np.array([*self.centre_mm, 1.0])
        return np.asarray(seen[:, :2] / seen[:, 2:])


@dataclass(frozen=True)
class Timing:
    """Which of the camera's frames, taken at `fps`, are mixed into each frame of the file, with their weights.

    Convention: numbers never fall by more than one from one frame of the file to the next.
    """

    fps: float
    parts: Sequence[Sequence[tuple[int, float]]]

    @property
    def count(self) -> int:
        """Of the camera's frames, from 0 to the last that is used."""
        return 1 + max(number for part in self.parts for number, _ in part)


@dataclass(frozen=True)
class Effect:
    """An effect ready to be used; a part that is None changes nothing.

    begin: from what is known of a film, the step for each picture, and what is known behind it; times: the timing of
    a film of so many frames at so many a second, by a seed; recipe: how the file is coded.
    """

    scene: Callable[[Scene], Scene] | None = None
    begin: Callable[[Take], tuple[Step, Take]] | None = None
    times: Callable[[int, float, int], Timing] | None = None
    recipe: Callable[[Recipe], Recipe] | None = None


@dataclass(frozen=True)
class Kind:
    """An effect with its figure at three strengths, light, ordinary and strong.

    what: what the figure is, with its unit; source: where figures come from; make: the effect of a figure.
    """

    name: str
    figures: tuple[float, float, float]
    what: str
    source: str
    make: Callable[[float], Effect]


def timing_of(effects: Sequence[Effect], frames: int, fps: float, seed: int) -> Timing:
    """Of a film with these effects.  Raises: SpecError where two of them retime it."""
    makers = [effect.times for effect in effects if effect.times]
    if len(makers) > 1:
        raise SpecError(f"{len(makers)} effects change the times of one film; give one of them, and film again")
    return makers[0](frames, fps, seed) if makers else Timing(fps, [((k, 1.0),) for k in range(frames)])


def begun(effects: Sequence[Effect], take: Take) -> tuple[list[Step], Take]:
    """The steps of all effects for one film, in order, and what is known behind the last."""
    steps: list[Step] = []
    for effect in effects:
        if effect.begin:
            step, take = effect.begin(take)
            steps.append(step)
    return steps, take


def alone(begin: Callable[[Take], Step]) -> Effect:
    """An effect on pictures that moves nothing within them."""
    return Effect(begin=lambda take: (begin(take), take))


def moved(take: Take, maps: Array, size: tuple[int, int]) -> Take:
    """What is known behind maps (T, 3, 3) from px to px of pictures of a size."""
    return replace(take, pages=maps @ take.pages, size=size)
