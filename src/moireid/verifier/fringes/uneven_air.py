"""Parts of a badge that move a little further than others, as there is more air beneath the sheet there.

Fringes move as far as the lenses are from the page.  Where the sheet is not glued flat, that differs from place to
place, and so does the gain of each row and of each place in a row.  It differs by a share that stays the same over a
film, so it is known from the film itself: what is left of a part goes with the motion.  Seen from aside, a part that
is glued and one that is laid on move apart by as much more as the two laws do (`strip_law.air_law`).  A part that moves
much further than air explains has another cause, so nothing of that is taken away.

Convention: phases in rad, positive where the fringe is ahead; parts are rows, or places of one row.
Source: traced: 0.05 mm of air beneath a sheet of 1 mm make the gain 1.10 (`docs/accuracy.md`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.measuring import NO_AIR, STILL_AIR, UNEVEN_GAIN_SHARE

Array = NDArray[np.float64]


def less_uneven_air(apart_rad: Array, weight: Array, motion_rad: Array, air_rad: Array) -> Array:
    """Deviations of parts, without what goes with the motion.

    Parameters
    ----------
    apart_rad : array (P, T)
        How far each part is ahead of the mean of all; mean 0 over each part.
    weight : array (P, T)
        Of each, 0 where it is not known.
    motion_rad, air_rad : array (T,)
        Predicted phase, and what is added to it where the sheet is laid on.

    Returns
    -------
    array (P, T)

    Notes
    -----
    Source: weighted least squares, bounded to `UNEVEN_GAIN_SHARE`; of a share that is `STILL_AIR` times as large
    a falling part, and from `NO_AIR` on nothing.  All three are further by the gain of what air adds.
    """
    total = np.maximum(weight.sum(axis=1, keepdims=True), 1e-12)
    moved = motion_rad - (weight * motion_rad).sum(axis=1, keepdims=True) / total
    power = np.maximum((weight * moved**2).sum(axis=1, keepdims=True), 1e-12)
    share = (weight * moved * apart_rad).sum(axis=1, keepdims=True) / power
    aside = np.abs((weight * moved * air_rad).sum(axis=1, keepdims=True)) / power
    believed = np.clip((NO_AIR - (np.abs(share) - aside) / UNEVEN_GAIN_SHARE) / (NO_AIR - STILL_AIR), 0.0, 1.0)
    most = UNEVEN_GAIN_SHARE + aside
    explained = believed * np.clip(share, -most, most)
    return np.asarray(apart_rad - explained * moved)
