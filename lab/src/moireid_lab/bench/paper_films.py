"""The films of the paper's experiments (Qing et al. 2026): boards, trajectories, and stand-ins for what cannot be had.

As stated there: a board of 8 x 10 inch, 160 lines of 0.52 mm under a sheet of 50 lines an inch 1 mm thick, markers at
the corners; the renderings' camera, from 0.5 m aside to straight in front in 120 frames, at seven distances, ten
profiles of small turns, all markers in view; which fields, frames and turns A to D have.

Not stated, and our reading: markers of 36 mm, white around them for a sixth of that; the camera looks straight ahead,
which at 1.1 m just keeps all markers in view, and its turns have 0.5 degrees (root mean square); rendered pictures are
coded almost without loss (CRF 4); the board turns by 30 degrees in B (steadily, then to and fro), and by up to 12 about
each axis in D; in A and D the camera goes once round a circle of 0.4 m.

One film of each set is path-traced too, with as few samples as leave an error of 0.02 rad.

Stand-ins: no recording and no generated film can be had.  For recordings there are this project's simulated phone films
in twelve settings and outdoors.  For generated films there are fringes that know nothing of the law: they drift, stay,
wander, boil in patches, change their spacing, follow the place in the picture at another rate, melt or morph from one
picture to the next.  Both are shorter than the paper's, 3 s at 30 and 4 s at 24 or 25 frames a second, as 179 films of
8 to 14 s take hours here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import cv2
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
from moireid_lab.bench.part import interleaved

Array = NDArray[np.float64]
Picture = NDArray[np.float32]
PAGE_MM, MARKER_MM = (203.2, 254.0), 36.0
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
FALSE = ("drift", "frozen", "randomwalk", "patchy", "generative", "place", "melt", "morph")


@dataclass(frozen=True)
class PaperFilm:
    """One film: its set and name, what is filmed and how.

    how: for `simulate.filming.film`; compensated: whether the published pipeline leaves rotation out; known: whether it
    is given the focal length; marked: the region's corners are given by hand; true: the fringes are the badge's own.
    """

    set: str
    name: str
    scene: Scene
    motion: Motion
    how: dict[str, Any] = field(default_factory=dict)
    compensated: bool = True
    known: bool = False
    marked: bool = False
    true: bool = True


def board(axes: str = "x") -> Badge:
    """The board, with a uniform field of 160 lines, or two orthogonal ones above each other."""
    width, tall = LINES * PITCH_MM, LINES * PITCH_MM if len(axes) == 1 else 70.0
    x0, gratings = (PAGE_MM[0] - width) / 2, []
    for axis, middle in zip(axes, (0.5,) if len(axes) == 1 else (0.35, 0.65), strict=True):
        y0 = middle * PAGE_MM[1] - tall / 2
        rect = (x0, y0, x0 + width, y0 + tall)
        cell = Cell(rect, PITCH_MM, x0 if axis == "x" else y0, 0.5)
        gratings.append(Grating(rect, "x" if axis == "x" else "y", PITCH_MM, "uniform", (cell,)))
    near = MARKER_MM / 2 + MARKER_MM / 6
    right, low = PAGE_MM[0] - near, PAGE_MM[1] - near
    markers = Markers("DICT_4X4_50", MARKER_MM, (0, 1, 2, 3), ((near, near), (right, near), (right, low), (near, low)))
    return Badge(None, "Published board", PAGE_MM, SHEET, tuple(gratings), markers)


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


def traced() -> Iterator[PaperFilm]:
    """The first film of each set of the renderings, path-traced."""
    for one in {one.set: one for one in reversed(list(renderings()))}.values():
        how = one.how | {"backend": "mitsuba", "error_rad": 0.02}
        yield replace(one, set=f"{one.set}, path-traced", name=f"{one.name}, path-traced", how=how)


def causes() -> Iterator[PaperFilm]:
    """Rendering 1 at three distances, with one condition changed in each set: what makes it fall with distance?"""
    films = {one.name: one for one in renderings()}
    for metres in DISTANCES_M[::3]:
        one = films[f"rendering 1, {metres:g} m, profile 0"]
        changes: dict[str, dict[str, Any]] = {
            "coded as a phone does, CRF 23": {"how": one.how | {"crf": 23}},
            "focal length known": {"known": True},
            "no rotation compensation": {"compensated": False},
            "no turns": {"motion": path(metres, swept)},
        }
        for words, change in changes.items():
            yield replace(one, set=f"cause: {words}", name=f"{words}, {metres:g} m", **change)


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
        own = {"place": FollowedPlace(number).shown, "melt": KeyPictures(number).shown}
        own |= {"morph": MorphedPictures(number).shown}
        how |= {"show": own[kind]} if kind in own else {"forge": kind}
        name = f"generated {number}: {maker}, {kind}"
        yield PaperFilm("generated (stand-ins)", name, scene, motion, how, marked=True, true=False)


@dataclass(frozen=True)
class FollowedPlace:
    """Fringes that follow the badge's place in the picture, 0.3 to 3 times as far as the law, either way."""

    seed: int

    def shown(self, scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        """As `simulate.filming.Show`."""
        rng = np.random.default_rng(self.seed)
        rate = rng.choice([-1.0, 1.0]) * math.exp(rng.uniform(math.log(0.3), math.log(3.0)))
        badge = -np.einsum("tij,tj->ti", motion(np.arange(len(camera_mm)) / fps).rotation, camera_mm)
        false = camera_mm.copy()
        false[:, :2] = -rate * badge[:, :2] / badge[:, 2:] * np.abs(camera_mm[:, 2:])
        return ShownViews(false, camera_mm)


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

        def show(frame: int) -> Picture:
            key, share = divmod(frame / fps, 1.0)
            return np.asarray(self.between(keys[int(key)], keys[int(key) + 1], share) ** 2, np.float32)

        return ShownViews(camera_mm, camera_mm, picture=show)

    def between(self, before: Picture, after: Picture, share: float) -> Picture:
        """The picture of a share of the way from one to the next."""
        return np.asarray((1 - share) * before + share * after, np.float32)


class MorphedPictures(KeyPictures):
    """The same, morphed: each picture is moved along the optical flow to the next, as far as the time has come."""

    def between(self, before: Picture, after: Picture, share: float) -> Picture:
        """As `KeyPictures.between`."""
        return super().between(carried(before, after, share), carried(after, before, 1 - share), share)


def carried(start: Picture, end: Picture, share: float) -> Picture:
    """A picture, moved a share of the way along its optical flow to another."""
    here, there = (np.asarray(np.clip(255 * one, 0, 255), np.uint8) for one in (start, end))
    flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM).calc(here, there, np.zeros((*here.shape, 2)))
    rows, columns = np.indices(start.shape, np.float32)
    places = columns - share * flow[..., 0], rows - share * flow[..., 1]
    return np.asarray(cv2.remap(start, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)


@cache
def every_film() -> dict[str, PaperFilm]:
    """All films by name, sets mixed, so that a run that is cut short has its share of each."""
    makers = (renderings, traced, causes, recordings, generated)
    return interleaved(*({one.name: one for one in made()} for made in makers))
