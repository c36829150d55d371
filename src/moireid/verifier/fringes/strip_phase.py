"""Fringe frequency and phase of a strip, measured frame by frame.

The profile of a strip is fitted by least squares with a level, a slope, and the fringe with its second and third
harmonic (the lens focuses, so fringes are closer to square than to sine).  The predicted *motion* is not used: the
phase is measured as the film shows it, also in a forged film.  Of the prediction only the geometry along the strip is
used (`StripLaw`, which `strip_law` makes).

Convention: phases in rad, positive where the fringe is ahead; millimetres of the page, in the grating's own frame
    (`moireid.frames`), along its axis.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.fringes.grating_signal import DepthLaw
from moireid.verifier.fringes.sinusoid import Fit, fit_columns, fit_rows, fitted_rows
from moireid.verifier.measuring import COVERED_MISFIT_CONTRASTS, COVERED_MISFIT_RATIO, STRIP_NOISE_RATIO
from moireid.verifier.picture import CODING_POWER
from moireid.verifier.series import greatest_near, spread_out

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StripLaw:
    """Phase of one strip as 2 pi (fixed + frequency * per_frequency): each (T, N), and (T,) at the strip's middle."""

    fixed: Array
    per_frequency: Array
    fixed_middle: Array
    per_frequency_middle: Array

    def phase_rad(self, frequency_per_mm: float) -> Array:
        """Predicted phase over the strip *relative to its middle*, (T, N)."""
        along = self.fixed - self.fixed_middle[:, None]
        along += frequency_per_mm * (self.per_frequency - self.per_frequency_middle[:, None])
        along *= 2 * np.pi
        return along

    def whole_phase_rad(self, frequency_per_mm: float) -> Array:
        """Predicted phase over the strip, (T, N), up to the constants that depend on assembly."""
        return np.asarray(2 * np.pi * (self.fixed + frequency_per_mm * self.per_frequency))

    def middle_phase_rad(self, frequency_per_mm: float) -> Array:
        """Predicted phase at the strip's middle, (T,), up to the constants that depend on assembly."""
        return np.asarray(2 * np.pi * (self.fixed_middle + frequency_per_mm * self.per_frequency_middle))

    @property
    def slope_rad(self) -> Array:
        """Derivative of `phase_rad` by the frequency, rad mm, (T, N)."""
        return np.asarray(2 * np.pi * (self.per_frequency - self.per_frequency_middle[:, None]))

    def part(self, frames: NDArray[np.int64]) -> StripLaw:
        """The law in some frames."""
        return StripLaw(*(of_all[frames] for of_all in vars(self).values()))


Complex = NDArray[np.complex128]
#: Frames used to search and to refine the frequency, which is one figure for the whole film.
SEARCH_FRAMES = 32
REFINE_FRAMES = 64
BLOCKS = 4
#: Most steps of the refinement, and the share of its reach below which a step is the last: the next one is far shorter.
REFINE_STEPS, REFINED_SHARE = 8, 0.003
#: A hand's soft edge is before the strip so many frames longer than it shows.
COVERED_EDGE_FRAMES = 2


@dataclass(frozen=True)
class StripPhase:
    """One strip over the film: phase at its middle and its standard deviation, contrast and level in counts, each (T,).

    frequency_per_mm is |f| with the sign of the search range; frequency_sd its standard deviation;
    covered (T,): where something that is no fringe covers a part of the strip (`covered_frames`), so that its phase
    is unknown; misfit: what fringes leave unexplained in a middling frame, as a share of the contrast; overtone (T,),
    complex: the third harmonic in contrasts, its phase less three times the fundamental's; 0 where it is not fitted.
    By `all_strips`: predicted_rad (T,): the phase by the law; place_residual_rad: deviation of places along the strip;
    depth: spacing against distance; still: sums for the grating's map (`place_map.still_shift`), None without fringes.
    """

    phase_rad: Array
    phase_sd_rad: Array
    contrast: Array
    level: Array
    frequency_per_mm: float
    frequency_sd: float
    covered: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    misfit: float = 0.0
    overtone: Complex = field(default_factory=lambda: np.zeros(0, complex))
    predicted_rad: Array = field(default_factory=lambda: np.zeros(0))
    place_residual_rad: float = 0.0
    depth: DepthLaw | None = None
    still: tuple[Array, Array] | None = None


def measure_strip(profiles: Array, law: StripLaw, length_mm: float, band_per_mm: tuple[float, float]) -> StripPhase:
    """Measure one strip.

    Parameters
    ----------
    profiles : array (T, N)
        Brightness along the strip, `picture.LINEAR_COUNTS`.
    law : StripLaw
        View geometry of the same frames and samples.
    length_mm : float
        Of the strip.
    band_per_mm : (float, float)
        Lowest and highest signed beat frequency (camera far away) to look for, 1/mm.

    Returns
    -------
    StripPhase

    Notes
    -----
    Convention: brightness = level + contrast cos(2 pi f (X - middle) + phase).
    Source: nonlinear least squares with the linear part solved exactly (variable projection; Golub and Pereyra 1973).
    """
    frequency, _ = strongest_frequency(profiles, law, length_mm, band_per_mm)
    frequency = _refine(profiles, law, frequency, 0.4 / length_mm, REFINE_FRAMES)
    blocks = np.array_split(np.arange(len(profiles)), BLOCKS)
    apart = [
        _refine(profiles[block], law.part(block), frequency, 0.4 / length_mm, REFINE_FRAMES // BLOCKS)
        for block in blocks
        if len(block) >= 4
    ]
    spread = float(np.std(apart, ddof=1) / np.sqrt(len(apart))) if len(apart) > 1 else np.inf
    harmonics = harmonics_of(frequency, length_mm)
    fit = fit_rows(profiles, law.phase_rad(frequency), harmonics, level_and_slope(profiles.shape[1]))
    fringe, level = fit.harmonics[:, 0], fit.background[:, 0]
    contrast = np.abs(fringe)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = STRIP_NOISE_RATIO * np.sqrt(fit.fundamental_variance()) / contrast
    misfit = np.sqrt(fit.left / profiles.shape[1])
    covered = covered_frames(misfit, contrast)
    sd = np.where(covered, np.inf, np.nan_to_num(sd, nan=np.inf))
    usual = float(np.median(misfit) / max(np.median(contrast), 1e-9))
    return StripPhase(np.angle(fringe), sd, contrast, level, frequency, spread, covered, usual, _overtone(fit))


def _overtone(fit: Fit) -> Complex:
    """The third harmonic of each frame, (T,), turned to the fundamental's phase, in contrasts; 0 where not fitted."""
    fundamental = fit.harmonics[:, 0]
    if fit.harmonics.shape[1] < 3:
        return np.zeros(len(fundamental), complex)
    size = np.maximum(np.abs(fundamental), 1e-9)
    return np.asarray(fit.harmonics[:, 2] * (np.conj(fundamental) / size) ** 3 / size)


def harmonics_of(frequency_per_mm: float, length_mm: float) -> int:
    """Harmonics that a strip can resolve: three where it shows one and a half fringes, else one."""
    return 3 if abs(frequency_per_mm) * length_mm >= 1.5 else 1


def level_and_slope(samples: int) -> Array:
    """The background of a strip's fit, (2, N): a level and a slope."""
    return np.stack([np.ones(samples), np.linspace(-1, 1, samples)])


def covered_frames(misfit: Array, contrast: Array) -> NDArray[np.bool_]:
    """Frames in which something covers a part of the strip: a hand, a finger, a caption, glare; (T,).

    Parameters: misfit (T,): root mean square of what fringes leave unexplained in a frame; contrast (T,); counts.
    Convention: fringes that move wrongly, or stay still, fit as well as any, and are never taken for covered.
    """
    usual = float(np.median(misfit))
    limit = max(COVERED_MISFIT_RATIO * usual, COVERED_MISFIT_CONTRASTS * float(np.median(contrast)))
    return greatest_near(misfit > limit, 2 * COVERED_EDGE_FRAMES + 1) & (misfit > usual)


def rounding_rad(strip: StripPhase) -> float:
    """Phase error of one place of the strip from rounding to whole counts, rad; a mean over time does not reduce it.

    A codec repeats such errors as long as little changes in the picture.  They are the same for faint print, so the
    phase error grows as one over the contrast.
    Returns: the median over the clearer half of the frames; 0 if there are no fringes.
    Source: rounding has a standard deviation of 1 / sqrt(12) counts; light per count is the derivative of the coding
        (`picture`).
    """
    clear = (strip.phase_sd_rad <= np.median(strip.phase_sd_rad)) & (strip.contrast > 0)
    if not clear.any():
        return 0.0
    light_per_count = CODING_POWER * np.clip(strip.level[clear] / 255.0, 0.0, 1.0) ** (1 - 1 / CODING_POWER)
    return float(np.median(light_per_count / np.sqrt(12) / strip.contrast[clear]))


def strongest_frequency(
    profiles: Array, law: StripLaw, length_mm: float, band: tuple[float, float]
) -> tuple[float, float]:
    """The strongest frequency of a band, on a grid of a fifth of a fringe across the strip, and what it explains.

    Parameters: as `measure_strip`.
    Returns: 1/mm, and its share of the pattern's power, 0 to 1.
    Source: periodogram under a Hann window, whose gain for a sinusoid of N samples is N/3 of its power.
    """
    frames = spread_out(len(profiles), SEARCH_FRAMES)
    some = profiles[frames].astype(float)
    line = np.linspace(-1, 1, some.shape[1])
    some = some - some.mean(axis=1, keepdims=True)
    some = (some - (some @ line)[:, None] / (line @ line) * line) * np.hanning(some.shape[1])
    law, step = law.part(frames), 0.2 / length_mm
    grid = np.arange(band[0], band[1] + 1e-9, step)
    turned, turn = some * np.exp(-1j * law.phase_rad(grid[0])), np.exp(-1j * step * law.slope_rad)
    power = []
    for _ in grid:
        power.append(float((np.abs(turned.sum(axis=1)) ** 2).sum()))
        turned *= turn
    whole = float((some**2).sum()) * some.shape[1] / 3
    return float(grid[int(np.argmax(power))]), max(power) / max(whole, 1e-12)


def _refine(profiles: Array, law: StripLaw, start: float, reach: float, most: int) -> float:
    """Frequency near `start` that explains the profiles best.

    Source: Gauss-Newton on what the fit of each frame leaves (variable projection; Kaufman 1975).
    """
    frames = spread_out(len(profiles), most)
    some, law = profiles[frames], law.part(frames)
    background, place = level_and_slope(some.shape[1]), start
    for _ in range(REFINE_STEPS):
        columns = fit_columns(law.phase_rad(place), 1, background)
        found, left = fitted_rows(some, columns)
        # The derivative of a cos + b sin is b cos - a sin.
        moved = law.slope_rad * (found[:, 3, None] * columns[:, 2] - found[:, 2, None] * columns[:, 3])
        moved = fitted_rows(moved, columns)[1]
        power = float(np.einsum("tn,tn->", moved, moved))
        step = float(np.einsum("tn,tn->", left, moved)) / power if power > 0 else 0.0
        before, place = place, float(np.clip(place + step, start - reach, start + reach))
        if abs(place - before) <= REFINED_SHARE * reach:
            break
    return place
