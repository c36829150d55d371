"""The eleven scenes on which the renderers are compared with the outside tracer, and the views of each."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Cell, Grating, Lens, Markers
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Camera, Instant, Scene

Array = NDArray[np.float64]
#: View tangents of the ordinary views; the steep one is at 60 degrees.
TANGENTS = (-0.4, -0.2, 0.05, 0.25, 0.4)
STEEP_TANGENT = math.tan(math.radians(60))
#: Side of the lens sheet on the bench's board, mm.
SIDE_MM = 60.0


@dataclass(frozen=True)
class SceneSetting:
    """One scene: its badge, how it is built, the distance, and the camera's turn about its own sight line."""

    name: str
    badge: Badge
    build: Build = field(default_factory=Build)
    distance_mm: float = 1000.0
    roll_deg: float = 0.0
    camera: Camera = field(default_factory=Camera)

    @property
    def scene(self) -> Scene:
        """The scene that a renderer takes."""
        return Scene(self.badge, self.build, self.camera)

    def seen_at(self, tangent: float, other: float = 0.1) -> Instant:
        """The frame seen along that tangent across the first grating's lenses, and `other` along them."""
        along_x = self.badge.gratings[0].axis == "x"
        u, v = (tangent, other) if along_x else (other, tangent)
        return aimed(np.array([-u, -v, -1.0]) * self.distance_mm / math.sqrt(1 + u * u + v * v), self.roll_deg)


def aimed(camera_mm: Array, roll_deg: float = 0.0) -> Instant:
    """A frame whose camera looks at the board's centre, turned about its sight line."""
    forward = -camera_mm / np.linalg.norm(camera_mm)
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right)
    upright = np.stack([right, np.cross(forward, right), forward])
    c, s = math.cos(math.radians(roll_deg)), math.sin(math.radians(roll_deg))
    turned = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ upright
    poses = Poses(camera_mm[None], turned[None])
    return Instant(poses, poses, camera_mm)


def board(lens: Lens, rear_pitch_mm: float, axes: str = "x", duty: float = 0.5) -> Badge:
    """A board with one uniform grating, or with one of each axis side by side; markers at the corners."""
    margin, gap, size = 16.0, 4.0, 12.0
    width = len(axes) * (SIDE_MM + gap) - gap
    gratings = []
    for number, axis in enumerate(axes):
        x0 = margin + number * (SIDE_MM + gap)
        rect = (x0, margin, x0 + SIDE_MM, margin + SIDE_MM)
        edge = (x0 if axis == "x" else margin) + 0.1
        cells = (Cell(rect, rear_pitch_mm, edge, duty),)
        gratings.append(Grating(rect, "x" if axis == "x" else "y", rear_pitch_mm, "none", cells))
    page = (width + 2 * margin, SIDE_MM + 2 * margin)
    a, b, c = size / 2 + 1, page[0] - size / 2 - 1, page[1] - size / 2 - 1
    markers = Markers("DICT_4X4_50", size, (0, 1, 2, 3), ((a, a), (b, a), (b, c), (a, c)))
    return Badge(None, "Bench", page, lens, tuple(gratings), markers)


def eleven() -> list[SceneSetting]:
    """The scenes, from the published prototype's sheet to thick, thin, coarse, masked, turned and far ones."""
    sheet = Lens("lenticular", 0.508, 1.0, 1.56)
    thick, thin = Lens("lenticular", 0.508, 3.0, 1.56), Lens("lenticular", 0.3387, 0.67, 1.56)
    coarse = Lens("lenticular", 0.635, 1.25, 1.49)
    flat = Lens("lenticular", 0.508, 1.2, 1.56, radius_mm=0.6)
    mask = Lens("mask", 0.508, 1.5, 1.49)
    built = Build(0.13, math.radians(0.25), 1.002, 0.999, print_aspect=0.998)
    return [
        SceneSetting("prototype, 1 m", board(sheet, 0.52)),
        SceneSetting("near, 0.3 m", board(sheet, 0.52), distance_mm=300.0),
        SceneSetting("far, 5 m", board(sheet, 0.52), distance_mm=5000.0, camera=Camera(focal_px=2900.0)),
        SceneSetting("as built: twist, offset, scale", board(sheet, 0.52), built),
        SceneSetting("turned in the picture by 30 degrees", board(sheet, 0.52), built, roll_deg=30.0),
        SceneSetting("both axes", board(sheet, 0.50, "yx"), built, 800.0),
        SceneSetting("thick sheet, 3 mm", board(thick, 0.52), built),
        SceneSetting("75 lines an inch, 0.67 mm", board(thin, 0.345), built, 700.0),
        SceneSetting("40 lines an inch, acrylic", board(coarse, 0.65), distance_mm=1500.0),
        SceneSetting("out of focus, thin lines", board(flat, 0.52, duty=0.4), built),
        SceneSetting("line mask", board(mask, 0.52), built),
    ]
