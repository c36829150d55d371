"""From the brightness of a chart's bands to the line frequency of the lens, one estimate per band.

1. Search the lens frequency that explains the fringes of all bands at once.
2. Refine it band by band.

Convention: page millimetres; the phase of band k at the page's point X is 2 pi [(x + s) / p_k - x q], with x where the
sight line crosses the lens plane and s the traced shift (`predicted_phase`); q = 1 / p_f is the lens's line frequency,
cycles per mm of the *printed page*.  All bands share one q, so the sign of each band's fringes is known.
Source: nonlinear least squares with the linear part solved exactly (variable projection), as in `strip_phase`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from moireid.badge import Badge
from moireid.calibration.chart_reading import ChartView, parts_in_a_band, parts_of, printed_frequencies
from moireid.lenticule import view_law
from moireid.verifier.fringes.sinusoid import fit_rows
from moireid.verifier.tracking.brightness_profiles import ProfileReader

Array = NDArray[np.float64]
#: Fewer fringes across a band look like shading.
MIN_FRINGES = 1.5
#: A band is readable if its fringes explain this share of the variance without shading, and have this contrast, counts.
MIN_EXPLAINED, MIN_CONTRAST = 0.6, 2.5
HARMONICS = 3
#: The search extends beyond the outermost bands by this many of the chart's steps.
BEYOND_STEPS = 3.0
#: With two samples per millimetre, blurred by `BLUR_MM`, 2 sqrt(pi) BLUR_MM 2 = 3.5 samples share their noise.
SAMPLE_NOISE_RATIO = 3.5


@dataclass(frozen=True)
class BandReading:
    """One band: its number, printed frequency 1/p_k, and its estimate of the lens.

    lens_per_mm: q, cycles per mm of page; sd: its standard deviation from the picture's noise; fringes: number across
    the band, signed; parts: for each part its place across the fringes, mm, and its phase at the field's middle, rad;
    explained: share of the profiles' variance, 0 to 1; readable: whether the band may be used.
    """

    number: int
    printed_per_mm: float
    lens_per_mm: float
    sd: float
    fringes: float
    parts: tuple[tuple[float, float], ...]
    explained: float
    readable: bool


class BandFit:
    """Least squares of every band's fringes over all views, for any lens frequency q."""

    def __init__(self, views: list[ChartView], chart: Badge) -> None:
        strips = ProfileReader(parts_of(chart)).strips
        grating, lens = chart.gratings[0], chart.lens
        law = view_law(lens, grating.pitch_mm)
        middle_mm = (grating.rect_mm[0] + grating.rect_mm[2]) / 2
        self.printed, self.views = printed_frequencies(chart), views
        self._parts = parts_in_a_band(chart)
        self.across_mm = np.array([strip.across_mm for strip in strips])
        along = strips[0].along_mm
        self.length_mm = float(along[-1] - along[0])
        self._place = place = (along - along.mean()) / (self.length_mm / 2)
        # Shading: light that falls off to the sides must not count as a fringe.
        self._shading = np.linalg.qr(np.column_stack([np.ones_like(place), place, place**2]))[0].T
        self._lens_x, self._line_x = [], []
        for view in views:
            distance = abs(float(view.camera_mm[2]))
            tangent = (along - view.camera_mm[0]) / distance
            across = (self.across_mm - view.camera_mm[1]) / distance
            shift = law.phase_rad(tangent[None, :], across[:, None]) * grating.pitch_mm / (2 * np.pi)
            self._lens_x.append(along - middle_mm - lens.thickness_mm * tangent)
            self._line_x.append(self._lens_x[-1] + shift)

    def phase_rad(self, view: int, parts: slice, lens_per_mm: float) -> Array:
        """Phase over some parts of one band, (P, N), up to a constant that depends on the sheet's place."""
        printed = self._line_x[view][parts] * self.printed[parts.start // self._parts]
        return np.asarray(2 * np.pi * (printed - self._lens_x[view] * lens_per_mm))

    def left(self, band: int, lens_per_mm: float, harmonics: int) -> tuple[float, float, NDArray[np.complex128]]:
        """Residual sums of squares of a band over its parts in all views: with shading and fringes, and with shading
        alone.

        Also returns the first view's fringes, one complex number per part: contrast in counts, and phase at the middle.
        """
        parts = slice(band * self._parts, (band + 1) * self._parts)
        profiles = np.stack([view.profiles[parts] for view in self.views])
        argument = np.stack([self.phase_rad(k, parts, lens_per_mm) for k in range(len(self.views))])
        found = fit_rows(profiles, argument, harmonics, self._shading)
        shaded = profiles - profiles @ self._shading.T @ self._shading
        return float(found.left.sum()), float((shaded**2).sum()), found.harmonics[0, :, 0]

    def search(self, low: float, high: float) -> float:
        """The q that explains all bands best, on a grid of a tenth of a fringe across a band."""
        grid = np.arange(low, high, 0.1 / self.length_mm)
        scores = np.zeros(len(grid))
        for band in range(len(self.printed)):
            for k, q in enumerate(grid):
                # Near its match a band looks like shading.
                if abs(self.printed[band] - q) * self.length_mm >= 0.5:
                    rest, shaded, _ = self.left(band, q, 1)
                    scores[k] += 1 - rest / max(shaded, 1e-9)
        return float(grid[int(np.argmax(scores))])

    def read(self, band: int, near: float) -> BandReading:
        """The estimate of q from one band, near the common value of all bands."""
        reach = 0.35 / self.length_mm
        found = float(
            minimize_scalar(
                lambda q: self.left(band, q, HARMONICS)[0],
                bounds=(near - reach, near + reach),
                method="bounded",
                options={"xatol": 1e-4 * reach},
            ).x
        )
        rest, shaded, seen = self.left(band, found, HARMONICS)
        step = 0.05 / self.length_mm
        bend = self.left(band, found - step, HARMONICS)[0] + self.left(band, found + step, HARMONICS)[0] - 2 * rest
        profiles = self._parts * len(self.views)
        free = max((len(self._place) / SAMPLE_NOISE_RATIO - 2 * HARMONICS - 4) * profiles, 1.0)
        # Near the least sum of squares S, the variance of q is 2 (S / free) / S'' for independent samples.
        sd = float(np.sqrt(2 * rest / free * step**2 / bend)) if bend > 0 else float("inf")
        explained = 1 - rest / max(shaded, 1e-9)
        parts = slice(band * self._parts, (band + 1) * self._parts)
        fringes = (self.printed[band] - found) * self.length_mm
        readable = (
            abs(fringes) >= MIN_FRINGES
            and explained >= MIN_EXPLAINED
            and float(np.median(np.abs(seen))) >= MIN_CONTRAST
            and abs(found - near) < 0.95 * reach
            and np.isfinite(sd)
        )
        return BandReading(
            band + 1,
            float(self.printed[band]),
            found,
            sd,
            float(fringes),
            tuple(zip(self.across_mm[parts].tolist(), np.angle(seen).tolist(), strict=True)),
            explained,
            bool(readable),
        )


def read_bands(views: list[ChartView], chart: Badge) -> list[BandReading]:
    """Every band of the chart, in their order.

    Convention: module docstring.
    Raises: MediaError where the pictures show no fringes that one lens could make.
    """
    fit = BandFit(views, chart)
    # The mean step between bands; the search extends beyond both ends by a few of them.
    step = float(np.abs(np.diff(fit.printed)).mean())
    low, high = fit.printed.min() - BEYOND_STEPS * step, fit.printed.max() + BEYOND_STEPS * step
    near = fit.search(float(low), float(high))
    return [fit.read(band, near) for band in range(len(fit.printed))]
