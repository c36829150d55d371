"""Fringe frequency, phase and waveform of a strip, frame by frame, and the phase that the optics predict for it.

Measured: the profile of a strip is fitted by least squares with a level, a slope, and the fringe with its second and
third harmonic (the lens focuses, so fringes are closer to square than to sine).  The predicted *motion* is not used:
the phase is measured as the film shows it, also in a forged film.  The shape of the fringes is learnt from the film
(`strip_shape`), together with the residual that it leaves in each frame.

Predicted: the sight line through the page point X (rectified on the *page's* plane, where the markers are) has tangent
tan = (X - C) / |Cz| and crosses the lens plane at x = X - g tan.  With s(tan) the traced shift of the page under a
lens, the fringe phase at X is

    psi = 2 pi [ x (1/p_r - 1/p_f) + s(tan)/p_r ] + const = 2 pi [ s/p_f + f (X - g tan + s) ] + const,

where f = 1/p_r - 1/p_f is the beat frequency far away.  In the second form f enters linearly, so one table serves
any pitch.

Convention: phases in rad, positive where the fringe is ahead; brightness of a shape in contrasts, (profile - level) /
    contrast; millimetres of the page, in the grating's own frame (`moireid.frames`), along its axis.
    Single precision resolves some millionths of a contrast and of a radian, and noise leaves a thousand times that.
Source: a small phase shift d adds w'(phase) d to a profile of shape w, so the residual against w' gives any deviation
    of places along the strip, to first order.  The law: `moireid.lenticule`; its first order is
    `optics.page_plane_slope_rad`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.frames import own_rect
from moireid.lenticule import MAX_TANGENT, view_law
from moireid.verifier.fringes.sinusoid import Fit, Single, fit_columns, fit_rows, fit_together, slope_of
from moireid.verifier.measuring import (
    COVERED_MISFIT_CONTRASTS,
    COVERED_MISFIT_RATIO,
    PLACE_CLEAR_RAD,
    STRIP_NOISE_RATIO,
)
from moireid.verifier.series import greatest_near
from moireid.verifier.tracking.brightness_profiles import CODING_POWER, Strip

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
        return 2 * np.pi * along

    def whole_phase_rad(self, frequency_per_mm: float) -> Array:
        """Predicted phase over the strip, (T, N), up to the constants that depend on assembly."""
        return np.asarray(2 * np.pi * (self.fixed + frequency_per_mm * self.per_frequency))

    def middle_phase_rad(self, frequency_per_mm: float) -> Array:
        """Predicted phase at the strip's middle, (T,), up to the constants that depend on assembly."""
        return np.asarray(2 * np.pi * (self.fixed_middle + frequency_per_mm * self.per_frequency_middle))


def within_law(strips: Sequence[Strip], camera_mm: Array) -> NDArray[np.bool_]:
    """Frames in which every strip is seen within the table of the law, (T,); beyond it only the edge value is known.

    Convention: camera_mm (T, 3), page millimetres.
    """
    known = np.ones(len(camera_mm), bool)
    reach = MAX_TANGENT * np.abs(camera_mm[:, 2])
    for strip in strips:
        along, across = strip.frame.places(camera_mm[:, :2]).T
        for end in (strip.along_mm[0], strip.along_mm[-1]):
            known &= np.abs(end - along) <= reach
        known &= np.abs(strip.across_mm - across) <= reach
    return known


def strip_law(badge: Badge, strip: Strip, camera_mm: Array) -> StripLaw:
    """The law of one strip for camera centres (T, 3).

    Convention and source: module docstring.  The table is traced for the grating's nominal pitch; over the pitches
    of one badge s changes by 0.5 %.
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
    shift = np.stack([np.interp(places, places[coarse], row) for row in shift_coarse])
    # Measured from the grating's middle, where the lines of all cells meet, so that phases of cells can be compared.
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    middle_mm = (low + high) / 2
    lens_x = places[None, :] - middle_mm - badge.lens.thickness_mm * tangent
    fixed, per_frequency = shift / badge.lens.pitch_mm, lens_x + shift
    return StripLaw(fixed[:, :-1], per_frequency[:, :-1], fixed[:, -1], per_frequency[:, -1])


Complex = NDArray[np.complex128]
#: Frames used to search and to refine the frequency, which is one figure for the whole film.
SEARCH_FRAMES = 32
REFINE_FRAMES = 64
BLOCKS = 4
#: Steps of the refinement, as shares of its reach: the last parabola is exact to a thousandth of it.
REFINE_STEPS = (1 / 2, 1 / 8, 1 / 32)
#: Frames fitted at a time.
PIECE_FRAMES = 512
#: A hand's soft edge is before the strip so many frames longer than it shows.
COVERED_EDGE_FRAMES = 2


@dataclass(frozen=True)
class StripPhase:
    """One strip over the film: phase at its middle and its standard deviation, contrast and level in counts, each (T,).

    frequency_per_mm is |f| with the sign of the search range; frequency_sd its standard deviation;
    covered (T,): where something that is no fringe covers a part of the strip (`covered_frames`), so that its phase
    is unknown; misfit: what fringes leave unexplained in a middling frame, as a share of the contrast; overtone (T,),
    complex: the third harmonic in contrasts, its phase less three times the fundamental's; 0 where it is not fitted.
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


def measure_strip(profiles: Array, law: StripLaw, length_mm: float, band_per_mm: tuple[float, float]) -> StripPhase:
    """Measure one strip.

    Parameters: profiles (T, N) counts; law: view geometry of the same frames and samples; band_per_mm: the lowest
        and highest signed beat frequency (camera far away) to look for.
    Convention: brightness = level + contrast cos(2 pi f (X - middle) + phase).
    Returns: StripPhase.
    Source: nonlinear least squares with the linear part solved exactly (variable projection).
    """
    frequency = _search(profiles, law, length_mm, band_per_mm)
    frequency = _refine(profiles, law, frequency, 0.4 / length_mm, REFINE_FRAMES)
    blocks = np.array_split(np.arange(len(profiles)), BLOCKS)
    apart = [
        _refine(profiles[block], _part(law, block), frequency, 0.4 / length_mm, REFINE_FRAMES // BLOCKS)
        for block in blocks
        if len(block) >= 4
    ]
    spread = float(np.std(apart, ddof=1) / np.sqrt(len(apart))) if len(apart) > 1 else np.inf
    harmonics = harmonics_of(frequency, length_mm)
    # In pieces, because the columns of the fit take some twenty times the memory of the profiles.
    pieces = [
        _fit(profiles[some], _part(law, some).phase_rad(frequency), harmonics)
        for some in np.array_split(np.arange(len(profiles)), -(-len(profiles) // PIECE_FRAMES))
    ]
    fringe = np.concatenate([piece.harmonics[:, 0] for piece in pieces])
    variance = np.concatenate([piece.fundamental_variance() for piece in pieces])
    level = np.concatenate([piece.background[:, 0] for piece in pieces])
    contrast = np.abs(fringe)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = STRIP_NOISE_RATIO * np.sqrt(variance) / contrast
    misfit = np.sqrt(np.concatenate([piece.left for piece in pieces]) / profiles.shape[1])
    covered = covered_frames(misfit, contrast)
    sd = np.where(covered, np.inf, np.nan_to_num(sd, nan=np.inf))
    usual = float(np.median(misfit) / max(np.median(contrast), 1e-9))
    overtone = np.concatenate([_overtone(piece) for piece in pieces])
    return StripPhase(np.angle(fringe), sd, contrast, level, frequency, spread, covered, usual, overtone)


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
        (`profiles`).
    """
    clear = (strip.phase_sd_rad <= np.median(strip.phase_sd_rad)) & (strip.contrast > 0)
    if not clear.any():
        return 0.0
    light_per_count = CODING_POWER * np.clip(strip.level[clear] / 255.0, 0.0, 1.0) ** (1 - 1 / CODING_POWER)
    return float(np.median(light_per_count / np.sqrt(12) / strip.contrast[clear]))


def _part(law: StripLaw, frames: NDArray[np.int64]) -> StripLaw:
    return StripLaw(
        law.fixed[frames], law.per_frequency[frames], law.fixed_middle[frames], law.per_frequency_middle[frames]
    )


def _spread_out(count: int, most: int) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, count - 1, min(most, count)).astype(int))


def _search(profiles: Array, law: StripLaw, length_mm: float, band: tuple[float, float]) -> float:
    """The strongest frequency of the band, on a grid of a fifth of a fringe across the strip."""
    frames = _spread_out(len(profiles), SEARCH_FRAMES)
    some = profiles[frames].astype(float)
    line = np.linspace(-1, 1, some.shape[1])
    some = some - some.mean(axis=1, keepdims=True)
    some = (some - (some @ line)[:, None] / (line @ line) * line) * np.hanning(some.shape[1])
    law = _part(law, frames)
    grid = np.arange(band[0], band[1] + 1e-9, 0.2 / length_mm)
    power = [np.abs((some * np.exp(-1j * law.phase_rad(f))).sum(axis=1)) ** 2 for f in grid]
    return float(grid[int(np.argmax(np.sum(power, axis=1)))])


def _refine(profiles: Array, law: StripLaw, start: float, reach: float, most: int) -> float:
    """Frequency near `start` that explains the profiles best."""
    frames = _spread_out(len(profiles), most)
    some, law = profiles[frames], _part(law, frames)
    place = start
    for step in (reach * share for share in REFINE_STEPS):
        move = 1.0
        while abs(move) == 1.0 and abs(place - start) <= reach:
            below, here, above = (
                float(_fit(some, law.phase_rad(place + way * step), 1).left.sum()) for way in (-1, 0, 1)
            )
            bend, slope = below - 2 * here + above, above - below
            # To the vertex of the parabola through the three, if it lies between them; else to the lower side.
            move = -0.5 * slope / bend if 2 * bend > abs(slope) else -float(np.sign(slope))
            place += step * move
    return float(np.clip(place, start - reach, start + reach))


def _fit(profiles: Array, phase_rad: Array, harmonics: int) -> Fit:
    """Fit each profile (T, N) with fringes on a level and a slope."""
    return fit_rows(profiles, phase_rad, harmonics, level_and_slope(profiles.shape[1]))


HARMONICS = 5


@dataclass(frozen=True)
class StripShape:
    """One strip in its clear frames: K of T frames, N samples.

    clear (T,): frames whose phase is read well; columns (K, 2 + 2 HARMONICS, N): level, slope along the strip, and
    cosine and sine of each harmonic, as `fit_columns` of the shape's argument; left (K, N): what the shape leaves of
    the brightness, without each frame's slope and what stays still (dirt, shading, an uneven lens sheet); slope (K, N):
    derivative of the shape by its argument, contrasts per rad.
    """

    clear: NDArray[np.bool_]
    columns: Single
    left: Single
    slope: Single


def strip_shape(profiles: Array, law: StripLaw, found: StripPhase) -> StripShape | None:
    """The shape of one strip; None if no frame is clear.

    Parameters: profiles (T, N) counts; law: of the same frames and samples; found: the strip as it was measured.
    Source: module docstring.
    """
    clear = found.phase_sd_rad < PLACE_CLEAR_RAD
    if not clear.any():
        return None
    turned = law.phase_rad(found.frequency_per_mm)[clear] + found.phase_rad[clear, None]
    background = level_and_slope(turned.shape[1])
    columns = fit_columns(turned.astype(np.float32), HARMONICS, background)
    with np.errstate(divide="ignore", invalid="ignore"):
        contrasts = (profiles[clear] - found.level[clear, None]) / found.contrast[clear, None]
    seen = np.nan_to_num(contrasts, posinf=0.0, neginf=0.0).astype(np.float32)
    # The slope of the background is each frame's own, and not the shape's.
    together = np.moveaxis(columns, 1, 0).reshape(columns.shape[1], -1)
    fringes = fit_together(together, seen.ravel(), np.arange(columns.shape[1]) != 1)
    left = seen - (fringes @ together).reshape(seen.shape)
    sloping = background[1].astype(np.float32)
    left -= np.outer(left @ sloping / (sloping @ sloping), sloping)
    left -= left.mean(axis=0)
    return StripShape(clear, columns, left, (slope_of(fringes) @ together).reshape(seen.shape))
