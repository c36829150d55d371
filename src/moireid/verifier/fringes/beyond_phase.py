"""What a film shows of a grating apart from its phase, as evidence against photographs placed over a film.

The depth law is the main part: does the spacing of the fringes follow the camera's distance?  Nearer to the badge the
fringes are closer together.  Along a strip that is a few thousandths of a radian for a hand's sway, and hundreds of
frames show it.  A photograph that is placed over a film keeps the spacing of the place where it was taken.  So a table
of photographs, indexed by parallax, has all that depends on parallax and nothing that depends on distance; only the
second is used here.

Convention: one entry per frame, (T,), over the frames of the signal (`GratingSignal`).  The gain is seen over
predicted change of spacing: 1 on a genuine badge, 0 on such a table.
Source: `strip_law`; the change is 2 pi X g_eff / p_r times the change of 1 / |Cz| for a place X along the strip.
    Least squares of the residual of `strip_shape` against slope times change, both without what the fit of each
    frame takes up (Frisch and Waugh 1933).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Grating, Lens
from moireid.lenticule import view_law
from moireid.verifier.fringes.grating_signal import DepthLaw
from moireid.verifier.fringes.sinusoid import left_of_rows
from moireid.verifier.fringes.strip_phase import StripLaw, StripPhase, harmonics_of, level_and_slope
from moireid.verifier.fringes.strip_shape import StripShape

Array = NDArray[np.float64]
#: What depends on parallax is taken away as a polynomial of this degree.
DEGREE = 3


def depth_law(
    shape: StripShape | None, law: StripLaw, found: StripPhase, parallax: Array, length_mm: float
) -> DepthLaw:
    """Evidence of one strip.

    Parameters: shape: of the strip; law, found: as in `strip_shape`; parallax (T,): of the camera, along the strip;
        length_mm: of the strip.
    Returns: all 0 if there are no fringes.
    Source: module docstring; information is in units of the strip's own noise, so that strips add up.
    """
    score, information, power = np.zeros((3, len(parallax)))
    if shape is None or shape.clear.sum() < 10 * DEGREE:
        return DepthLaw(score, information, power)
    seen = parallax[shape.clear] - parallax[shape.clear].mean()
    table = np.vander(seen / max(float(seen.std()), 1e-9), DEGREE + 1)
    change = law.phase_rad(found.frequency_per_mm)[shape.clear]
    change -= table @ np.linalg.lstsq(table, change, rcond=None)[0]
    # Of each frame, the fit took up the background and these harmonics.
    harmonics, background = harmonics_of(found.frequency_per_mm, length_mm), level_and_slope(change.shape[1])
    pattern = left_of_rows(change.astype(np.float32) * shape.slope, shape.turned, harmonics, background)
    pattern -= pattern.mean(axis=0)
    noise = float(np.median(np.mean(shape.left**2, axis=1)))
    if noise > 0:
        score[shape.clear] = np.einsum("tn,tn->t", shape.left, pattern) / noise
        information[shape.clear] = np.einsum("tn,tn->t", pattern, pattern) / noise
        power[shape.clear] = information[shape.clear] * np.mean(change**2)
    return DepthLaw(score, information, power)


def expected_overtone(
    lens: Lens, grating: Grating, tan_x: Array, tan_y: Array, *, spread_cycles: float = 0.0
) -> NDArray[np.complex128]:
    """The third harmonic that optics and picture let through, against that of half-wide lines seen from the front.

    Parameters
    ----------
    lens, grating
        As issued.
    tan_x, tan_y : (T,) arrays
        Tangents of the view at the grating's middle, in its own frame; signs as in `moireid.optics`.
    spread_cycles : float
        Standard deviation of the picture's line spread along the axis, in fringes (`tracking.edge_spread`).

    Returns
    -------
    (T,) complex array
        In contrasts, its phase less three times the fundamental's; 1 for lines that are as wide as the gaps, from the
        front, in a sharp picture.  From the side a sheet is out of focus, so it is smaller there, and turned.

    Notes
    -----
    Source: the response H of the front layer to lines of the pitch and of a third of it (`lenticule.view_law`).
    Fourier coefficients of a rectangle of width d are sin(3 pi d) / (3 sin(pi d)), a third where d is a half; a mask's
    openings add a like factor.  Modulation transfer of a Gaussian spread s at a frequency f: exp(-2 (pi s f)^2), at 3 f
    over that at f.
    """
    widths = [float(np.mean([cell.duty for cell in grating.cells]))]
    if lens.open_fraction is not None:
        widths.append(lens.open_fraction)
    lines = float(np.prod([abs(np.sin(3 * np.pi * width) / np.sin(np.pi * width)) for width in widths]))
    # A frame without a pose counts as one from the front; what is unknown of it is left out elsewhere.
    views = [np.append(np.nan_to_num(tangents), 0.0) for tangents in (tan_x, tan_y)]
    laws = (view_law(lens, grating.pitch_mm / harmonic) for harmonic in (1, 3))
    (first, turn), (third, thrice) = ((law.contrast_kept(*views), law.phase_rad(*views)) for law in laws)
    overtone = third / np.maximum(first, 1e-9) * np.exp(1j * (thrice - 3 * turn))
    transfer = np.exp(-16 * (np.pi * spread_cycles) ** 2)
    return np.asarray(transfer * lines * overtone[:-1] / max(abs(overtone[-1]), 1e-9))


def mean_overtone(strips: Sequence[StripPhase]) -> NDArray[np.complex128]:
    """Of several strips, (T,), each weighted by how little it trembles from frame to frame."""
    trembling = np.array([np.median(np.abs(np.diff(strip.overtone))) for strip in strips])
    weight = np.where(trembling > 0, 1.0 / np.maximum(trembling, 1e-9) ** 2, 0.0)
    if not weight.sum() > 0:
        return np.zeros(len(strips[0].overtone), complex)
    seen = np.nan_to_num(np.array([strip.overtone for strip in strips]))
    return np.asarray(weight @ seen / weight.sum())
