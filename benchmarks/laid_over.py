"""A few true photographs of a badge, superposed: run `moireid lab bench laid-over`.

N photographs are taken evenly over one turn of the fringes.  Each frame shows all of them, each as strongly as the
fringes' place asks: (1 + 2 a cos(place - its own)) / N.  Then the fundamental is right in any place, over any number of
turns, and blurred ones have no third harmonic that could betray them.  With 2 b cos(3 (place - its own)) added, five
are right in the third harmonic too: such films are known to pass, at a lower contrast.  So are films of blurred ones
whose fringes a tone curve makes steep.  The badge is turned on the spot, so that the fringes do not show its distance,
before a camera that is in focus or not.  `third` is the third harmonic that turns with the fringes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.lenticule import view_law
from moireid.simulate.filming import Show
from moireid.simulate.forgeries.rear_layer import ShownViews, SquaredUp
from moireid.simulate.motion import Motion, Poses
from moireid.simulate.scene import Build, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.forgers.forgers_suite import CAMERA, badge_of
from moireid_lab.bench.part import OWN, Asked, Part, Row, film_row, temporary_film

Array = NDArray[np.float64]
FRAMES, FPS, CRF, PX_PER_MM = 240, 30.0, 23, 4.0
TANGENTS = np.linspace(-1.2, 1.2, 4801)


@dataclass(frozen=True)
class Superposition:
    """count: of photographs, 0 for a true film; strength: a; third: b; turns: of the fringes, over which the badge is
    turned; curve: steepness of a tone curve; soft_px: blur of the camera's focus."""

    count: int
    metres: float
    strength: float = 1.0
    blur_mm: float = 0.0
    turns: float = 1.0
    third: float = 0.0
    curve: float = 0.0
    soft_px: float = 0.0

    @property
    def name(self) -> str:
        """In a few words."""
        blurred = f", blurred over {self.blur_mm:g} mm" if self.blur_mm else ""
        third = f" and {self.third:g}" if self.third else ""
        blurred += f", curve {self.curve:g}" if self.curve else ""
        blurred += f", {self.soft_px:g} px out of focus" if self.soft_px else ""
        what = (
            f"{self.count} superposed, strength {self.strength:g}{third}{blurred}"
            if self.count
            else f"a true film{blurred}"
        )
        return f"{what}, {self.turns:g} turns, {self.metres:g} m"


WAYS = ((1.0, 1.0), (1.4, 0.5))
ALL = (
    *(Superposition(3, metres) for metres in (1.0, 2.0)),
    *(Superposition(3, 2.5, 0.5, turns=turns) for turns in (0.3, 0.6, 1.0)),
    Superposition(3, 1.0, turns=0.3),
    *(Superposition(3, metres, strength, 8.6) for metres in (1.0, 1.4) for strength in (0.5, 1.0)),
    Superposition(3, 1.0, blur_mm=8.6, turns=0.3),
    *(Superposition(5, 2.5, strength) for strength in (0.5, 1.0)),
    *(Superposition(6, 2.0, turns=turns) for turns in (0.5, 1.0)),
    *(Superposition(count, 2.0, 0.5) for count in (4, 7, 8)),
    *(Superposition(count, metres, 0.25, third=0.25) for count in (5, 7) for metres in (1.0, 2.0)),
    *(Superposition(3, metres, strength, 8.6, curve=curve) for metres, strength in WAYS for curve in (1.5, 3.0)),
    *(Superposition(count, 1.0, 1.0, 8.6 * (count > 0), soft_px=px) for count in (3, 0) for px in (1.0, 1.5, 2.5)),
    *(Superposition(3, 1.0, soft_px=px) for px in (1.0, 1.5, 2.5)),
    *(Superposition(0, metres, turns=turns) for metres in (1.0, 2.0, 2.5) for turns in (0.3, 1.0)),
)


def phases_of(badge: Badge) -> Array:
    """The fringes' phase at each of `TANGENTS`, rad."""
    law = view_law(badge.lens, badge.gratings[0].pitch_mm)
    return np.asarray(law.phase_rad(TANGENTS, np.zeros_like(TANGENTS)))


def turned_on_the_spot(badge: Badge, case: Superposition, seed: int) -> Motion:
    """The badge is turned to and fro before a camera that never looks quite at its middle."""
    order = np.argsort(phases_of(badge))
    half = np.arctan(abs(np.interp(np.pi * case.turns, phases_of(badge)[order], TANGENTS[order])))
    distance = 1000 * case.metres

    def motion(times_s: Array) -> Poses:
        t = 2 * np.pi * np.asarray(times_s)
        yaw = half * (0.78 * np.sin(0.21 * t + seed) + 0.22 * np.sin(0.53 * t + 2 * seed))
        pitch = np.radians(2) * np.sin(0.37 * t + 1)
        centre = distance * np.column_stack([np.sin(yaw) * np.cos(pitch), np.sin(pitch), -np.cos(yaw) * np.cos(pitch)])
        aim = np.column_stack([40 * np.sin(0.31 * t + seed), 25 * np.sin(0.23 * t), np.zeros_like(t)])
        z = aim - centre
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        x = np.cross([0.0, 1.0, 0.0], z)
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        return Poses(centre, np.stack([x, np.cross(z, x), z], axis=1))

    return motion


def field_of(scene: Scene) -> tuple[slice, slice]:
    """Rows and columns of the fringes in a flat picture."""
    left, top, *_ = scene.badge.outline_mm
    x0, y0, x1, y1 = np.rint(PX_PER_MM * np.subtract(scene.badge.gratings[0].rect_mm, (left, top) * 2)).astype(int)
    return slice(y0, y1), slice(x0, x1)


def photographs(scene: Scene, case: Superposition) -> tuple[Array, list[Array]]:
    """The fringes' phase in each photograph, rad, and the photographs, coded as pictures are."""
    phases = phases_of(scene.badge)
    order = np.argsort(phases)
    taken = 2 * np.pi * (np.arange(case.count) - (case.count - 1) / 2) / case.count
    flat = SquaredUp(scene, PX_PER_MM)
    places = [np.array([np.interp(at, phases[order], TANGENTS[order]), 0.0, -1.0]) * 1000 * case.metres for at in taken]
    pictures = [np.sqrt(flat.picture(place)) for place in places]
    if case.blur_mm:
        width = round(PX_PER_MM * case.blur_mm)
        for picture in pictures:
            field = np.ascontiguousarray(picture[field_of(scene)])
            picture[field_of(scene)] = cv2.blur(field, (width, 1), borderType=cv2.BORDER_REFLECT)
    return taken, pictures


def superposed(case: Superposition) -> Show:
    """What shows them in a film, as `simulate.filming.film` takes it."""

    def show(scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        taken, pictures = photographs(scene, case)
        place = np.interp(camera_mm[:, 0] / np.abs(camera_mm[:, 2]), TANGENTS, phases_of(scene.badge))
        away = place[:, None] - taken
        shares = (1 + 2 * case.strength * np.cos(away) + 2 * case.third * np.cos(3 * away)) / case.count
        straight = np.tile([0.0, 0.0, -1000 * case.metres], (len(camera_mm), 1))

        def picture(frame: int) -> NDArray[np.float32]:
            mixed = sum(share * one for share, one in zip(shares[frame], pictures, strict=True))
            light = np.asarray(np.square(mixed), np.float32)
            if case.curve:
                field = light[field_of(scene)]
                middle, size = field.mean(), math.sqrt(2) * field.std()
                light[field_of(scene)] = middle + size * np.tanh(case.curve * (field - middle) / size)
            return light

        return ShownViews(straight, camera_mm, picture=picture)

    return show


def judged(job: tuple[Superposition, int], folder: Path) -> Row:
    """Make one film; what becomes of it."""
    case, seed = job
    badge, show = badge_of("x"), superposed(case) if case.count else None
    camera = replace(CAMERA, focus_blur_px=case.soft_px)
    scene, motion = Scene(badge, Build.typical(seed), camera), turned_on_the_spot(badge, case, seed)
    with temporary_film(scene, motion, frames=FRAMES, fps=FPS, show=show, seed=seed, crf=CRF) as video:
        report = verify(video, Question(badge, badge.id))
    third = next((one for one in report.reasons if one.code == "third_harmonic"), None)
    kind = f"{case.count} superposed" if case.count else "a true film"
    kind += (
        ", third harmonic" if case.third else ", tone curve" if case.curve else ", out of focus" if case.soft_px else ""
    )
    return film_row(kind, report, true=case.count == 0, third=third and third.measured)


def cases(asked: Asked) -> dict[str, tuple[Superposition, int]]:
    """All films."""
    return {f"{case.name}|{seed}": (case, seed) for seed in range(1, 1 + (asked.clips or 1)) for case in ALL}


QUESTIONS = {
    "forged": "Is a film of three to eight superposed photographs rejected?",
    "genuine": "Is a true film accepted that is turned on the spot, also out of focus?",
}
PART = Part(QUESTIONS, OWN, cases, judged, 2)
