"""One description of badge as built, camera and light, for every renderer, and sheets by name.

`sheet_named` gives what a shop, a shelf, the weather or a printer make of a badge's sheet and page:

thin      75 lines per inch are sold at 0.457 mm as well as at 0.67 mm: the sheet is 0.68 times as thick, and fringes
          move 0.6 to 0.7 times as far
gap       0.1 mm of air between sheet and page, as where a sheet is held at its edges: a fifth more gain at 1 mm
bowed     sheet and page bent together to a radius of 1.5 m, edges away from the camera: 1.8 mm at the board's edge
warm      20 K warmer than when the badge was made: the sheet is wider by 0.14 %, the paper is not
jittered  each lens 0.5 % wider or narrower than the next, by itself, so that places wander over the sheet
fed       the sheet is as designed, but the printer fed the page 0.3 % too far, so that all is higher by that

Source: thicknesses as `moireid.sheets`; growth of PMMA, PETG and PET by 7e-5 a kelvin, makers' data; gap, bow and
jitter set by hand, as what one sees of a sheet in a clip.  Along the feed, Canon's service manual of the GP160 office
copier, p. 2-20, passes a page that is 1 mm too long or short: 0.3 % of A4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating, Lens, Rect
from moireid.errors import SpecError
from moireid.frames import own_rect
from moireid.sheets import sheet_lens
from moireid.simulate.cameras import Camera
from moireid.simulate.light import DiscLight
from moireid.simulate.motion import Poses

__all__ = ["Build", "Camera", "Instant", "Need", "Scene"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Build:
    """How the built badge differs from its design: the sheet's place on the page, and the scale of print and sheet.

    Parameters
    ----------
    lens_offset_mm : float
        How far each sheet is moved along its fringes' axis, mm; positive for +x on an "x" grating.
    twist_rad : float
        How far each sheet is turned about the view axis, rad; positive from x towards y.
    pieces : tuple of (float, float)
        Offset and twist of each grating's own piece of sheet, added to those of all, as each is mounted by itself.
    print_scale : float
        Printed over nominal width, about the board's centre.
    lens_scale : float
        Real over nominal pitch of the sheet, about the board's centre.
    thickness_ratio : float
        Real over nominal thickness of the sheet; the lenses focus on its back again, as far as their pitch lets them.
    air_gap_mm : float
        Air between sheet and page, mm.
    bow_radius_m : float
        Radius to which sheet and page are bent together along x, m; the edges lie farther from the camera.
    pitch_jitter : float
        Standard deviation of each lens's width, as a share of the pitch; widths are independent.
    print_aspect : float
        Printed height over printed width, over that of the design; the width is `print_scale`'s.
    """

    lens_offset_mm: float = 0.0
    twist_rad: float = 0.0
    print_scale: float = 1.0
    lens_scale: float = 1.0
    thickness_ratio: float = 1.0
    air_gap_mm: float = 0.0
    bow_radius_m: float = math.inf
    pitch_jitter: float = 0.0
    print_aspect: float = 1.0
    pieces: tuple[tuple[float, float], ...] = ()

    def sheet(self, grating: int) -> tuple[float, float]:
        """Offset, mm, and twist, rad, of the piece of sheet over a grating, by its number."""
        offset_mm, twist_rad = self.pieces[grating] if self.pieces else (0.0, 0.0)
        return self.lens_offset_mm + offset_mm, self.twist_rad + twist_rad

    @property
    def print_scales(self) -> tuple[float, float]:
        """Printed over nominal size along the page's x and y, about the board's centre.

        Notes
        -----
        Convention: both belong to the page; a twist turns the sheet alone.
        """
        return self.print_scale, self.print_scale * self.print_aspect

    @staticmethod
    def typical(seed: int) -> Build:
        """One badge out of many.

        Parameters
        ----------
        seed : int
            Of what chance decides.

        Returns
        -------
        Build
            With a random offset within +-0.25 mm, and normal twist (standard deviation 0.1 degrees, at most 0.3),
            print scale (0.2 %, at most 0.5 % off), lens scale and print aspect (0.1 %, at most 0.3 % off).
        """
        rng = np.random.default_rng(seed)
        return Build(
            lens_offset_mm=float(rng.uniform(-0.25, 0.25)),
            twist_rad=math.radians(float(np.clip(rng.normal(0, 0.1), -0.3, 0.3))),
            print_scale=1 + float(np.clip(rng.normal(0, 0.002), -0.005, 0.005)),
            lens_scale=1 + float(np.clip(rng.normal(0, 0.001), -0.003, 0.003)),
            # Drawn last, so that a seed keeps what it drew before.
            print_aspect=1 + float(np.clip(rng.normal(0, 0.001), -0.003, 0.003)),
        )


@dataclass(frozen=True)
class Instant:
    """One frame to render: poses at the first and last row, and the place from which the fringes are shown.

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
class Need:
    """What a film must show.  What is not needed is left out of the work.

    Parameters
    ----------
    background : bool
        What is behind the badge; even grey without it.
    page : bool
        Paper and markers around the gratings.
    shutter : bool
        Rows and instants of an exposure one after the other; all at the middle of the frame's time without it.
    glare : bool
        What the lenses mirror of a light.
    bounces : bool
        Light that the sheet's faces mirror onto each other, and faces hidden behind the lenses.  Mitsuba alone shows
        it.

    Notes
    -----
    `FilmReport.left_out` lists what was left out, and the seconds that this saved.
    """

    background: bool = True
    page: bool = True
    shutter: bool = True
    glare: bool = True
    bounces: bool = False


@dataclass(frozen=True)
class Scene:
    """A badge, how it is built, its camera and its light, and what must be seen of them.

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
    need : Need
        What a film must show.

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
    need: Need = field(default_factory=Need)

    @property
    def lens(self) -> Lens:
        """The lens sheet of its thickness as built, at its nominal pitch."""
        nominal, ratio = self.badge.lens, self.build.thickness_ratio
        if ratio == 1.0:
            return nominal
        thickness_mm = ratio * nominal.thickness_mm
        if nominal.kind == "mask":
            return replace(nominal, thickness_mm=thickness_mm)
        return sheet_lens(nominal.pitch_mm, thickness_mm, nominal.refractive_index)

    @property
    def height_mm(self) -> float:
        """From the page to the tops of the lenses."""
        return self.lens.thickness_mm + self.build.air_gap_mm

    @property
    def seen_mm(self) -> Array:
        """Rectangles that a picture must show (N, 5): x0, y0, x1, y1 and depth, board mm as built."""
        (cx, cy), (x, y) = self.board_centre_mm, self.printed_half_mm
        if self.need.page:
            return np.array([[-x, -y, x, y, 0.0]])
        rects = np.array([self.badge.bounds_of(grating) for grating in self.badge.gratings]) - (cx, cy, cx, cy)
        return np.column_stack([rects, np.full(len(rects), -self.height_mm)])

    def own_rect_mm(self, grating: Grating, rect_mm: Rect) -> Rect:
        """A rectangle of a grating or of its cell in own order, counted from the board's centre, mm."""
        first, second = self.badge.frame_of(grating).places(self.board_centre_mm).tolist()
        low, top, high, bottom = own_rect(grating.axis, rect_mm)
        return low - first, top - second, high - first, bottom - second

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


THIN_RATIO = 0.457 / 0.67
GAP_MM, BOW_RADIUS_M, WARMER_K, PITCH_JITTER = 0.1, 1.5, 20.0, 0.005
FED_ASPECT = 1.003
#: Thermal growth of acrylic and polyester sheet, per kelvin.
GROWTH_PER_K = 7e-5


def sheet_named(name: str, build: Build) -> Build:
    """The build with the named sheet in place of its own.

    Convention: what the build says of place and twist, and of the print's width, stays.
    Raises: SpecError for a name that is none.
    Source: module docstring.
    """
    made = {
        "thin": replace(build, thickness_ratio=THIN_RATIO),
        "gap": replace(build, air_gap_mm=GAP_MM),
        "bowed": replace(build, bow_radius_m=BOW_RADIUS_M),
        "warm": replace(build, lens_scale=build.lens_scale * (1 + WARMER_K * GROWTH_PER_K)),
        "jittered": replace(build, pitch_jitter=PITCH_JITTER),
        "fed": replace(build, print_aspect=FED_ASPECT),
    }
    if name not in made:
        raise SpecError(f"sheet {name!r} is not known; choose one of {', '.join(made)}")
    return made[name]
