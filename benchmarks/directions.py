"""What directions a badge senses: run `.venv/bin/python benchmarks/directions.py [--axes x hex array] [--forgeries]`.

A camera moves in a straight line, to and fro, in directions 30 degrees apart in the badge's plane, and then as a hand
did.  Each piece of lens sheet has an offset and a twist of its own.  Printed are the verdict, the identity, and the
gain of each grating.  With --askew the pieces are turned by so many degrees, to either side in turns, and the badge
sways.  With --forgeries a badge of three gratings is forged in all ways, on a slanted trajectory and on the hand's.
With --dots: how far the fringe of a cell is off where a turned grating's lines are painted on dots.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

from moireid.badge import Badge, Cell, Grating
from moireid.designer import Request, design_badge
from moireid.frames import bounds_of
from moireid.simulate import Build, Scene, camera_named, film, motion_named
from moireid.simulate.forgeries.trajectories import KINDS
from moireid.simulate.motion import Motion, Poses, linear
from moireid.verifier import Claim, verify

PAYLOAD, RANGE_M = bytes.fromhex("0f5ac3962d784be1"), (0.8, 2.0)
DISTANCE_MM, FRAMES, FPS, SEED = 1200.0, 180, 30, 3
#: Offset, mm, and twist of each piece of sheet: a maker is asked for 0.3 degrees.
PIECES = tuple((offset_mm, math.radians(deg)) for offset_mm, deg in ((0.11, 0.15), (-0.2, -0.25), (0.05, 0.28)))
DIRECTIONS_DEG = (0, 30, 60, 90, 120, 150)
DPI = (300, 600, 1200)
#: Axes, and a lens array, which senses x and y at every point.
KINDS_OF_BADGE = ("x", "xy", "hex", "array")


def badge_of(kind: str) -> Badge:
    """The badge of one of `KINDS_OF_BADGE`."""
    request = Request("Bench", front="array", range_m=RANGE_M)
    return design_badge(request if kind == "array" else Request("Bench", axes=kind, range_m=RANGE_M), PAYLOAD)


def along(direction_deg: float) -> Motion:
    """The named motion `linear`, its course turned from x towards y."""
    level = linear(DISTANCE_MM, SEED)
    cosine, sine = math.cos(math.radians(direction_deg)), math.sin(math.radians(direction_deg))
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def poses(times_s: np.ndarray) -> Poses:
        found = level(times_s)
        # Turned about the view axis and back by the camera itself, which stays upright.
        return Poses(found.camera_mm @ turn.T, turn @ found.rotation @ turn.T)

    return poses


def judged(
    badge: Badge,
    motion: Motion,
    folder: Path,
    forge: str | None = None,
    placed: tuple[tuple[float, float], ...] = PIECES,
) -> str:
    """One film's outcome as a line."""
    video = folder / "film.mp4"
    offset_mm, twist_rad = placed[0]
    one = badge.lens.kind == "array"
    # The sheet of an array is one piece.
    pieces = {"lens_offset_mm": offset_mm, "twist_rad": twist_rad} if one else {"pieces": placed[: len(badge.gratings)]}
    build = Build(print_scale=1.002, print_aspect=1.001, lens_scale=0.9995, **pieces)
    scene = Scene(badge, build, camera_named("phone"))
    film(scene, motion, video, frames=FRAMES, fps=FPS, forge=forge, seed=SEED, overwrite=True)
    report = verify(video, Claim(badge, badge.id))
    gains = (
        f"{g['gain_ratio']:6.3f}" if g["excitation_rad"] > 0.1 else "     -"
        for g in report.invariant.to_json()["gratings"]
    )
    codes = ",".join(reason.code for reason in report.reasons if reason.level in ("undecided", "fail"))
    return f"{report.verdict:<13}{report.identity.verdict:<11} gains {' '.join(gains)}  {codes}"


def painted_phase_rad(badge: Badge, grating: Grating, cell: Cell, dot_mm: float) -> float:
    """Fringe phase of a cell whose lines are painted on the dots whose middles they cover, less that of the design."""
    frame = badge.frame_of(grating)
    x0, y0, x1, y1 = bounds_of(frame.corners_mm(cell.rect_mm))
    across, down = (
        (np.arange(math.floor(low / dot_mm), math.ceil(high / dot_mm)) + 0.5) * dot_mm
        for low, high in ((x0, x1), (y0, y1))
    )
    first, second = frame.places(np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)).T
    low, top, high, bottom = cell.rect_mm
    within = (first > low) & (first < high) & (second > top) & (second < bottom)
    place = first[within]
    ink = (place - cell.edge_mm) % cell.pitch_mm < cell.duty * cell.pitch_mm
    # Tapered, so that the lines that the cell's ends cut do not count.
    taper = np.sin(np.pi * (place - low) / (high - low)) ** 2
    middle = cell.edge_mm + cell.duty * cell.pitch_mm / 2
    return float(np.angle(((ink - ink.mean()) * taper * np.exp(-2j * np.pi * (place - middle) / cell.pitch_mm)).sum()))


def print_dots(badge: Badge) -> None:
    """The largest phase error of a turned cell for each resolution."""
    for dpi in DPI:
        worst = max(
            abs(painted_phase_rad(badge, grating, cell, 25.4 / dpi))
            for grating in badge.gratings
            if not isinstance(grating.axis, str)
            for cell in grating.cells
        )
        print(f"{dpi} dpi: the fringe of a turned cell is off by {worst:.4f} rad at most")


def print_askew(badges: dict[str, Badge], degrees: list[float]) -> None:
    """A line for each angle and kind of badge."""
    sway = motion_named("sway", distance_mm=1000.0, seed=SEED)
    with tempfile.TemporaryDirectory() as name:
        for askew, axes in product(degrees, ("x", "xy", "hex")):
            placed = tuple((offset, math.copysign(math.radians(askew), twist)) for offset, twist in PIECES)
            print(f"{askew:g}°  {axes:<5}{judged(badges[axes], sway, Path(name), placed=placed)}", flush=True)


def main() -> None:
    """One line a film."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--axes", nargs="+", choices=KINDS_OF_BADGE, default=KINDS_OF_BADGE)
    parser.add_argument("--forgeries", action="store_true", help="forge the badge of three gratings instead")
    parser.add_argument("--askew", nargs="+", type=float, metavar="DEG", help="turn the pieces by these angles instead")
    parser.add_argument("--dots", action="store_true", help="paint turned lines on dots instead")
    asked = parser.parse_args()
    badges = {axes: badge_of(axes) for axes in KINDS_OF_BADGE}
    if asked.dots:
        print_dots(badges["hex"])
        return
    if asked.askew:
        print_askew(badges, asked.askew)
        return
    hand = motion_named("handheld", distance_mm=DISTANCE_MM, seed=SEED)
    with tempfile.TemporaryDirectory() as name:
        if asked.forgeries:
            for kind in KINDS:
                for course, motion in (("30°", along(30.0)), ("a hand", hand)):
                    print(f"hex  {course:<7}{kind:<12}{judged(badges['hex'], motion, Path(name), kind)}", flush=True)
            return
        for axes in asked.axes:
            courses = {f"{degrees}°": along(degrees) for degrees in DIRECTIONS_DEG} | {"a hand": hand}
            for course, motion in courses.items():
                print(f"{axes:<6}{course:<7}{judged(badges[axes], motion, Path(name))}", flush=True)


if __name__ == "__main__":
    main()
