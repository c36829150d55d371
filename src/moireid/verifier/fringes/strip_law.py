"""The fringe phase that the optics predict along a strip.

The sight line through the page point X (rectified on the *page's* plane, where the markers are) has tangent
tan = (X - C) / |Cz| and crosses the lens plane at x = X - g tan.  With s(tan) the traced shift of the page under a
lens, the fringe phase at X is

    psi = 2 pi [ x (1/p_r - 1/p_f) + s(tan)/p_r ] + const = 2 pi [ s/p_f + f (X - g tan + s) ] + const,

where f = 1/p_r - 1/p_f is the beat frequency far away.  In the second form f enters linearly, so one table serves
any pitch.

Convention: phases in rad, positive where the fringe is ahead; millimetres of the page, in the grating's own frame
    (`moireid.frames`), along its axis.
Source: `moireid.lenticule`; its first order is 2 pi (g_eff / p_r + g (1/p_f - 1/p_r)), with fringes one thickness
    g above the page.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Lens
from moireid.frames import own_rect
from moireid.lenticule import MAX_TANGENT, critical_tangent, view_law
from moireid.verifier.fringes.place_map import knots_mm
from moireid.verifier.fringes.strip_phase import StripLaw
from moireid.verifier.tracking.brightness_profiles import Strip

Array = NDArray[np.float64]


def within_law(strips: Sequence[Strip], camera_mm: Array) -> NDArray[np.bool_]:
    """Frames in which every strip is seen within the table of the law; beyond it only the edge value is known.

    Parameters
    ----------
    strips : sequence of Strip
        Of one badge.
    camera_mm : array (T, 3)
        Camera centres, page mm, z < 0.

    Returns
    -------
    array (T,) of bool
    """
    known = np.ones(len(camera_mm), bool)
    reach = MAX_TANGENT * np.abs(camera_mm[:, 2])
    for strip in strips:
        along, across = strip.frame.places(camera_mm[:, :2]).T
        for end in (strip.along_mm[0], strip.along_mm[-1]):
            known &= np.abs(end - along) <= reach
        known &= np.abs(strip.across_mm - across) <= reach
    return known


def air_law(lens: Lens, pitch_mm: float, tan_x: Array, tan_y: Array) -> Array:
    """What is added to the phase law where the sheet is not glued to the page, but laid on it.

    Parameters: lens, pitch_mm: of the badge and the grating; tan_x, tan_y: of the views, across and along the lenses,
        that broadcast together; one that is not known counts as from the front.
    Returns: rad; 0, without a second trace, where no view reaches the critical angle inside the lens.
    Source: `lenticule.view_law`, both ways.
    """
    tangents = np.nan_to_num(tan_x), np.nan_to_num(tan_y)
    slant = np.hypot(*tangents)
    if slant.max(initial=0.0) <= critical_tangent(lens):
        return np.zeros(slant.shape)
    laid, glued = (view_law(lens, pitch_mm, laid=laid).phase_rad(*tangents) for laid in (True, False))
    return np.asarray(laid - glued)


def strip_law(badge: Badge, strip: Strip, camera_mm: Array, map_rad: Array | None = None) -> StripLaw:
    """The law of one strip.

    Parameters
    ----------
    badge : Badge
        Its lens and grating pitch are used, and no pitch of a cell.
    strip : Strip
        Where it is sampled, own mm.
    camera_mm : array (T, 3)
        Camera centres, page mm, z < 0.
    map_rad : array (K,), optional
        How far the fringes are ahead at the knots of the grating's map (`place_map`).

    Returns
    -------
    StripLaw
        Linear in the beat frequency, 1/mm.

    Notes
    -----
    Convention and source: module docstring.  The table is traced for the grating's nominal pitch; over the pitches of
    one badge s changes by 0.5 %.
    """
    grating = badge.gratings[strip.grating]
    pitch_mm = grating.pitch_mm
    law = view_law(badge.lens, pitch_mm)
    places = np.append(strip.along_mm, strip.middle_mm)
    distance = np.abs(camera_mm[:, 2:3])
    along, sideways = strip.frame.places(camera_mm[:, :2]).T
    tangent = (places[None, :] - along[:, None]) / distance
    across = (strip.across_mm - sideways[:, None]) / distance
    # The law is smooth along a strip, so 24 look-ups per frame and linear interpolation are enough.
    coarse = np.linspace(0, len(places) - 2, 24).astype(int)
    shift_coarse = law.phase_rad(tangent[:, coarse], across) * pitch_mm / (2 * np.pi)
    shift = shift_coarse @ np.array([np.interp(places, places[coarse], unit) for unit in np.eye(len(coarse))])
    # Measured from the grating's middle, where the lines of all cells meet, so that phases of cells can be compared.
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    middle_mm = (low + high) / 2
    lens_x = places[None, :] - middle_mm - badge.lens.thickness_mm * tangent
    fixed, per_frequency = shift / badge.lens.pitch_mm, lens_x + shift
    if map_rad is not None:
        # The phase of the strip's middle keeps its meaning: the map has no mean.
        fixed[:, :-1] += np.interp(strip.along_mm, knots_mm(grating), map_rad) / (2 * np.pi)
    return StripLaw(fixed[:, :-1], per_frequency[:, :-1], fixed[:, -1], per_frequency[:, -1])
