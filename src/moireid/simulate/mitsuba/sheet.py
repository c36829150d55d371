"""The lens sheet as a closed solid of triangles, and the part of it that a camera can see.

The solid is built and checked by trimesh: one watertight volume, its front made of flat strips along the lenses.  A
renderer needs the front alone, since the page touches the back and the sides are hidden by the page's paper.

Convention: places are (across the lenses, along them, depth), board mm; the page is at depth 0, the apexes at
-thickness.  Strips have four corners, in the order of `ACROSS` and `ALONG`, which turns their face towards the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Lens
from moireid.errors import SpecError
from moireid.extras import missing_extra
from moireid.simulate.scene import Build

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


@dataclass(frozen=True)
class Profile:
    """Outline of the lenses' front: place s across (N + 1,), from lenticule 0's axis, depth, and offset in the lens.

    low, high: (N,) each strip's corners relative to its own lens's axis, mm.
    """

    s: Array
    depth: Array
    low: Array
    high: Array


def turned_for(build: Build, grating: int, handed: float) -> Build:
    """The build as one grating sees it: with its own piece of sheet, the twist from across towards along.

    Parameters: grating: its number; handed: of its frame (`moireid.frames`), by which a twist changes its sign.
    """
    offset_mm, twist_rad = build.sheet(grating)
    return replace(build, lens_offset_mm=offset_mm, twist_rad=handed * twist_rad, laid=())


def lens_profile(lens: Lens, build: Build, room: Room, segments: int) -> Profile:
    """Outline of the lenticules that fill a rectangle, `segments` chords to each.

    Convention: strips are those whose middle lies in the rectangle half way along it.
    Raises: SpecError where the lenses would be wider than their diameter.
    Source: circles of the lens's radius through their apexes; corners lie on the circle.
    """
    pitch, radius = lens.pitch_mm * build.lens_scale, lens.radius_mm
    if radius is None:
        raise SpecError("a line mask has no lenses to build; ask for its bars")
    if pitch > 2 * radius:
        raise SpecError(f"lens_scale={build.lens_scale:g} spreads the lenses beyond their diameter; give less")
    cuts = (np.arange(segments + 1) / segments - 0.5) * pitch
    axes, strip = sheet_strips(build, room, pitch, (cuts[:-1] + cuts[1:]) / 2)
    low, high = cuts[strip], cuts[strip + 1]
    # Neighbours share a corner, which keeps the solid closed: it is taken from the strip that begins there.
    s = np.append(axes + low, axes[-1] + high[-1])
    corner = np.append(low, high[-1])
    return Profile(s, radius - np.sqrt(radius**2 - corner**2) - lens.thickness_mm, low, high)


def sheet_solid(lens: Lens, build: Build, room: Room, segments: int = 16) -> Any:
    """The lens sheet as one closed solid, a `trimesh.Trimesh`, its vertices (across, along, depth) in mm.

    Parameters: room: its rectangle; segments: chords of each lenticule.
    Convention: module docstring; the first 2 N faces are the front's N strips.
    Raises: SpecError where the mesh bounds no volume; MissingExtraError without trimesh.
    Source: the profile pulled along the lenses; trimesh's own test for a watertight, consistently turned mesh.
    """
    try:
        import trimesh
    except ImportError as missing:
        raise missing_extra("this renderer", "trimesh", "simulate") from missing
    profile = lens_profile(lens, build, room, segments)
    count = len(profile.s)
    ends = [
        np.column_stack([*_slanted(build, profile.s, end), depth])
        for end in room[2:]
        for depth in (profile.depth, np.zeros(count))
    ]
    # Rows of points: front and back at the begin, front and back at the end.
    front_b, back_b, front_e, back_e = (np.arange(count) + k * count for k in range(4))
    faces = [
        _band(front_b, front_e),
        _band(back_e, back_b),
        _band(back_b, front_b),
        _band(front_e, back_e),
        _quad(back_b[0], back_e[0], front_e[0], front_b[0]),
        _quad(front_b[-1], front_e[-1], back_e[-1], back_b[-1]),
    ]
    solid = trimesh.Trimesh(np.concatenate(ends), np.concatenate(faces), process=False)
    if not (solid.is_watertight and solid.is_winding_consistent and solid.volume > 0):
        raise SpecError(f"a sheet of {count - 1} strips in {room} mm bounds no volume; give a larger sheet")
    return solid


def front_strips(lens: Lens, build: Build, room: Room, segments: int) -> Strips:
    """The front of `sheet_solid` alone, shaded with the circle's own normals.

    Convention: module docstring; normals point out of the glass.
    Source: vertices and faces of the solid; the circle's slope at each strip's own corners, since two lenses that
        meet have different ones there.
    """
    solid, profile = sheet_solid(lens, build, room, segments), lens_profile(lens, build, room, segments)
    first, second = np.asarray(solid.faces[: 2 * len(profile.low)]).reshape(-1, 2, 3).transpose(1, 0, 2)
    corners = np.asarray(solid.vertices)[np.column_stack([first, second[:, 2]])]
    radius = float(lens.radius_mm or 0.0)
    corner = np.column_stack([profile.low, profile.high])[:, list(ACROSS)]
    slope, facing = corner / radius, -np.sqrt(1.0 - (corner / radius) ** 2)
    normals = np.stack([slope * math.cos(build.twist_rad), slope * math.sin(build.twist_rad), facing], axis=-1)
    return Strips(corners[..., 0], corners[..., 1], corners[..., 2], normals)


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
        along = np.broadcast_to(np.array(room)[[2 + k for k in ALONG]], corner.shape)
        across, _ = _slanted(build, corner, along)
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
    if not len(lens):
        raise SpecError(f"a sheet of {room} mm holds no lens of {pitch:g} mm; give a larger one")
    return np.asarray(axes[lens], float), np.asarray(strip, np.intp)


def _slanted(build: Build, s: Array, along: Any) -> tuple[Array, Array]:
    """Board coordinates across and along of points s across the twisted sheet, on lines of constant `along`."""
    along = np.broadcast_to(np.asarray(along, float), s.shape)
    return (s + build.lens_offset_mm - along * math.sin(build.twist_rad)) / math.cos(build.twist_rad), along


def _band(begin: NDArray[Any], end: NDArray[Any]) -> NDArray[Any]:
    """Two triangles for each step between two rows of points, turned as `ACROSS` and `ALONG` turn a strip."""
    corners = np.stack([begin[:-1], end[:-1], end[1:], begin[1:]], axis=1)
    return corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _quad(*corners: int) -> NDArray[Any]:
    """Two triangles of one quadrangle."""
    return np.array(corners)[[0, 1, 2, 0, 2, 3]].reshape(2, 3)
