"""The figures of printer, laser and card, apart from the parts themselves; all in mm, each can be set by its name.

Convention: `kerf_mm` is the whole width that the laser burns away, so each drawn line is half a kerf away from the
finished edge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from moireid.arguments import Bounds, check_values
from moireid.errors import FabricationError, SpecError

#: Two lines of a 0.4 mm nozzle; a thinner wall would be a single line.
LEAST_WALL_MM = 0.8
#: Two layers of a print: a lip is this thick at its tip, and grows thicker towards the rim.
LEAST_LIP_MM = 0.4
#: Common 3D printers have no more room than this in any direction.
BED_MM = 350.0
#: Page and lens may be turned against each other by this much before cells are misread.
TWIST_DEG = 0.3
#: Acrylic narrower than this between two cuts breaks.
LEAST_LAND_MM = 2.0
#: Least and most of figures of the printer and of the laser.  A rim is a fifth thinner where its corners are rounded
#: outside and sharp inside.  A stand that leans less is turned over by a draught; one that leans more needs supports
#: under its rest.  Neither nozzle nor laser is more exact than the least clearance.  A CO2 laser's kerf in acrylic is
#: 0.1 to 0.3 mm.  The rest must be more than nothing, and beyond its most must be a slip, or would not make a mount.
_SHARED: dict[str, Bounds] = {"card_mm": (0.01, 2.0), "film_mm": (0.01, 0.5), "adhesive_mm": (0.0, 0.2)}
PRINTER_BOUNDS: dict[str, Bounds] = _SHARED | {
    "clearance_mm": (0.05, 1.0),
    "wall_mm": (1.25 * LEAST_WALL_MM, 6.0),
    "back_mm": (LEAST_WALL_MM, 6.0),
    "lip_reach_mm": (0.01, 60.0),
    "lip_mm": (LEAST_LIP_MM, 6.0),
    "depth_clearance_mm": (0.01, 0.5),
    "preload_mm": (0.01, 0.5),
    "slot_mm": (0.01, 60.0),
    "seat_mm": (0.01, 1.0),
    "stand_deg": (5.0, 40.0),
}
LASER_BOUNDS: dict[str, Bounds] = _SHARED | {
    "kerf_mm": (0.0, 1.0),
    "base_mm": (2.0, 10.0),
    "clearance_mm": (0.05, 5.0),
    "rim_mm": (0.01, 50.0),
    "lip_reach_mm": (0.01, 60.0),
    "lips_mm": (0.01, 0.5),
    "hole_mm": (0.01, 4.5),
}
#: Every shop has acrylic in these thicknesses.
STOCK_MM = (2.0, 3.0, 4.0)


@dataclass(frozen=True)
class MountProcess:
    """The 3D printer's figures.

    clearance_mm: air left, right and below of board and sheet, each; wall_mm: the rim's width; back_mm: the plate
    behind the board; lip_reach_mm: how far a lip comes over the board at most, from the board's edge; lip_mm: its
    thickness at the tip;
    card_mm: thickness of the printed board; film_mm: of a mask's film, which lies on its spacer; depth_clearance_mm:
    room between sheet and lip, at the board's edge; preload_mm: how far the springs' pads reach above that room,
    so that they press card and sheet on the lips; slot_mm: lanyard slots, width and height, narrowed on a narrow board;
    seat_mm: how far a printed register edge may be off its place; adhesive_mm: between page and lens sheet, 0 where the
    mount alone holds them together; stand_deg: how far a stand leans the badge back, degrees.
    """

    clearance_mm: float = 0.3
    wall_mm: float = 2.0
    back_mm: float = 1.6
    lip_reach_mm: float = 1.2
    lip_mm: float = 0.4
    card_mm: float = 0.3
    film_mm: float = 0.1
    depth_clearance_mm: float = 0.1
    preload_mm: float = 0.25
    slot_mm: tuple[float, float] = (16.0, 4.0)
    seat_mm: float = 0.05
    adhesive_mm: float = 0.0
    stand_deg: float = 12.0

    def __post_init__(self) -> None:
        check_values(type(self), vars(self), PRINTER_BOUNDS)
        if self.slot_mm[0] <= self.slot_mm[1]:
            raise FabricationError(
                f"process figure slot_mm={self.slot_mm[0]:g}x{self.slot_mm[1]:g} is no slot for a strap; give more "
                "width than height, such as 16x4"
            )


@dataclass(frozen=True)
class AcrylicProcess:
    """The laser's figures.

    kerf_mm: width of the burnt line, 0 where the shop compensates; base_mm: the base plate; clearance_mm: air between
    the board and each of the frame's register edges, None for what the allowed twist leaves; rim_mm: width of the
    frame round the board, at least; lip_reach_mm: how far the film's lips come over the sheet; lips_mm: thickness of
    that film; hole_mm: clearance hole of an M3 screw; card_mm: thickness of the printed board, and of each layer of
    card below it; film_mm: of a mask's film, which lies on its spacer; adhesive_mm: between page and lens sheet.
    """

    kerf_mm: float = 0.15
    base_mm: float = 3.0
    clearance_mm: float | None = None
    rim_mm: float = 10.5
    lip_reach_mm: float = 2.0
    lips_mm: float = 0.25
    hole_mm: float = 3.4
    card_mm: float = 0.3
    film_mm: float = 0.1
    adhesive_mm: float = 0.0

    def __post_init__(self) -> None:
        check_values(type(self), vars(self), LASER_BOUNDS)


@dataclass(frozen=True)
class MountFigures:
    """The figures of both workshops.

    insisted: "printed" or "acrylic" where the user set a figure of that mount by name: if it cannot be made then, the
    wish is refused, and the mount is not just left out.
    """

    printed: MountProcess = field(default_factory=MountProcess)
    acrylic: AcrylicProcess = field(default_factory=AcrylicProcess)
    insisted: frozenset[str] = frozenset()


def mount_figures(given_mm: Mapping[str, float | tuple[float, float]]) -> MountFigures:
    """The defaults with figures set by name: {"kerf_mm": 0.2, "slot_mm": (20, 5)}.

    Convention: a name that both workshops have (card_mm, film_mm, adhesive_mm, clearance_mm, lip_reach_mm) sets both,
        and "printed.clearance_mm" or "acrylic.clearance_mm" one.
    Raises: SpecError for an unknown name, or a value that is not a number; FabricationError for an impossible figure.
    """
    known = {"printed": {f.name for f in fields(MountProcess)}, "acrylic": {f.name for f in fields(AcrylicProcess)}}
    given: dict[str, dict[str, Any]] = {"printed": {}, "acrylic": {}}
    insisted = set()
    for key, value in given_mm.items():
        where, dot, name = key.rpartition(".")
        shops = [shop for shop, names in known.items() if name in names and (not dot or shop == where)]
        if not shops:
            names = ", ".join(sorted(known["printed"] | known["acrylic"]))
            raise SpecError(f"mount figure {key[:60]!r} is not known; give NAME=MM with one of {names}")
        if len(shops) == 1:
            insisted.add(shops[0])
        for shop in shops:
            given[shop][name] = value
    return MountFigures(MountProcess(**given["printed"]), AcrylicProcess(**given["acrylic"]), frozenset(insisted))
