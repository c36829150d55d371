"""One description of badge as built, camera and light, for every renderer."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Cell, Grating, Lens, Rect
from moireid.frames import own_rect
from moireid.simulate.build import Build
from moireid.simulate.cameras import Camera
from moireid.simulate.light import DiscLight, ribs_lamp
from moireid.simulate.motion import Poses

__all__ = ["Build", "Camera", "Instant", "Scene"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Instant:
    """One frame to render: poses at the first and last row, and the places from which the fringes are shown.

    first, last: at T instants evenly over the exposure of a row, 1 for an instant; shown_from_mm: (3,), or (T, 3).
    field: parallax (rows, columns, 2) that is added at each point of an even grid over the board, since each part of a
        forged badge may follow its own trajectory; None for a badge without such parts.
    picture: what a flat board shows in place of page and sheet, (rows, columns) radiance over its whole width at one
        scale; None for a true badge.
    """

    first: Poses
    last: Poses
    shown_from_mm: Array
    field: Array | None = None
    picture: NDArray[np.float32] | None = None


@dataclass(frozen=True)
class Scene:
    """A badge, how it is built, its camera and its light.

    Parameters
    ----------
    badge : Badge
        What is filmed.
    build : Build
        How the built badge differs from its design.
    camera : Camera
        The camera that films it; a `Motion` gives its place.
    ink : float
        Radiance of printed lines, 0 to 1.
    paper : float
        Radiance of bare paper, 0 to 1.
    hidden_mm : Rect, optional
        A part of the page that something grey covers, (x0, y0, x1, y1), page mm.
    light : Light, optional
        None for a page that shines by itself, with no glare and no ray lost.
    print_picture : array (rows, columns, 3) of uint8, optional
        What is printed on the board apart from lines and markers: blue, green, red over the whole board.

    Notes
    -----
    Convention: page mm have their origin at the page's top left.  The board frame has its origin at the board's
    centre, x right, y down, z into the board.
    Source: a white page under an even sky has radiance 1.
    """

    badge: Badge
    build: Build = field(default_factory=Build)
    camera: Camera = field(default_factory=Camera)
    ink: float = 0.06
    paper: float = 0.85
    hidden_mm: Rect | None = None
    light: DiscLight | None = None
    print_picture: NDArray[np.uint8] | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Light the badge by the lamp of its build, unless it has a light of its own."""
        if self.light is None and self.build.glare:
            object.__setattr__(self, "light", ribs_lamp(self.build.glare))

    @property
    def lens(self) -> Lens:
        """The lens sheet of its thickness and lens radius as built, at its nominal pitch."""
        return self.build.lens_of(self.badge.lens)

    def printed_line(self, cell: Cell) -> tuple[float, float]:
        """Where a dark line of a cell begins, page mm, and its share of the pitch, with the ink's spread."""
        wider_mm = self.build.ink_um / 1000
        return cell.edge_mm - wider_mm / 2, min(cell.duty + wider_mm / cell.pitch_mm, 1.0)

    @property
    def height_mm(self) -> float:
        """From the page to the tops of the lenses."""
        return self.lens.thickness_mm + self.build.air_gap_mm

    def sunk_mm(self, x: Array, y: Array) -> Array:
        """How much deeper places of the bent board lie than its centre, mm; as `bend`."""
        curvature, along_x, along_y, twist = self.bend
        return curvature * (x * along_x + y * along_y) ** 2 / 2 + twist * x * y

    def own_rect_mm(self, grating: Grating, rect_mm: Rect) -> Rect:
        """A rectangle of a grating or of its cell in own order, counted from the board's centre, mm."""
        first, second = self.badge.frame_of(grating).places(self.board_centre_mm).tolist()
        low, top, high, bottom = own_rect(grating.axis, rect_mm)
        return low - first, top - second, high - first, bottom - second

    @property
    def bend(self) -> tuple[float, float, float, float]:
        """How sheet and page are bent: curvature, 1/mm; its direction, x and y; and twist, 1/mm.

        Notes
        -----
        Convention: a place (x, y) is curvature s^2 / 2 + twist x y deeper than the board's centre, s along the
        direction.
        Source: a table under three corners is met by the saddle twist x y but for four times its depth at a corner.
        """
        build, (half_x, half_y) = self.build, self.printed_half_mm
        angle, twist = build.bow_angle_rad, build.corner_lift_mm / (4 * half_x * half_y)
        return 1e-3 / build.bow_radius_m, math.cos(angle), math.sin(angle), twist

    @property
    def board_half_mm(self) -> tuple[float, float]:
        """Half width and half height of the board; the board frame's origin is its centre."""
        x0, y0, x1, y1 = self.badge.outline_mm
        return (x1 - x0) / 2, (y1 - y0) / 2

    @property
    def printed_half_mm(self) -> tuple[float, float]:
        """Half width and half height of the board as printed."""
        (x, y), (scale_x, scale_y) = self.board_half_mm, self.build.print_scales
        return x * scale_x, y * scale_y

    @property
    def board_centre_mm(self) -> tuple[float, float]:
        """The board frame's origin in page coordinates."""
        x0, y0, x1, y1 = self.badge.outline_mm
        return (x0 + x1) / 2, (y0 + y1) / 2
