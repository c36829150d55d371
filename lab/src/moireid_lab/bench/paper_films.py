"""The films of the paper's experiments (Qing et al. 2026): boards, trajectories, and stand-ins for what cannot be had.

As stated there: a board of 8 x 10 inch, 160 lines of 0.52 mm under a sheet of 50 lines an inch 1 mm thick, markers at
the corners; the renderings' camera, from 0.5 m aside to straight in front in 120 frames, at seven distances, ten
profiles of small turns, all markers in view; which fields, frames and turns A to D have.

Not stated, and our reading: markers of 36 mm, white around them for a sixth of that; the camera looks straight ahead,
which at 1.1 m just keeps all markers in view, and its turns have 0.5 degrees (root mean square); rendered pictures are
coded almost without loss (CRF 4); the board turns by 30 degrees in B (steadily, then to and fro), and by up to 12 about
each axis in D; in A and D the camera goes once round a circle of 0.4 m.

Stand-ins: no recording and no generated film can be had.  For recordings there are this project's simulated phone films
in twelve settings and outdoors, for generated films fringes that know nothing of the law.  Both are shorter than the
paper's, 3 s at 30 and 4 s at 24 or 25 frames a second, as 179 films of 8 to 14 s take hours here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge, Cell, Grating, Lens, Markers
from moireid.simulate.build import Build
from moireid.simulate.cameras import CAMERAS, Camera
from moireid.simulate.effects.table import effect_named
from moireid.simulate.forgeries.rear_layer import ShownViews, SquaredUp
from moireid.simulate.light import light_named
from moireid.simulate.motion import Motion, Poses, motion_named
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
PITCH_MM, LINES = 0.52, 160
SHEET = Lens("lenticular", 0.508, 1.0, 1.56)
DISTANCES_M = (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
IDEAL = CAMERAS["ideal"]
#: Of 720 rows, where the paper films 1080: those take a minute each here.
PHONE = Camera(1280, 720, 966.7)
#: Widths and heights of the generators' films, and frames a second.
GENERATORS = {"Grok": (848, 480, 24), "LTX-2": (1920, 1080, 25), "Veo": (1280, 720, 24)}
#: How many films of each generator the paper keeps.
KEPT = {"Grok": 36, "LTX-2": 21, "Veo": 35}
FALSE = ("drift", "frozen", "randomwalk", "patchy", "generative", "key pictures")


@dataclass(frozen=True)
class PaperFilm:
    """One film: its set and name, what is filmed and how.

    how: for `simulate.filming.film`; compensated: whether the published pipeline leaves rotation out; known: whether it
    is given the focal length; marked: the region's corners are given by hand.
    """

    set: str
    name: str
    scene: Scene
    motion: Motion
    how: dict[str, Any] = field(default_factory=dict)
    compensated: bool = True
    known: bool = False
    marked: bool = False


def board(axes: str = "x", *, page_mm: tuple[float, float] = (203.2, 254.0), marker_mm: float = 36.0) -> Badge:
    """The board, with a uniform field of 160 lines, or two orthogonal ones above each other."""
    width, tall = LINES * PITCH_MM, LINES * PITCH_MM if len(axes) == 1 else 70.0
    x0, gratings = (page_mm[0] - width) / 2, []
    for axis, middle in zip(axes, (0.5,) if len(axes) == 1 else (0.35, 0.65), strict=True):
        y0 = middle * page_mm[1] - tall / 2
        rect = (x0, y0, x0 + width, y0 + tall)
        cell = Cell(rect, PITCH_MM, x0 if axis == "x" else y0, 0.5)
        gratings.append(Grating(rect, "x" if axis == "x" else "y", PITCH_MM, "uniform", (cell,)))
    near = marker_mm / 2 + marker_mm / 6
    right, low = page_mm[0] - near, page_mm[1] - near
    markers = Markers("DICT_4X4_50", marker_mm, (0, 1, 2, 3), ((near, near), (right, near), (right, low), (near, low)))
    return Badge(None, "Published board", page_mm, SHEET, tuple(gratings), markers)


def turning(seed: int, degrees: float) -> Callable[[Array], Array]:
    """Small smooth turns (T, 3) about the camera's axes with this root mean square, rad: sums of eight sines."""
    rng = np.random.default_rng(seed)
    rate, start = rng.uniform(0.3, 4.0, (8, 3)), rng.uniform(0, 2 * math.pi, (8, 3))
    return lambda times: math.radians(degrees) / 2 * np.sin(2 * math.pi * rate * times[:, None, None] + start).sum(1)


def path(
    metres: float,
    place: Callable[[Array], Array],
    board_deg: Callable[[Array], Array] | None = None,
    shake: Callable[[Array], Array] | None = None,
) -> Motion:
    """A camera that looks straight ahead, at places (T, 2) mm, before a board turned by (T, 3) degrees.

    Convention: turns are rotation vectors about x, y and z of the room, as `simulate.motion.Poses` has them.
    """

    def poses(times: Array) -> Poses:
        camera = np.column_stack([place(times), np.full(len(times), -1000 * metres)])
        still = np.zeros((len(times), 3))
        held = Rotation.from_rotvec(np.radians(board_deg(times)) if board_deg else still)
        looks = Rotation.from_rotvec(shake(times) if shake else still)
        return Poses(held.inv().apply(camera), (looks * held).as_matrix())

    return poses


def swept(times: Array) -> Array:
    """From 0.5 m aside to straight in front, in 120 frames at 60 a second."""
    x = 500.0 * (1 - times / (119 / 60))
    return np.column_stack([x, np.zeros_like(x)])


def levelled(times: Array) -> Array:
    """From 150 mm on the one side to as far on the other in 4 s."""
    return np.outer(times - 2.0, [75.0, 0.0])


def circled(seconds: float) -> Callable[[Array], Array]:
    """Once round a circle of 0.4 m."""
    return lambda times: 200.0 * np.column_stack([f(2 * math.pi * times / seconds) for f in (np.cos, np.sin)])


def about(axis: int, angle_deg: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """Turns (T, 3) about one axis."""
    return lambda times: np.eye(3)[axis] * angle_deg(times)[:, None]


def renderings() -> Iterator[PaperFilm]:
    """Rendering 1 and 2, and A to D."""
    how = {"frames": 120, "fps": 60.0, "crf": 4}
    scene, both = Scene(board(), camera=IDEAL), Scene(board("xy"), camera=IDEAL)
    for profile in range(10):
        for metres in DISTANCES_M:
            name = f"rendering 1, {metres:g} m, profile {profile}"
            yield PaperFilm("rendering 1", name, scene, path(metres, swept, shake=turning(profile, 0.5)), how)
    for metres in DISTANCES_M:
        name = f"rendering 2, {metres:g} m"
        yield PaperFilm("rendering 2", name, scene, path(metres, swept), how, compensated=False)
    yield PaperFilm("A", "A", both, path(1.2, circled(3.0)), how | {"frames": 180}, compensated=False)
    steady, to_and_fro = (lambda t: 15 * t), (lambda t: 30 * np.sin(math.pi * t))
    for number, angle in enumerate((steady, to_and_fro), start=1):
        yield PaperFilm(f"B, trajectory {number}", f"B{number}", scene, path(1.2, swept, about(2, angle)), how)
    yield PaperFilm("C", "C", scene, path(1.2, swept, about(2, lambda t: np.full_like(t, 45.0))), how)
    rates = 2 * math.pi * np.array([0.29, 0.37, 0.23])
    turns = path(1.2, circled(4.0), lambda t: 12 * np.sin(rates * t[:, None] + [0.9, 0.0, 2.1]))
    yield PaperFilm("D", "D", both, turns, how | {"frames": 240})


def causes() -> Iterator[PaperFilm]:
    """Rendering 1 at three distances, with one condition changed in each set: what makes it fall with distance?"""
    how = {"frames": 120, "fps": 60.0, "crf": 4}
    small = Scene(board(page_mm=(140.0, 140.0), marker_mm=24.0), camera=IDEAL)
    whole = Scene(board(), camera=IDEAL)
    for profile in range(2):
        for metres in DISTANCES_M[::3]:
            motion = path(metres, swept, shake=turning(profile, 0.5))
            for words, scene, other, more in (
                ("a board of 140 mm", small, {}, {}),
                ("coded as a phone does, CRF 23", whole, {"crf": 23}, {}),
                ("both of these", small, {"crf": 23}, {}),
                ("focal length known", whole, {}, {"known": True}),
                ("no rotation compensation", whole, {}, {"compensated": False}),
            ):
                yield PaperFilm(
                    f"cause: {words}", f"{words}, {metres:g} m, {profile}", scene, motion, how | other, **more
                )
    for metres in DISTANCES_M[::3]:
        yield PaperFilm("cause: no turns", f"no turns, {metres:g} m", whole, path(metres, swept), how)


def recordings() -> Iterator[PaperFilm]:
    """Stand-ins for the 87 recordings: camera, badge or both move; 75 indoors in twelve settings, 12 outdoors."""
    for number in range(87):
        metres, outdoors = 1.0 + 0.5 * (number % 5), number % 7 == 6
        place = None if outdoors else ("desk", "worn", "lectern", "call")[number // 3 % 4]
        light = "sun" if outdoors else ("even", "window", "lamp")[number // 12 % 3]
        kind = ("walk", "sway", "both")[number % 3]
        scene = Scene(board(), Build.typical(number), PHONE, light=light_named(light))
        effects = [effect_named("exposure:light")] + ([effect_named("eis:light")] if kind == "walk" else [])
        how = {"frames": 90, "fps": 30.0, "setting": place, "effects": effects}
        motion = motion_named(kind, distance_mm=1000 * metres, seed=number)
        yield PaperFilm(
            "real (stand-ins)", f"real {number}: {kind}, {place or 'outdoors'}, {light}", scene, motion, how
        )


def generated() -> Iterator[PaperFilm]:
    """Stand-ins for the 92 generated films: a level motion one way, and fringes that know nothing of it."""
    makers = [name for name, count in KEPT.items() for _ in range(count)]
    for number, maker in enumerate(np.random.default_rng(0).permutation(makers).tolist()):
        kind, (width, height, fps) = FALSE[number % len(FALSE)], GENERATORS[maker]
        scene = Scene(board(), camera=Camera(width, height, 0.755 * width, shutter_s=0.0))
        motion = path(1.1, levelled, shake=turning(number, 0.3))
        how: dict[str, Any] = {"frames": 4 * fps, "fps": float(fps)}
        how |= {"show": KeyPictures(number).shown} if kind == "key pictures" else {"forge": kind}
        yield PaperFilm(
            "generated (stand-ins)", f"generated {number}: {maker}, {kind}", scene, motion, how, marked=True
        )


@dataclass(frozen=True)
class KeyPictures:
    """Pictures of the fringes from random places, one a second, that melt into each other in the order of time."""

    seed: int

    def shown(self, scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        """As `simulate.filming.Show`."""
        squared, rng = SquaredUp(scene, 3.0), np.random.default_rng(self.seed)
        away = float(np.abs(camera_mm[:, 2]).mean())
        keys = [
            np.sqrt(squared.picture(np.array([x, 0.0, -away])))
            for x in rng.uniform(-200, 200, 2 + int(len(camera_mm) / fps))
        ]

        def show(frame: int) -> NDArray[np.float32]:
            key, share = divmod(frame / fps, 1.0)
            mixed = np.float32(1 - share) * keys[int(key)] + np.float32(share) * keys[int(key) + 1]
            return np.asarray(mixed**2, np.float32)

        return ShownViews(camera_mm, camera_mm, picture=show)


def every_film() -> dict[str, PaperFilm]:
    """All films by name; stand-ins of both sets take turns, so that a run that is cut short has some of each."""
    real, false = list(recordings()), list(generated())
    mixed = [film for pair in zip(real, false, strict=False) for film in pair] + false[len(real) :]
    return {film.name: film for film in (*renderings(), *causes(), *mixed)}
