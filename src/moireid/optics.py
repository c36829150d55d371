"""The phase law of a lens sheet (or a line mask) over printed lines, in closed form.

Convention, here and everywhere in moireid:
- A view direction is given by its tangents: tan_x = dx/ddepth of the sight line travelling from the camera into the
  badge.  A camera at (Cx, Cy), Cz in front of the lens plane, looks at the point x along tan_x = (x - Cx) / Cz.
- The parallax coordinate u = Cx / Cz is positive when the camera is at +x; on the point x = 0, tan_x = -u.
- The beat frequency is f_b = (1 + g_eff / Cz) / p_r - 1 / p_f, signed, in cycles per mm of the front plane.
- Fringe phase rises along +x where f_b > 0.  The fringes are cos(phase) up to a sign and a constant.

Source of the law: Qing et al., Moiré Video Authentication (2026), equation of the moving moiré, with three deviations:
the factor 1 + g/D, which the paper drops, is kept; the gap is the effective one; and the law is nonlinear in the angle
(traced by `moireid.lenticule`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from moireid.badge import Lens
from moireid.errors import DesignError

Array = NDArray[np.float64]


def beat_frequency_per_mm(
    front_pitch_mm: ArrayLike, rear_pitch_mm: ArrayLike, *, effective_gap_mm: float = 0.0, distance_mm: float = math.inf
) -> Array:
    """Spatial frequency of the fringes on the front plane.

    Convention: negative where the rear pitch is the coarser one (the published prototype).
    Parameters: pitches in mm, broadcast together; effective_gap_mm: `effective_gap_mm(lens)`; distance_mm: camera
        to front plane.
    Returns: array of the broadcast shape, cycles per mm; 0 if both layers have the same frequency.
    Raises: DesignError where a pitch or the distance is not positive.
    Source: difference of the two line frequencies, the rear one as seen from the distance: f = (1 + g/D)/p_r - 1/p_f.
    """
    front, rear = np.asarray(front_pitch_mm, float), np.asarray(rear_pitch_mm, float)
    if not (np.all(np.isfinite(front)) and np.all(np.isfinite(rear)) and np.all(front > 0) and np.all(rear > 0)):
        raise DesignError(
            f"pitches must be positive and finite mm, got front {front_pitch_mm!r} and rear {rear_pitch_mm!r}"
        )
    if not distance_mm > 0:
        raise DesignError(f"distance_mm={distance_mm} must be positive")
    return (1.0 + effective_gap_mm / distance_mm) / rear - 1.0 / front


def beat_period_mm(beat_frequency: ArrayLike) -> Array:
    """Period of the fringes, mm, always positive; infinite if the frequency is 0.

    Convention: the sign of the frequency is dropped.
    Source: reciprocal of `beat_frequency_per_mm`.
    """
    frequency = np.abs(np.asarray(beat_frequency, float))
    with np.errstate(divide="ignore"):
        return np.where(frequency > 0, 1.0 / frequency, np.inf)


def rear_pitch_for_beat_mm(front_pitch_mm: float, beat_frequency: ArrayLike) -> Array:
    """Printed pitch that gives a signed beat frequency (cycles per mm, camera far away) under that front pitch.

    Convention: the inverse of `beat_frequency_per_mm`.
    Raises: DesignError if there is no such positive pitch.
    Source: p_r = 1 / (1/p_f + f_b).
    """
    rear_frequency = 1.0 / front_pitch_mm + np.asarray(beat_frequency, float)
    if not np.all(np.isfinite(rear_frequency)) or np.any(rear_frequency <= 0):
        raise DesignError(
            f"no printed pitch beats at {beat_frequency!r} cycles/mm under {front_pitch_mm:g} mm; "
            f"ask for more than {-1 / front_pitch_mm:.4g}"
        )
    return 1.0 / rear_frequency


def paraxial_effective_gap_mm(lens: Lens) -> float:
    """Slope of the page shift against tan of the view angle, near the axis: g / n.

    Convention: positive; the page point seen moves with the sight line.
    Source: refraction at small angles.  With aberration the slope is 1 to 7 % smaller; see
        `moireid.lenticule.ViewLaw.effective_gap_mm` for the traced figure.
    """
    return lens.thickness_mm / lens.refractive_index


def slab_shift_mm(thickness_mm: float, refractive_index: float, tan_x: ArrayLike, tan_y: ArrayLike = 0.0) -> Array:
    """Shift along x of a sight line through a flat slab, from its top to its bottom: the exact law of a line mask.

    Parameters: tan_x, tan_y: arrays that broadcast together.
    Convention: positive for positive tan_x.
    Returns: mm, of the broadcast shape.
    Source: Snell's law in three dimensions; the transverse direction cosines divide by n.
    """
    tan_x, tan_y = np.asarray(tan_x, float), np.asarray(tan_y, float)
    length_squared = 1.0 + tan_x**2 + tan_y**2
    depth_cosine = np.sqrt(refractive_index**2 * length_squared - tan_x**2 - tan_y**2)
    return np.asarray(thickness_mm * tan_x / depth_cosine)


def parallax_slope_rad(effective_gap_mm: float, rear_pitch_mm: float) -> float:
    """Magnitude of the fringe phase's slope against the parallax coordinate on the lens plane, rad per unit tangent.

    Convention: positive; the phase itself falls with u, see `fringe_phase_rad`.
    Source: 2 pi g_eff / p_r, the time part of the phase law.
    """
    return 2.0 * math.pi * effective_gap_mm / rear_pitch_mm


def fringe_phase_rad(
    x_mm: ArrayLike, tan_x: ArrayLike, *, front_pitch_mm: float, rear_pitch_mm: float, effective_gap_mm: float
) -> Array:
    """Fringe phase at the point x of the front plane, linear in the tangent: the small-angle law.

    Parameters: x_mm and tan_x broadcast together.
    Convention: phase 0 at x = 0 seen straight on; falls when the camera moves to +x.
    Returns: rad, unwrapped.
    Source: module docstring; wrong by 0.02 rad at 17 degrees for the prototype, so predictions use
        `moireid.lenticule.ViewLaw` instead.
    """
    beat = 1.0 / rear_pitch_mm - 1.0 / front_pitch_mm
    shift = effective_gap_mm * np.asarray(tan_x, float)
    return 2.0 * math.pi * (np.asarray(x_mm, float) * beat + shift / rear_pitch_mm)


def passed_share(refractive_index: float, cosine: ArrayLike) -> Array:
    """Share of the light that passes a surface of glass from air, unpolarised.

    Convention: cosine of the incidence, in air, above 0.
    Source: Fresnel's equations.
    """
    n, cosine = refractive_index, np.asarray(cosine, float)
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / n**2)
    across, along = (cosine - n * inner) / (cosine + n * inner), (n * cosine - inner) / (n * cosine + inner)
    return 1.0 - (across**2 + along**2) / 2
