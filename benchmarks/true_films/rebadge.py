"""The middle row of one badge's film, copied into every cell of another badge by one fixed map.

Each frame of the donor's film is straightened.  A place of a cell shows the place of the donor's plain row at which its
fringes have the phase that the other badge's have: the beats' ratio stretches, and the cell's lines shift.  Where the
donor's row ends, it is a whole fringe to one side.  So all that is constant on a page is forged: code, beat, offset and
twist; what moves, moves as the donor's fringes do.

Convention: as `replay`; phases in turns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge, Cell, Grating
from moireid.frames import own_rect
from moireid.simulate.forgeries.rear_layer import ShownViews
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Scene
from true_films.clip import Array, Clip, Picture, print_of
from true_films.replay import along, beat_per_mm, box_px, looked_up, page_mm


@dataclass(frozen=True)
class Correction:
    """What the forger adds in the first field so that figures agree: to the phase, turns; to its slope along the lines,
    turns per mm; and to the beat, cycles per mm."""

    offset: float = 0.0
    twist: float = 0.0
    beat: float = 0.0

    @classmethod
    def between(cls, wanted: AsBuilt, shown: AsBuilt) -> Correction:
        """That which leads from what a first try showed to what is wanted."""
        turn = 2 * np.pi
        return cls(
            (wanted.offset_rad - shown.offset_rad) / turn,
            (wanted.twist_rad_per_mm - shown.twist_rad_per_mm) / turn,
            wanted.beat_frequency_per_mm - shown.beat_frequency_per_mm,
        )


@dataclass(frozen=True)
class Rebadging:
    """A donor's clip, shown frame by frame as the scene's badge; the donor's badge has the same layout."""

    donor: Badge
    clip: Clip
    correction: Correction = Correction()

    def shown(self, scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        """What shows it in a film of the donor's own trajectory."""
        away = float(self.clip.views[:, 2].mean())
        blank, maps = print_of(scene, away), []
        for number, (grating, donor) in enumerate(zip(scene.badge.gratings, self.donor.gratings, strict=True)):
            correction = Correction() if number else self.correction
            maps += [self._map(scene.badge, grating, donor, cell, away, correction) for cell in grating.cells]

        def picture(frame: int) -> Picture:
            made, filmed = blank.copy(), self.clip.picture(frame)
            for box, x, y, places in maps:
                made[box] = looked_up(filmed, x, y, box, places)
            return np.square(made)

        return ShownViews(camera_mm, camera_mm, picture=picture)

    def _map(self, badge: Badge, grating: Grating, donor: Grating, cell: Cell, away: float, add: Correction):
        """Where in the donor's picture each place of a cell is: box, x and y (rows, columns) and the box's places."""
        assert donor.code is not None
        row, lens, axis = donor.cells[donor.code.reference_cell], badge.lens, along(grating)
        box = box_px(badge, cell.rect_mm)
        places = page_mm(badge, box)
        grid = np.meshgrid(*places)
        across, lines = grid[axis], grid[1 - axis]
        # From the board's centre, about which the parallax is counted.
        left, top, right, bottom = badge.outline_mm
        centre = ((left + right) / 2, (top + bottom) / 2)[axis]
        low, lines_low, high, lines_high = own_rect(grating.axis, grating.rect_mm)
        beat = beat_per_mm(lens, cell.pitch_mm, away) + add.beat
        wanted = (across - centre) * beat - (cell.edge_mm - centre) / cell.pitch_mm
        wanted = wanted - ((low + high) / 2 - centre) * add.beat + add.offset
        wanted += add.twist * (lines - (lines_low + lines_high) / 2)
        own = beat_per_mm(lens, row.pitch_mm, away)
        taken = centre + (wanted + (row.edge_mm - centre) / row.pitch_mm) / own
        taken = _within(taken, across, 1 / abs(own), low + 0.5, high - 0.5)
        _, first, _, last = own_rect(grating.axis, row.rect_mm)
        _, start, _, end = own_rect(grating.axis, cell.rect_mm)
        level = (first + last) / 2 + (lines - (start + end) / 2) * 0.8
        found = (taken, level) if axis == 0 else (level, taken)
        return box, found[0] - places[0][0], found[1] - places[1][0], places


def _within(taken: Array, across: Array, period_mm: float, low: float, high: float) -> Array:
    """Places moved by whole fringes: those of a cell together to nearest where they are seen, then into the row."""
    taken = taken - period_mm * np.rint((taken.mean() - across.mean()) / period_mm)
    taken = taken + period_mm * np.ceil(np.maximum(low - taken, 0) / period_mm)
    return np.asarray(taken - period_mm * np.ceil(np.maximum(taken - high, 0) / period_mm))
