"""Attacks, each a film that an attacker who reads this code would make, and true films on their trajectories."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from moireid.badge import Badge
from moireid.simulate.filming import Show
from moireid.simulate.forgeries.rear_layer import ShownViews
from moireid.simulate.motion import Motion, motion_named
from moireid.simulate.scene import Scene
from moireid.simulate.shots import Edit
from moireid_lab.bench.forgers.edits import ShiftedMarkers
from moireid_lab.bench.forgers.motions import in_steps, in_turns, one_way
from moireid_lab.bench.forgers.photographs import Photographs, still

Make = Callable[["Shoot"], "Filming"]
FPS = 30.0
#: Span of the parallax in a spell of frozen fringes: 5 cm at 1 m turn the default badge's by 0.36 rad.
LEAST_SPAN = 0.05


@dataclass(frozen=True)
class Shoot:
    """What a case is filmed with: badge, distance, seed, frames."""

    badge: Badge
    distance_mm: float
    seed: int
    frames: int

    @property
    def length_s(self) -> float:
        """Of the film."""
        return self.frames / FPS

    def motion(self, name: str) -> Motion:
        """A named motion at this distance."""
        return motion_named(name, distance_mm=self.distance_mm, seed=self.seed)

    @property
    def rng(self) -> np.random.Generator:
        """Chance of this film."""
        return np.random.default_rng(self.seed)


@dataclass(frozen=True)
class Filming:
    """How a case is filmed: where the camera is, what is shown in place of the truth, frames per second, and what is
    done to the pictures."""

    motion: Motion
    show: Show | None = None
    fps: float = FPS
    edit: Edit | None = None


@dataclass(frozen=True)
class ForgeryCase:
    """name: as in the table; genuine: whether it shows a badge as it is; axes: of the badge; make: how it is filmed."""

    name: str
    genuine: bool
    make: Make
    axes: str = "x"


def moving(shoot: Shoot) -> Motion:
    """A hand's or a body's motion, by the seed."""
    if shoot.seed % 2:
        return shoot.motion("sway")
    hand, start = shoot.motion("handheld"), float(shoot.rng.uniform(0, 15))
    return lambda times_s: hand(times_s + start)


def level(shoot: Shoot) -> Motion:
    """Sideways to and fro at one distance, which does not test the fringes' spacing: the forger's best trajectory."""
    return shoot.motion("linear")


def photographs(count: int, *, course: Callable[[Shoot], Motion] = moving, **how: Any) -> Make:
    """Photographs in place of the fringes, on a hand's motion or another."""

    def make(shoot: Shoot) -> Filming:
        taken = replace(Photographs(count), **how)
        return Filming(course(shoot), taken.shown)

    return make


def slid(course: Callable[[Shoot], Motion] = moving) -> Make:
    """One photograph whose rows are slid by the law for each frame, cells included; their spacing stays.

    This is the best that such a forger can do: no seam, no blur.  If he also stretches the rows by the distance, the
    film obeys the law, and no rule here can detect it.
    """

    def make(shoot: Shoot) -> Filming:
        def show(scene: Scene, motion: Motion, camera_mm: Any, fps: float) -> ShownViews:
            away = np.abs(camera_mm[:, 2:])
            return ShownViews(camera_mm / away * away.mean(), camera_mm)

        return Filming(course(shoot), show)

    return make


def still_in_turns(gap_s: float) -> Make:
    """One photograph shown at two views a whole turn of fringe phase apart."""

    def make(shoot: Shoot) -> Filming:
        turn = turn_tangent(shoot.badge)
        motion = in_turns(
            shoot.distance_mm, shoot.seed, tangents=np.array([-turn / 2, turn / 2]), hold_s=0.8, gap_s=gap_s
        )
        return Filming(motion, still(np.array([0.0, 0.0, -shoot.distance_mm])))

    return make


def slides(hold_s: float, fps: float = FPS) -> Make:
    """A slide show of true photographs from the trajectory: page and fringes stay still, and then step together."""
    return lambda shoot: Filming(in_steps(moving(shoot), hold_s), fps=fps)


def turn_tangent(badge: Badge) -> float:
    """Difference of parallax that turns the fringes once, about the front view."""
    from moireid.lenticule import view_law

    pitch = badge.gratings[0].pitch_mm
    tangents = np.linspace(0.1, 0.6, 2001)
    phase = view_law(badge.lens, pitch).phase_rad(tangents, np.zeros_like(tangents))
    return 2 * float(np.interp(np.pi, np.abs(phase), tangents))


def frozen_in_spells(share: float, shift_px: float) -> Make:
    """Fringes that stay still for a share of the frames, in spells of half a second, the markers shifted there."""

    def make(shoot: Shoot) -> Filming:
        spell = round(0.5 * FPS)
        starts = set(shoot.rng.permutation(shoot.frames // spell)[: round(share * shoot.frames / spell)].tolist())

        def show(scene: Scene, motion: Motion, camera_mm: Any, fps: float) -> ShownViews:
            held = camera_mm.copy()
            for frame in range(len(held)):
                if frame // spell in starts:
                    held[frame] = held[max(spell * (frame // spell) - 1, 0)]
            return ShownViews(held, camera_mm)

        shifted = ShiftedMarkers(shoot.badge, shift_px, lambda frame: frame // spell in starts)
        return Filming(moving(shoot), show, edit=shifted)

    return make


def spell(seconds: float) -> Make:
    """Fringes that stay still for some seconds within a true film, while they should move.

    The seconds are drawn from those whose parallax spans `LEAST_SPAN`; where the badge rests, a frozen picture is true.
    """

    def make(shoot: Shoot) -> Filming:
        def show(scene: Scene, motion: Motion, camera_mm: Any, fps: float) -> ShownViews:
            frames = round(seconds * FPS)
            parallax = np.lib.stride_tricks.sliding_window_view(camera_mm[:, 0] / camera_mm[:, 2], frames)
            span = np.ptp(parallax, axis=1)
            moving_ones = np.flatnonzero(span >= min(LEAST_SPAN, span.max()))
            first = int(shoot.rng.choice(moving_ones))
            held = camera_mm.copy()
            held[first : first + frames] = held[first]
            return ShownViews(held, camera_mm)

        return Filming(moving(shoot), show)

    return make


def attacks() -> Iterator[tuple[str, Make]]:
    """What forgers film, by name; the counts of photographs are swept."""
    yield "one photograph in turns, plain cuts", still_in_turns(0.0)
    yield "one photograph in turns, gaps", still_in_turns(0.5)
    for hold_s, fps in ((0.2, 30.0), (0.25, 12.0), (0.5, 12.0), (0.5, 8.0)):
        yield f"photographs for {hold_s:g} s each, {fps:g} frames a second", slides(hold_s, fps)
    for counts, words, how in (
        ((3, 5, 8, 12, 18, 24, 36, 48, 64, 96), "photographs, cross-faded", {}),
        ((8, 16, 24, 48, 96, 192), "photographs, nearest", {"blend": False}),
        ((3, 5, 8, 12, 18, 24, 36), "photographs from each of two distances, cross-faded", {"distances": 2}),
    ):
        for count in counts:
            yield f"{count} {words}", photographs(count, **how)
    yield "one photograph, slid by the law", slid()
    yield "one photograph, slid by the law, level course", slid(level)
    for count in (3, 5, 8, 12, 18, 24, 36):
        yield f"{count} photographs, cross-faded, level course", photographs(count, course=level)
    for share in (0.25, 0.5):
        yield f"frozen for {100 * share:.0f} % of the frames, markers shifted", frozen_in_spells(share, 0.8)
    for seconds in (0.5, 1.0, 2.0):
        yield f"frozen for {seconds:g} s", spell(seconds)
    for count in (12, 48):
        yield f"{count} photographs, cross-faded, two axes, whole", photographs(count)


def plain() -> Iterator[tuple[str, Make]]:
    """True films on the same trajectories, by name."""
    yield "plain", lambda shoot: Filming(moving(shoot))
    yield "plain, two axes", lambda shoot: Filming(moving(shoot))
    yield "level course", lambda shoot: Filming(level(shoot))
    yield "one sweep", lambda shoot: Filming(one_way(shoot.distance_mm, shoot.seed, length_s=shoot.length_s))


def cases() -> list[ForgeryCase]:
    """All of them; those of two axes say so in their name."""
    return [
        ForgeryCase(name, genuine, make, "xy" if "two axes" in name else "x")
        for genuine, some in ((False, attacks()), (True, plain()))
        for name, make in some
    ]
