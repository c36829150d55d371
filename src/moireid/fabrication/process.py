"""What printer, laser and card ask for, apart from the parts themselves; all in mm.

Convention: `kerf_mm` is the whole width that the laser burns away, so each drawn line lies half of it off the edge
that is wanted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from moireid.errors import FabricationError

#: Two lines of a 0.4 mm nozzle: a printed wall thinner than this has no inside.
LEAST_WALL_MM = 0.8
#: Common 3D printers reach no further than this in any direction.
BED_MM = 350.0
#: Page and lens may be turned against each other by this much before cells are misread.
TWIST_DEG = 0.3
#: A CO2 laser's kerf in acrylic is 0.1 to 0.3 mm; beyond 1 mm it is no laser's.
MOST_KERF_MM = 1.0
#: Acrylic narrower than this between two cuts breaks.
LEAST_LAND_MM = 2.0
#: Plates are sold in these thicknesses: polyester film up to 0.5 mm, acrylic above.
STOCK_MM = (0.25, 0.35, 0.5, 0.8, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


@dataclass(frozen=True)
class MountProcess:
    """The 3D printer's figures.

    clearance_mm: air left, right and below of board and sheet, each; wall_mm: the rim's width; back_mm: the plate
    behind the board; lip_reach_mm: how far a lip comes over the board, from the board's edge; lip_mm: its thickness;
    card_mm: thickness of the printed board; depth_clearance_mm: room between sheet and lip to slide in by;
    preload_mm: how far the springs' pads stand higher than that room, so that they press card and sheet on the lips;
    slot_mm: lanyard slot, width and height; seat_mm: how far a printed register edge may be off its place.
    """

    clearance_mm: float = 0.3
    wall_mm: float = 2.0
    back_mm: float = 1.6
    lip_reach_mm: float = 2.0
    lip_mm: float = 1.2
    card_mm: float = 0.3
    depth_clearance_mm: float = 0.1
    preload_mm: float = 0.1
    slot_mm: tuple[float, float] = (16.0, 4.0)
    seat_mm: float = 0.05

    def __post_init__(self) -> None:
        _check_positive(self)
        for name in ("wall_mm", "back_mm", "lip_mm"):
            if (value := getattr(self, name)) < LEAST_WALL_MM:
                raise FabricationError(
                    f"process figure {name}={value:g} is thinner than a printed wall; give {LEAST_WALL_MM:g} mm or "
                    "more",
                    least_mm=LEAST_WALL_MM,
                )
        if self.clearance_mm > 1.0:
            raise FabricationError(
                f"process figure clearance_mm={self.clearance_mm:g} would let board and sheet rattle; give at most 1 mm"
            )


@dataclass(frozen=True)
class AcrylicProcess:
    """The laser's figures.

    kerf_mm: width of the burnt line, 0 where the shop compensates; base_mm: the base plate; clearance_mm: air between
    the board and each of the frame's register edges, None for what the allowed twist leaves; rim_mm: width of the
    frame round the board; lip_reach_mm: how far the cover comes over the sheet; hole_mm: clearance hole of an M3 screw;
    card_mm: thickness of the printed board.
    """

    kerf_mm: float = 0.15
    base_mm: float = 3.0
    clearance_mm: float | None = None
    rim_mm: float = 10.0
    lip_reach_mm: float = 2.0
    hole_mm: float = 3.4
    card_mm: float = 0.3

    def __post_init__(self) -> None:
        _check_positive(self, but=("kerf_mm",))
        if not 0 <= self.kerf_mm <= MOST_KERF_MM:
            raise FabricationError(
                f"kerf_mm={self.kerf_mm:g} is no laser's kerf, allowed is 0 to {MOST_KERF_MM:g} mm; cut a square of "
                "20 mm, measure what it lacks, and give that",
                most_mm=MOST_KERF_MM,
            )
        if not 2.0 <= self.base_mm <= 10.0:
            raise FabricationError(
                f"base_mm={self.base_mm:g} is no base plate, allowed is 2 to 10 mm; 3 mm suits most badges"
            )


def _check_positive(process: MountProcess | AcrylicProcess, *, but: tuple[str, ...] = ()) -> None:
    for entry in fields(process):
        value = getattr(process, entry.name)
        if value is None:
            continue
        values = value if isinstance(value, tuple) else (value,)
        if not all(math.isfinite(v) and (v > 0 or entry.name in but) for v in values):
            raise FabricationError(f"process figure {entry.name}={value} must be positive; give it in mm")
