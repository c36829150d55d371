"""What stays the same in all frames: how far the fringes are ahead of the law at each place of a grating.

Lenses are not where they should be: a sheet shrinks unevenly when it is made, and is glued down with tension.  A lens
that is off by d turns its fringe by 2 pi d / p_f, in every frame and in every row, as lenses run along the whole sheet.
Nothing that moves is taken up here, so a map can hide no wrong motion, and the code's rows are not used, so it can hide
no wrong symbol.

A map has one value for each knot; knots are evenly spaced along the grating's own axis (`knots_mm`), and values between
them are interpolated.  Mean and slope belong to the sheet's offset and to the beat, so a map has neither.  Where rows
show no map, none is used, and nothing more is computed.

Convention: phases in rad, positive where the fringes are ahead of the law; places in the grating's own frame, mm.
Source: least squares of what a strip's shape leaves on the shape's slope (`strip_shape`), frame means removed, so that
dirt and shading, which stay where they are while fringes pass, count for nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.errors import SpecError
from moireid.frames import own_rect
from moireid.verifier.fringes.strip_shape import StripShape
from moireid.verifier.measuring import MAP_LEAST_RAD, MAP_SDS
from moireid.verifier.tracking.brightness_profiles import Strip

Array = NDArray[np.float64]
#: Distance of knots, about, mm: lenses wander over 25 mm and more.
KNOT_MM = 8.0
#: A knot is held near 0 as if by this share of what a usual knot shows; ends of a strip may show little.
RIDGE_SHARE = 1e-3


def knots_mm(grating: Grating) -> Array:
    """The knots of a grating's map, (K,)."""
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    return np.linspace(low, high, max(round((high - low) / KNOT_MM), 3) + 1)


@dataclass(frozen=True)
class PlaceMap:
    """The map of one grating: `used_rad` (K,), with which its strips were measured; `seen_rad` (K,): what the film
    shows; sd_rad: standard deviation of a knot of that, infinite where the film shows nothing of it.
    """

    used_rad: Array
    seen_rad: Array
    sd_rad: float = math.inf

    @property
    def change_rad(self) -> Array | None:
        """What the film shows beyond the map that was used, (K,); None where it is too little to be sure.

        Source: root mean square beyond `MAP_LEAST_RAD` and `MAP_SDS` standard deviations.
        """
        change = self.seen_rad - self.used_rad
        sure = math.sqrt(float(np.mean(change**2))) > max(MAP_LEAST_RAD, MAP_SDS * self.sd_rad)
        return change if sure else None


def start_maps(badge: Badge, enrolled: Sequence[Sequence[float]]) -> list[Array]:
    """The map to begin with for each grating: the enrolled one, or none.

    Raises: SpecError if the enrolled maps are not of this badge.
    """
    sizes = [len(knots_mm(grating)) for grating in badge.gratings]
    if not enrolled:
        return [np.zeros(size) for size in sizes]
    if [len(one) for one in enrolled] != sizes:
        raise SpecError(
            f"the as-built figures hold maps of {[len(one) for one in enrolled]} places, allowed for this badge are "
            f"{sizes}; enroll the badge with a capture again"
        )
    return [_without_slope(np.array(one, float)) for one in enrolled]


#: Sums over one strip for its map, along (K,) and power (K, K): power times the map is along.
StillShift = tuple[Array, Array]


def still_shift(strip: Strip, shape: StripShape | None, knots: Array) -> StillShift | None:
    """What one strip shows beyond the map that it was measured with; None if it has no fringes.

    Parameters
    ----------
    strip : Strip
        Where it is sampled.
    shape : StripShape or None
        Its shape over the film.
    knots : array (K,)
        As `knots_mm`.
    """
    if shape is None:
        return None
    along = np.einsum("tn,tn->n", shape.left, shape.slope).astype(float)
    slope = shape.slope - shape.slope.mean(axis=0)
    power = np.einsum("tn,tn->n", slope, slope).astype(float)
    hats = np.array([np.interp(strip.along_mm, knots, unit) for unit in np.eye(len(knots))])
    return hats @ along, (hats * power) @ hats.T


def seen_map(used_rad: Array, rows: Sequence[StillShift | None]) -> PlaceMap:
    """The map that the rows of one grating share; its error bar is from the difference between rows.

    Parameters
    ----------
    used_rad : array (K,)
        With which the rows were measured.
    rows : sequence of StillShift or None
        Of each row; at least two must be seen.
    """
    known = [row for row in rows if row is not None]
    if len(known) < 2:
        return PlaceMap(used_rad, used_rad)
    each = np.array([_solved(*row) for row in known])
    along, power = zip(*known, strict=True)
    common = _solved(np.sum(along, axis=0), np.sum(power, axis=0))
    variance = float(np.mean((each - common) ** 2)) / (len(known) - 1)
    return PlaceMap(used_rad, used_rad + common, math.sqrt(variance))


def _solved(along: Array, power: Array) -> Array:
    """The map of one row or of several, without mean and slope."""
    ridge = RIDGE_SHARE * max(float(np.trace(power)) / len(along), 1e-12)
    found = np.linalg.solve(power + ridge * np.eye(len(along)), along)
    return _without_slope(found)


def _without_slope(values: NDArray[Any]) -> Array:
    """Values at the knots without their mean and slope."""
    places = np.linspace(-1, 1, len(values))
    return np.asarray(values - np.polyval(np.polyfit(places, values, 1), places))
