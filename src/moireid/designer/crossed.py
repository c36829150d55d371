"""Cells and beats of a badge under a lens array, whose two gratings share one field.

Light must pass the lines of both gratings at each place, so the fringes of one dim those of the other, and with motion
the dimming wanders.  A strip is read as the mean across it.  Where that mean is over a whole period of the other
grating's fringes, the other one may stand where it will.  So each grating's rows are as high as a period of the other's
fringes and the rims together, which are not read; and rows of the one are columns of cells of the other.
"""

from __future__ import annotations

import math

from moireid.designer.grid import FILL, UNIFORM_ROWS, Grid
from moireid.designer.layout import Layout
from moireid.errors import DesignError
from moireid.idcodes.spacing import CELLS_PER_BYTE
from moireid.idcodes.words import CHECK_BYTES, MAX_WORD_BYTES

#: Rim of a row that is not read, on each side, mm; and a row higher than this is read in parts: rows are read
#: so by every reader (`verifier.tracking.profiles`).
RIM_MM, MOST_ROW_MM = 0.9, 10.0
#: Lower rows leave no period between their rims that a camera resolves.
LEAST_ROW_MM = 4.0


def crossed_grids(layout: Layout, payload_bytes: int) -> tuple[Grid, Grid]:
    """The grids of both gratings, x before y: as large as they may be, with cells enough for the payload.

    Raises: DesignError where the field is too small.
    """
    _, (x0, y0, x1, y1) = layout.fields_mm[0]
    need = math.ceil((payload_bytes + CHECK_BYTES) / FILL)
    side = MOST_ROW_MM
    while side >= LEAST_ROW_MM:
        wide, high = math.ceil((x1 - x0) / side), math.ceil((y1 - y0) / side)
        cells = max(high - UNIFORM_ROWS, 0) * wide + max(wide - UNIFORM_ROWS, 0) * high
        if min(cells // CELLS_PER_BYTE, MAX_WORD_BYTES) >= need:
            column_mm, row_mm = (x1 - x0) / wide, (y1 - y0) / high
            least = min(column_mm, row_mm)
            return Grid(high, (wide, high), row_mm, least), Grid(wide, (wide, high), column_mm, least)
        side *= 0.98
    raise DesignError(
        f"a field of {x1 - x0:.0f} x {y1 - y0:.0f} mm is too small for {8 * payload_bytes} bits under a lens array; "
        "give a larger board such as 146x160, or another front"
    )


def periods_mm(grids: tuple[Grid, Grid]) -> tuple[float, float]:
    """Period of each grating's fringes: what is read of a row of the other."""
    return grids[1].row_mm - 2 * RIM_MM, grids[0].row_mm - 2 * RIM_MM
