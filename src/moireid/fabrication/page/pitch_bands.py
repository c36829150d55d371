"""Five bands of lines outside the trim of a badge's page, which show a lens sheet's pitch on this very print.

Under a sheet each band shows fringes, but for the one that is made for its pitch: this is all light or all dark from
edge to edge.  The bands are made for the design's lenses, for lenses `ERRORS` wider and narrower, and so for a print
that is as much too small or too large.  In bands above the one without fringes these run against an eye that moves, in
bands below it with the eye.

Convention: mm on the sheet of paper, origin top left; an error is the pitch of the lenses over that of the design less
1, as they lie on this print.
Source: `optics.beat_frequency_per_mm` of 0: p_r = p_f (1 + error)(1 + g_eff / D), from the distance D of `look_m`.
"""

from __future__ import annotations

import math

from moireid.badge import Badge, Cell, Grating, Rect
from moireid.fabrication.page.canvas import RIM_MM
from moireid.sheets import effective_gap_mm

#: Of sheet over print.  Badges work within 1 %; beyond 1.7 % fringes of usual designs run the other way.  3 %: pages
#: that were fitted to the paper, and sheets of 60 lines per inch for 62.
ERRORS = (0.03, 0.01, 0.0, -0.01, -0.03)
#: From the trim to the bands; height of the caption; room for labels at either side, mm.
TRIM_GAP_MM, CAPTION_MM, LABELS_MM = 3.0, 4.0, 13.0
LEAST_BAND_MM, MOST_BAND_MM = 2.5, 5.0


def look_m(badge: Badge) -> float:
    """From how far to look and to film, m: 1 m where the badge is read from there."""
    near, far = badge.range_m or (1.0, 1.0)
    return max(near, math.floor(10 * min(max(1.0, near), far) + 1e-9) / 10)


def band_pitch_mm(badge: Badge, error: float) -> float:
    """The printed pitch that shows no fringe from `look_m` under lenses of that error; module docstring."""
    lens = badge.lens
    return lens.pitch_mm * (1 + error) * (1 + effective_gap_mm(lens, lens.pitch_mm) / (1000 * look_m(badge)))


def pitch_bands(badge: Badge, board: Rect) -> Grating | None:
    """The bands above a board that is at this rectangle of the sheet, as cells; None where the paper has no room.

    Convention: all bands have a dark line in the middle, where their fringes meet.
    """
    left, right, low = board[0] + LABELS_MM, board[2] - LABELS_MM, board[1] - TRIM_GAP_MM
    high_mm = min((low - RIM_MM - CAPTION_MM) / len(ERRORS), MOST_BAND_MM)
    if high_mm < LEAST_BAND_MM:
        return None
    cells = []
    for k, error in enumerate(ERRORS):
        pitch_mm, top = band_pitch_mm(badge, error), low - (len(ERRORS) - k) * high_mm
        cells.append(Cell((left, top, right, top + high_mm), pitch_mm, (left + right) / 2 - pitch_mm / 4, 0.5))
    return Grating((left, cells[0].rect_mm[1], right, low), "x", badge.lens.pitch_mm, "pitch-bands", tuple(cells))
