"""What a camera can see of the lens sheet, and the printed page, as flat strips along the lenses.

A renderer needs the front of the sheet alone, since the page touches the back and paper hides the sides.  The printed
lines are strips as well, exact in float32, so that no texture's resolution limits the phase of a line.

Convention: places are (across the lenses, along them, depth), board mm; the page is at depth 0, the apexes at
-thickness.  Strips have four corners, in the order of `ACROSS` and `ALONG`, which turns their face towards the camera.
Strips of the page are (low, high across the lines, begin, end along them), board mm, as printed.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Cell, Grating, Lens
from moireid.errors import SpecError
from moireid.layers import is_smooth
from moireid.simulate.scene import Build, Scene
from moireid.smooth_lines import LineField

Array = NDArray[np.float64]
#: Corners of a strip as (low or high across, begin or end along), turning so that its face looks at the camera.
ACROSS, ALONG = (0, 0, 1, 1), (0, 1, 1, 0)
#: Low, high across; begin, end along: the rectangle of a sheet, board mm.
Room = tuple[float, float, float, float]


@dataclass(frozen=True)
class Strips:
    """Four-cornered faces: across, along, depth (N, 4) mm; normals (N, 4, 3) in the same axes, or None for flat."""

    across: Array
    along: Array
    depth: Array
    normals: Array | None = None


def front_strips(lens: Lens, build: Build, room: Room, segments: int) -> Strips:
    """The front of the lenticules that fill a rectangle, `segments` chords to each, with the circle's own normals.

    Parameters
    ----------
    lens : Lens
        A lenticular sheet, at its nominal pitch.
    build : Build
        Offset, mm, and twist, rad, of this piece of sheet, and the scale of its pitch.
    room : Room
        The rectangle; strips are those whose middle lies in it half way along it.
    segments : int
        Chords of each lenticule.

    Raises
    ------
    SpecError
        Where the lenses would be wider than their diameter.

    Notes
    -----
    Convention: module docstring; normals point out of the glass.
    Source: circles of the lens's radius through their tops, corners on the circle; two lenses that meet have different
    normals there.
    """
    pitch, radius = lens.pitch_mm * build.lens_scale, lens.radius_mm
    assert radius is not None
    if pitch > 2 * radius:
        raise SpecError(f"lens_scale={build.lens_scale:g} spreads the lenses beyond their diameter; give less")
    cuts = (np.arange(segments + 1) / segments - 0.5) * pitch
    axes, strip = sheet_strips(build, room, pitch, (cuts[:-1] + cuts[1:]) / 2)
    # Neighbours share a corner, which leaves no gap between them: it is taken from the strip that begins there.
    borders = np.append(axes + cuts[strip], axes[-1] + cuts[strip[-1] + 1])
    s = borders[np.arange(len(axes))[:, None] + np.array(ACROSS)]
    across, along = _slanted(build, s, np.array(room)[[2 + k for k in ALONG]])
    slope = cuts[strip[:, None] + np.array(ACROSS)] / radius
    facing = -np.sqrt(1.0 - slope**2)
    normals = np.stack([slope * math.cos(build.twist_rad), slope * math.sin(build.twist_rad), facing], axis=-1)
    return Strips(across, along, radius * (1.0 + facing) - lens.thickness_mm, normals)


def mask_strips(lens: Lens, build: Build, room: Room) -> dict[str, Strips]:
    """A line mask's dark bars, and the clear openings between them, which refract as a flat slab does.

    Convention: openings are centred where lenses have their axes.
    Source: `Lens.open_fraction`.
    """
    pitch, clear = lens.pitch_mm * build.lens_scale, lens.open_fraction or 0.0
    found = {}
    for name, middle, width in (("bars", 0.5, 1.0 - clear), ("openings", 0.0, clear)):
        if width <= 0:
            continue
        axes, _ = sheet_strips(build, room, pitch, np.array([middle * pitch]))
        half = width * pitch / 2
        corner = axes[:, None] + middle * pitch + np.where(np.array(ACROSS) > 0, half, -half)
        across, along = _slanted(build, corner, np.array(room)[[2 + k for k in ALONG]])
        found[name] = Strips(across, along, np.full(across.shape, -lens.thickness_mm))
    return found


def sheet_strips(build: Build, room: Room, pitch: float, middles: Array) -> tuple[Array, NDArray[np.intp]]:
    """The strips whose middle lies in the sheet's rectangle: the axis of each one's lens, and its number in the lens.

    Convention: middles are relative to a lens's axis.
    """
    shift = math.sin(build.twist_rad) * (room[2] + room[3]) / 2 - build.lens_offset_mm
    reach = [math.cos(build.twist_rad) * edge + shift for edge in room[:2]]
    axes = np.arange(math.floor(reach[0] / pitch) - 1, math.ceil(reach[1] / pitch) + 2) * pitch
    place = np.add.outer(axes, middles)
    lens, strip = np.nonzero((place >= reach[0]) & (place <= reach[1]))
    return np.asarray(axes[lens], float), np.asarray(strip, np.intp)


def _slanted(build: Build, s: Array, along: Any) -> tuple[Array, Array]:
    """Board coordinates across and along of points s across the twisted sheet, on lines of constant `along`."""
    along = np.broadcast_to(np.asarray(along, float), s.shape)
    return (s + build.lens_offset_mm - along * math.sin(build.twist_rad)) / math.cos(build.twist_rad), along


#: Mitsuba's own constant: a new ray starts this share of (1 + the largest coordinate) away from its surface.
RAY_OFFSET = 1500 * 2.0**-24
#: The page's picture lies this far behind the strips of printed lines: deeper than `page_depth_mm` ever puts them.
BEHIND_MM = 0.02


def sheet_room(scene: Scene, grating: Grating) -> Room:
    """The sheet's rectangle over a grating: low, high across, begin, end along, board mm."""
    low, begin, high, end = scene.own_rect_mm(grating, grating.rect_mm)
    return low, high, begin, end


def page_strips(scene: Scene, grating: Grating) -> dict[str, Strips]:
    """Strips of ink and of paper in a grating's cells; a kind without strips is left out.

    Convention: module docstring.
    Source: the cells' own edges and pitches, each edge placed absolutely.
    """
    found: dict[str, list[Array]] = {"ink": [], "paper": []}
    if is_smooth(grating):
        found["ink"], found["paper"] = _smooth_strips(scene, grating)
    for cell in () if is_smooth(grating) else grating.cells:
        duty = scene.printed_line(cell)[1]
        found["ink"].append(_cell_strips(scene, grating, cell, 0.0, duty))
        found["paper"].append(_cell_strips(scene, grating, cell, duty, 1.0 - duty))
    frame = scene.badge.frame_of(grating)
    placed = {}
    for name, parts in found.items():
        strips = np.concatenate(parts) if parts else np.empty((0, 4))
        if len(strips):
            corners = np.stack([strips[:, list(ACROSS)], strips[:, [2 + k for k in ALONG]]], axis=-1)
            printed = np.array(scene.build.print_scales) * frame.vectors(corners)
            across, along = np.moveaxis(frame.directions(printed), -1, 0)
            largest = np.abs(printed).max(axis=-1)
            placed[name] = Strips(across, along, page_depth_mm(scene.lens, scene.build, largest))
    return placed


#: Height of the strips in which a curved line is straight, mm: its edges are off by 0.01 mm at most.
SLICE_MM = 0.2


def _smooth_strips(scene: Scene, grating: Grating) -> tuple[list[Array], list[Array]]:
    """As `_cell_strips`, of ink and of paper, for each slice of a smooth grating; as drawn."""
    field, centre = LineField(grating), scene.badge.frame_of(grating).places(scene.board_centre_mm)
    borders = np.linspace(field.begin, field.end, math.ceil((field.end - field.begin) / SLICE_MM) + 1)
    wider_mm = scene.build.ink_um / 1000
    ink: list[Array] = []
    paper: list[Array] = []
    for (begin, end), edges in zip(
        itertools.pairwise(borders - centre[1]), field.edges_mm((borders[1:] + borders[:-1]) / 2), strict=True
    ):
        drawn = edges[edges[:, 1] > edges[:, 0]] + wider_mm / 2 * np.array([-1.0, 1.0])
        drawn = np.clip(drawn, field.low, field.high)
        bare = np.column_stack([[field.low, *drawn[:, 1]], [*drawn[:, 0], field.high]])
        for strips, found in ((drawn, ink), (bare[bare[:, 1] > bare[:, 0]], paper)):
            found.append(np.column_stack([strips - centre[0], np.full((len(strips), 2), (begin, end))]))
    return ink, paper


def _cell_strips(scene: Scene, grating: Grating, cell: Cell, first: float, width: float) -> Array:
    """Strips (N, 4) of one kind in one cell, as drawn: from `first` of each pitch, `width` of it wide, cut to it."""
    low, begin, high, end = scene.own_rect_mm(grating, cell.rect_mm)
    edge = scene.printed_line(cell)[0] - float(scene.badge.frame_of(grating).places(scene.board_centre_mm)[0])
    lines = np.arange(math.floor((low - edge) / cell.pitch_mm) - 1, math.ceil((high - edge) / cell.pitch_mm) + 1)
    start = edge + (lines + first) * cell.pitch_mm
    cut = np.clip(np.stack([start, start + width * cell.pitch_mm]), low, high)
    cut = cut[:, cut[1] > cut[0]]
    return np.column_stack([*cut, np.full(cut.shape[1], begin), np.full(cut.shape[1], end)])


def page_depth_mm(lens: Lens, build: Build, largest_coordinate_mm: Array) -> Array:
    """How much deeper than z = 0 the page must lie, so that rays land as they would without Mitsuba's offset.

    Convention: board mm, of the input's shape.
    Source: Mitsuba moves a refracted ray's origin inwards along the surface's normal by d = `RAY_OFFSET` (1 + largest
        coordinate), 0.006 mm at 68 mm from the badge's middle.  With s = sin of the normal's tilt, even over +-q, the
        ray begins d <cos> deeper; at a tangent t more rays meet the flank that faces them, by 1 - t s / cos, so it
        also begins d t <s^2 / cos> aside.  That is worth n <s^2 / cos> of depth, in which a ray gains t/n sideways.
        Left alone, it turns the phase by 0.005 rad at t = 0.3 and 0.010 at 0.6; this takes back all but 0.001.
    """
    q = lens.pitch_mm * build.lens_scale / 2 / lens.radius_mm if lens.radius_mm else 0.0
    share = 1.0
    if q > 0:
        bent, flat = math.asin(q) / (2 * q), math.sqrt(1 - q * q) / 2
        share = bent + flat - lens.refractive_index * (bent - flat)
    return share * RAY_OFFSET * (1.0 + largest_coordinate_mm)


def wall_strips(scene: Scene, room: Room) -> Strips:
    """The sheet's four sides: a sight line that passes the sheet's edge sees paper there, as in `analytic`.

    Convention: their feet reach out as far as lines printed too large reach beyond the sheet.
    """
    overhang = (max(*scene.build.print_scales, 1.0) - 1.0) * max(abs(edge) for edge in room)
    tops, feet = (
        [(room[k] + (-out, out)[k % 2], room[m] + (-out, out)[m % 2]) for k, m in ((0, 2), (0, 3), (1, 3), (1, 2))]
        for out in (0.0, overhang)
    )
    # Down at one corner and up at the next: in this order each side's face looks outwards.
    corners = np.array([[tops[k], feet[k], feet[(k + 1) % 4], tops[(k + 1) % 4]] for k in range(4)])
    g = scene.lens.thickness_mm
    return Strips(corners[..., 0], corners[..., 1], np.broadcast_to(np.array([-g, 0.0, 0.0, -g]), (4, 4)))
