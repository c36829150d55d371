"""The figures of printer, laser and card, apart from the parts themselves; all in mm, each can be set by its name.

Convention: `kerf_mm` is the whole width that the laser burns away, so each drawn line is half a kerf away from the
finished edge.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from moireid.errors import FabricationError, SpecError

#: Two lines of a 0.4 mm nozzle; a thinner wall would be a single line.
LEAST_WALL_MM = 0.8
#: Two layers of a print: a lip is this thick at its tip, and grows thicker towards the rim.
LEAST_LIP_MM = 0.4
#: A stand that leans less is turned over by a draught; one that leans more needs supports under its rest.
STAND_DEG = (5.0, 40.0)
#: Common 3D printers have no more room than this in any direction.
BED_MM = 350.0
#: Page and lens may be turned against each other by this much before cells are misread.
TWIST_DEG = 0.3
#: A CO2 laser's kerf in acrylic is 0.1 to 0.3 mm; more than 1 mm must be a mistake.
MOST_KERF_MM = 1.0
#: Acrylic narrower than this between two cuts breaks.
LEAST_LAND_MM = 2.0
#: Least clearance: neither nozzle nor laser is more exact, and a card needs some room.
LEAST_CLEARANCE_MM = 0.05
#: Greatest figures: more than this must be a slip, or would not make a mount.
MOST_MM = {
    "printed": {
        "clearance_mm": 1.0,
        "wall_mm": 6.0,
        "back_mm": 6.0,
        "lip_mm": 6.0,
        "card_mm": 2.0,
        "film_mm": 0.5,
        "depth_clearance_mm": 0.5,
        "preload_mm": 0.5,
        "slot_mm": 60.0,
        "adhesive_mm": 0.2,
        "stand_deg": STAND_DEG[1],
        "snap_clearance_mm": 1.0,
        "bite_mm": 3.0,
    },
    "acrylic": {
        "rim_mm": 50.0,
        "hole_mm": 4.5,
        "card_mm": 2.0,
        "film_mm": 0.5,
        "adhesive_mm": 0.2,
        "lips_mm": 0.5,
    },
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
    mount alone holds them together; stand_deg: how far a stand leans the badge back, degrees; snap_clearance_mm: air on
    each side of a badge in a snap-in holder; bite_mm: how far its catches come over the badge's edge.
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
    snap_clearance_mm: float = 0.2
    bite_mm: float = 0.55

    def __post_init__(self) -> None:
        _check(self, MOST_MM["printed"], but=("adhesive_mm",))
        # The rim is a fifth thinner where its corners are rounded outside and sharp inside.
        for name, least in (("wall_mm", 1.25 * LEAST_WALL_MM), ("back_mm", LEAST_WALL_MM), ("lip_mm", LEAST_LIP_MM)):
            if (value := getattr(self, name)) < least:
                raise FabricationError(
                    f"process figure {name}={value:g} is thinner than a printed wall; give {least:g} mm or more",
                    least_mm=least,
                )
        if self.stand_deg < STAND_DEG[0]:
            raise FabricationError(
                f"process figure stand_deg={self.stand_deg:g} is too upright to be steady; give "
                f"{STAND_DEG[0]:g} to {STAND_DEG[1]:g} degrees"
            )
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
        _check(self, MOST_MM["acrylic"], but=("kerf_mm", "adhesive_mm"))
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


def _check(process: MountProcess | AcrylicProcess, most_mm: dict[str, float], *, but: tuple[str, ...]) -> None:
    """Raise where a figure is not positive, larger than any workshop would use, or a clearance is too small.

    Parameters: but: figures that may be zero.
    """
    given = {entry.name: value for entry in fields(process) if (value := getattr(process, entry.name)) is not None}
    for name, value in given.items():
        # A kerf below nothing has a refusal of its own.
        least = -math.inf if name == "kerf_mm" else 0.0
        values = value if isinstance(value, tuple) else (value,)
        if not all(math.isfinite(v) and (v > 0 or (name in but and v >= least)) for v in values):
            raise FabricationError(f"process figure {name}={value} must be positive; give it in mm")
    for name, most in most_mm.items():
        if max(given[name] if isinstance(given[name], tuple) else (given[name],)) > most:
            raise FabricationError(
                f"process figure {name}={given[name]} is more than any mount has use for; give at most {most:g} mm",
                most_mm=most,
            )
    if process.clearance_mm is not None and process.clearance_mm < LEAST_CLEARANCE_MM:
        raise FabricationError(
            f"process figure clearance_mm={process.clearance_mm:g} is less than a workshop keeps; give "
            f"{LEAST_CLEARANCE_MM:g} mm or more",
            least_mm=LEAST_CLEARANCE_MM,
        )


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
        numbers = value if isinstance(value, tuple) else (value,)
        if len(numbers) != (2 if name == "slot_mm" else 1) or not all(isinstance(one, int | float) for one in numbers):
            form = "width and height in mm such as 16x4" if name == "slot_mm" else "a number of mm"
            raise SpecError(f"mount figure {name}={value!r:.40} is not understood; give {form}")
        if len(shops) == 1:
            insisted.add(shops[0])
        for shop in shops:
            given[shop][name] = value
    return MountFigures(MountProcess(**given["printed"]), AcrylicProcess(**given["acrylic"]), frozenset(insisted))
