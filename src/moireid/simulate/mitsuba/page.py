"""The printed page as strips: exact in float32, so that no texture's resolution limits the phase of a line.

Convention: as `mitsuba.sheet`; strips are (low, high across the lines, begin, end along them), board mm, as printed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Cell, Grating, Lens
from moireid.simulate.mitsuba.sheet import ACROSS, ALONG, Room, Strips
from moireid.simulate.scene import Build, Scene

Array = NDArray[np.float64]
#: Mitsuba's own constant: a new ray starts this share of (1 + the largest coordinate) away from its surface.
RAY_OFFSET = 1500 * 2.0**-24
#: The page's picture lies this far behind the strips of printed lines: deeper than `page_depth_mm` ever puts them.
BEHIND_MM = 0.02
#: When a ray passes a face, Mitsuba moves it by less than this.
HIDDEN_MM = 0.05


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
    for cell in grating.cells:
        found["ink"].append(_cell_strips(scene, grating, cell, 0.0, cell.duty))
        found["paper"].append(_cell_strips(scene, grating, cell, cell.duty, 1.0 - cell.duty))
    frame = scene.badge.frame_of(grating)
    placed = {}
    for name, parts in found.items():
        strips = np.concatenate(parts) if parts else np.empty((0, 4))
        if len(strips):
            corners = np.stack([strips[:, list(ACROSS)], strips[:, [2 + k for k in ALONG]]], axis=-1)
            printed = np.array(scene.build.print_scales) * frame.vectors(corners)
            across, along = np.moveaxis(frame.directions(printed), -1, 0)
            largest = np.abs(printed).max(axis=-1)
            placed[name] = Strips(
                across, along, page_depth_mm(scene.lens, scene.build, largest, flat_faces=int(scene.need.bounces))
            )
    return placed


def _cell_strips(scene: Scene, grating: Grating, cell: Cell, first: float, width: float) -> Array:
    """Strips (N, 4) of one kind in one cell, as drawn: from `first` of each pitch, `width` of it wide, cut to it."""
    low, begin, high, end = scene.own_rect_mm(grating, cell.rect_mm)
    edge = cell.edge_mm - float(scene.badge.frame_of(grating).places(scene.board_centre_mm)[0])
    lines = np.arange(math.floor((low - edge) / cell.pitch_mm) - 1, math.ceil((high - edge) / cell.pitch_mm) + 1)
    start = edge + (lines + first) * cell.pitch_mm
    cut = np.clip(np.stack([start, start + width * cell.pitch_mm]), low, high)
    cut = cut[:, cut[1] > cut[0]]
    return np.column_stack([*cut, np.full(cut.shape[1], begin), np.full(cut.shape[1], end)])


def page_depth_mm(lens: Lens, build: Build, largest_coordinate_mm: Array, *, flat_faces: int = 0) -> Array:
    """How much deeper than z = 0 the page must lie, so that rays land as they would without Mitsuba's offset.

    Parameters: flat_faces: how many flat ones a ray passes between the lens and the page.
    Convention: board mm, of the input's shape.
    Source: Mitsuba moves a refracted ray's origin inwards along the surface's normal by d = `RAY_OFFSET` (1 + largest
        coordinate), 0.006 mm at 68 mm from the badge's middle.  With s = sin of the normal's tilt, even over +-q, the
        ray begins d <cos> deeper; at a tangent t more rays meet the flank that faces them, by 1 - t s / cos, so it
        also begins d t <s^2 / cos> aside.  That is worth n <s^2 / cos> of depth, in which a ray gains t/n sideways.
        Left alone, it turns the phase by 0.005 rad at t = 0.3 and 0.010 at 0.6; this takes back all but 0.001.
        A flat face costs d of depth.
    """
    q = lens.pitch_mm * build.lens_scale / 2 / lens.radius_mm if lens.radius_mm else 0.0
    share = 1.0
    if q > 0:
        bent, flat = math.asin(q) / (2 * q), math.sqrt(1 - q * q) / 2
        share = bent + flat - lens.refractive_index * (bent - flat)
    return (share + flat_faces) * RAY_OFFSET * (1.0 + largest_coordinate_mm)


def hidden_face(scene: Scene, room: Room) -> Strips:
    """The sheet's flat back, `HIDDEN_MM` above the page, so that a ray that has passed it still meets the lines."""
    low, high, begin, end = room
    across, along = (np.array([[a, b]])[:, list(turn)] for a, b, turn in ((low, high, ACROSS), (begin, end, ALONG)))
    return Strips(across, along, np.full(across.shape, -HIDDEN_MM))


def wall_strips(scene: Scene, room: Room) -> Strips:
    """The sheet's four sides: a sight line beside the sheet sees paper there, as in `analytic`.

    Convention: their feet stand out as far as lines printed too large reach beyond the sheet.
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
