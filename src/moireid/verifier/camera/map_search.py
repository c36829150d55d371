"""Film-wide unknowns by least misfit: one alone, or several that are strongly correlated; and the path of a zoom.

A program or a hand that zooms changes the focal length from frame to frame, and one focal length for the whole film
makes distances and parallaxes wrong.  Where the badge is seen at a slant, its perspective gives the focal length of
each frame; where it is seen from the front it does not.  So the zoom's logarithm is a Gaussian process: smooth, and
known only where frames determine it.  It is accepted only where the film is far likelier with it than without.

Convention: a misfit is a function from the unknown to the reprojection errors of all frames, (T,) px.  A zoom's path is
its logarithm over the mean, (T,); pictures are zoomed about their middle.
Source: regression by a Gaussian process with a Matern covariance of order 3/2 (Rasmussen and Williams, Gaussian
    Processes for Machine Learning, 2006, 2.2 and 4.2), linearised again at each solution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: A homography has eight parameters, a pose six: each frame leaves two residuals that test the focal length.
SPARE_PER_FRAME = 2
#: A joint step is tried with this damping, and with ten times as much so often until it is a gain.
LEAST_DAMPING, MOST_TRIES = 1e-4, 8
#: Errors of frames so far apart that they correlate by less than this are independent; a film's tenth at most is tried.
LEAST_ALIKE, LEAST_ALIKE_FRAMES = 0.1, 10
#: Curvature below which rounding makes a direction's sign uncertain, as a share of that along each unknown.
LEAST_CURVATURE = 1e-12


def minimise(
    errors_px: Callable[[float], Array], low: float, high: float, prior: float, prior_sd: float
) -> tuple[float, float]:
    """Value of least misfit plus prior, and its standard deviation, by a parabola through the best three.

    The misfit of a frame is Cauchy's, log(1 + e^2/s^2), with s the median error at the best value: shaken or
    half-hidden frames count little.  Near the minimum it is a chi-square of `SPARE_PER_FRAME` residuals per frame.
    """
    tried: dict[float, Array] = {float(place): errors_px(float(place)) for place in np.linspace(low, high, 12)}
    step = (high - low) / 11

    def misfits(scale: float) -> tuple[Array, Array]:
        places = np.array(sorted(tried))
        cauchy = _misfits(np.array([tried[p] for p in places]), scale)
        return places, SPARE_PER_FRAME * cauchy + ((places - prior) / prior_sd) ** 2

    scale = min(float(np.median(errors)) for errors in tried.values()) or 1e-9
    for _ in range(4):
        step /= 2
        places, cost = misfits(scale)
        centre = float(places[int(np.argmin(cost))])
        for place in (centre - step, centre + step):
            if low <= place <= high and place not in tried:
                tried[place] = errors_px(place)
    places, cost = misfits(scale)
    best = int(np.clip(np.argmin(cost), 1, len(places) - 2))
    curve = np.polyfit(places[best - 1 : best + 2] - places[best], cost[best - 1 : best + 2], 2)
    if curve[0] <= 0:
        return float(places[int(np.argmin(cost))]), prior_sd
    place = float(np.clip(places[best] - curve[1] / (2 * curve[0]), places[best - 1], places[best + 1]))
    return place, float(min(1 / np.sqrt(curve[0]), prior_sd))


def posterior(
    errors_px: Callable[[float], Array], low: float, high: float, prior: float, prior_sd: float, spare: int
) -> tuple[float, float]:
    """Posterior mean and standard deviation of a poorly determined unknown, over a grid of 21 values.

    Parameters: spare: redundant residuals per frame.
    Source: misfit as in `minimise`; a shallow misfit may have several minima, so the mean is taken instead.
    """
    places = np.linspace(low, high, 21)
    tried = [errors_px(float(place)) for place in places]
    scale = min(float(np.median(errors)) for errors in tried) or 1e-9
    cost = spare * _misfits(np.array(tried), scale) + ((places - prior) / prior_sd) ** 2
    weight = np.exp(-0.5 * (cost - cost.min()))
    mean = float(np.average(places, weights=weight))
    spread = np.average((places - mean) ** 2, weights=weight) + (places[1] - places[0]) ** 2 / 12
    return mean, float(np.sqrt(spread))


def _misfits(errors_px: Array, scale: float) -> Array:
    """Cauchy's misfit of all frames, (P,), from (P, T); a frame without a pose counts as a large but finite error."""
    bounded = np.minimum(np.nan_to_num(errors_px, nan=np.inf), 1e3 * scale)
    return np.asarray(np.log1p((bounded / scale) ** 2).sum(axis=-1))


def repeated(residuals_px: Array) -> float:
    """In how many frames one and the same error is seen; 1 for independent ones.

    A coder leaves a page's markers where they were for some frames.  Errors that last carry no more information than
    one of them.
    Parameters: residuals_px (T, 2 P), in the order of time; each frame's are bounded by the median one.
    Source: integrated autocorrelation time, summed while neighbours are alike (Sokal, Monte Carlo methods in
        statistical mechanics, 1997).
    """
    size = np.linalg.norm(np.nan_to_num(residuals_px), axis=1)
    usual = float(np.median(size))
    if not usual > 0 or len(size) < 2 * LEAST_ALIKE_FRAMES:
        return 1.0
    left = np.nan_to_num(residuals_px) * np.minimum(1.0, usual / np.maximum(size, 1e-12))[:, None]
    power, total = float((left**2).sum()) / len(left), 1.0
    for lag in range(1, len(left) // LEAST_ALIKE_FRAMES):
        alike = float((left[lag:] * left[:-lag]).sum()) / (len(left) - lag) / power
        if alike < LEAST_ALIKE:
            break
        total += 2 * alike
    return total


@dataclass(frozen=True)
class Unknown:
    """An unknown: its bounds, its prior, and a step that is small for it.

    heavy: the prior is Student's t with three degrees of freedom instead of normal: mostly near, sometimes far.
    """

    low: float
    high: float
    prior: float
    prior_sd: float
    step: float
    heavy: bool = False

    @property
    def alone(self) -> tuple[float, float, float, float]:
        """Bounds and prior, as `minimise` and `posterior` take them."""
        return self.low, self.high, self.prior, self.prior_sd

    def near(self, place: float, steps: float) -> Unknown:
        """The same unknown, bounded to `steps` of its steps around `place`."""
        reach = steps * self.step
        return replace(self, low=max(self.low, place - reach), high=min(self.high, place + reach))

    def curve(self, place: float) -> tuple[float, float]:
        """Half of the cost's slope, and half of its Gauss-Newton curvature."""
        apart = (place - self.prior) / self.prior_sd
        weight = 4 / 3 / (1 + apart**2 / 3) if self.heavy else 1.0
        return weight * apart / self.prior_sd, weight / self.prior_sd**2

    def cost(self, place: Array) -> Array:
        """Twice the negative logarithm of the prior, up to a constant."""
        apart = ((place - self.prior) / self.prior_sd) ** 2
        return 4.0 * np.log1p(apart / 3.0) if self.heavy else apart


def step_together(
    residuals_px: Callable[[Array], Array],
    slopes_px: Array,
    start: Array,
    unknowns: Sequence[Unknown],
    scale_px: float,
    repeats: float = 1.0,
) -> tuple[Array, Array]:
    """One step towards the values of least misfit, and the covariance at its start; to be repeated until it is short.

    Parameters: residuals_px: from all unknowns (N,) to residuals (T, 2 P) px of P points a frame, smooth in the
        unknowns; slopes_px: their derivatives at the start, (N, T, 2 P); start (N,): near the minimum; scale_px: error
        of a typical frame, s in the misfit; repeats: as `repeated`.
    Returns: (N,) and (N, N).
    Source: misfit as in `minimise`, by Gauss-Newton with Levenberg's damping.  The misfit of focal length, shutter and
        distortion is a long, narrow valley.  A search of one at a time, or without slopes, stops before the minimum,
        and its error bar is the valley's width instead of its length.
    """
    spare = SPARE_PER_FRAME / repeats
    low, high = (np.array([getattr(u, name) for u in unknowns]) for name in ("low", "high"))

    def priors(at: Array) -> float:
        return float(sum(u.cost(at[k : k + 1])[0] for k, u in enumerate(unknowns)))

    def bounded(at: Array) -> tuple[Array, Array]:
        # A frame without a pose counts as a large but finite error.
        most = 1e3 * scale_px
        left = np.clip(np.nan_to_num(residuals_px(at), nan=most, posinf=most, neginf=-most), -most, most)
        return left, 2 * (left**2).mean(axis=1) / scale_px**2

    def cost(square: Array, at: Array) -> float:
        return spare * float(np.log1p(square).sum()) + priors(at)

    place = np.clip(np.asarray(start, float), low, high)
    left, square = bounded(place)
    weights = np.sqrt(2 * spare / (1 + square) / left.shape[1])[:, None] / scale_px
    table = (slopes_px * weights).reshape(len(unknowns), -1)
    slope, curve = np.array([u.curve(at) for u, at in zip(unknowns, place, strict=True)]).T
    bend = table @ table.T + np.diag(curve)
    slope = slope + table @ (left * weights).ravel()
    before, damping = cost(square, place), LEAST_DAMPING
    for _ in range(MOST_TRIES):
        step = -np.linalg.solve(bend + damping * np.diag(np.diag(bend)), slope)
        there = np.clip(place + step, low, high)
        found = cost(bounded(there)[1], there)
        if found <= before:
            return _further(lambda at: cost(bounded(at)[1], at), place, there, found, (low, high)), _inverse(bend)
        damping *= 10
    return place, _inverse(bend)


def _further(
    cost: Callable[[Array], float], start: Array, there: Array, found: float, bounds: tuple[Array, Array]
) -> Array:
    """The place from which going twice as far gains no more; weights that change with the place shorten each step."""
    while True:
        further = np.clip(start + 2 * (there - start), *bounds)
        value = cost(further)
        if not value < found:
            return there
        there, found = further, value


def _inverse(bend: Array) -> Array:
    """Inverse of a symmetric matrix that may be singular to rounding; never with a negative variance."""
    size = np.sqrt(np.diag(bend))
    values, axes = np.linalg.eigh(bend / np.outer(size, size))
    return np.asarray((axes / np.maximum(values, LEAST_CURVATURE)) @ axes.T / np.outer(size, size))


Numbers = NDArray[np.int64]
#: Standard deviations of a zoom's logarithm that are tried, and the time over which it changes, s.
SPREADS, CHANGES_S = (0.05, 0.2), 2.0
#: The mean over a film, which the focal length takes up, and from one cut to the next.
MEAN_SD, AFTER_CUT_SD = 0.15, 0.2
#: Errors of registration that go on over some frames: their share of the noise of one, and their time, s.
LASTING_SHARE, LASTING_S = 0.25, 0.4
#: The film must be so many times likelier with the zoom's path, as a natural logarithm.
CLEAR = 12.0
#: A frame's deviation from the path is bounded at so many standard deviations.
FAR_SDS = 6.0
#: A solution has settled if the path moves by less than this.
SETTLED, MOST_STEPS, LONGEST_STEP = 0.003, 8, 0.15

#: Residuals and their slopes under the path of a zoom (T,).
Residuals = Callable[[Array], tuple[Array, Array]]


def unzoomed(points_px: Array, log_zoom: Array, middle_px: tuple[float, float]) -> Array:
    """Points (T, N, 2) as if the picture had not been zoomed."""
    return np.asarray(middle_px + (points_px - np.array(middle_px)) * np.exp(-log_zoom)[:, None, None])


def zoom_path(
    residual_of: Residuals, frames: Numbers, times_s: Array, cuts: NDArray[np.bool_], noise_px: float
) -> Array | None:
    """The zoom's path, (T,), or None where the film does not clearly show one.

    Parameters: residual_of: `FilmCamera.zoom_residual` of unzoomed points, from the path (T,); frames: in which that
        measures; cuts (T,): frames before which the picture jumps; noise_px: standard deviation of a frame's residual.
    """
    numbers = np.asarray(np.cumsum(cuts), np.int64)
    likely, path = _likeliest(residual_of, frames, times_s, numbers, 0.0, noise_px, -np.inf)
    least = likely + CLEAR
    for spread in SPREADS:
        found, its_path = _likeliest(residual_of, frames, times_s, numbers, spread, noise_px, least)
        if found > max(likely, least):
            likely, path = found, its_path
    return np.asarray(path - path.mean()) if likely > least else None


def _likeliest(
    residual_of: Residuals,
    frames: Numbers,
    times_s: Array,
    numbers: Numbers,
    spread: float,
    noise_px: float,
    least: float,
) -> tuple[float, Array]:
    """Logarithm of the film's probability with zooms of this spread, and the likeliest path (T,).

    Convention: the search ends at once where a step leaves the film less likely than `least`.
    """
    clock, count = times_s[frames], len(frames)
    prior = _prior(times_s, clock, numbers, numbers[frames], spread)
    own = prior[frames]
    noise = noise_px**2 * (np.eye(count) + LASTING_SHARE**2 * _alike(clock, clock, LASTING_S))
    path, value = np.zeros(len(times_s)), -np.inf
    for _ in range(MOST_STEPS):
        residual, slope = residual_of(path)
        # A frame that is far off, as one that is shaken, is pulled in.
        target = slope * path[frames] + np.clip(residual, -FAR_SDS * noise_px, FAR_SDS * noise_px)
        factor = np.linalg.cholesky(slope[:, None] * own * slope + noise)
        solved = np.linalg.solve(factor.T, np.linalg.solve(factor, target))
        value = -0.5 * float(target @ solved) - float(np.log(np.diag(factor)).sum())
        step = prior @ (slope * solved) - path
        size = float(np.abs(step).max())
        path = path + step * min(1.0, LONGEST_STEP / max(size, 1e-12))
        if size < SETTLED or value < least:
            break
    return value, path


def _prior(times_s: Array, clock: Array, numbers: Numbers, own: Numbers, spread: float) -> Array:
    """Covariance of the path in all frames with that in the measured ones."""
    smooth = spread**2 * _alike(times_s, clock, CHANGES_S)
    jumps = np.where(numbers[:, None] == own[None], AFTER_CUT_SD**2, 0.0) if spread and numbers[-1] else 0.0
    return np.asarray(smooth + jumps + MEAN_SD**2)


def _alike(a: Array, b: Array, scale: float) -> Array:
    """Matern correlation of order 3/2."""
    apart = np.sqrt(3.0) * np.abs(a[:, None] - b[None]) / scale
    return np.asarray((1 + apart) * np.exp(-apart))
