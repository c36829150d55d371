"""Film-wide unknowns by least misfit: one alone, or several that share a valley.

Convention: a misfit is a function from the unknown to the reprojection errors of all frames, (T,) px.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: A homography has eight parameters, a pose six: each frame leaves two residuals that test the focal length.
SPARE_PER_FRAME = 2
#: Paraboloids that are fitted one after another in one search, and places at most where none fits.
ROUNDS, MOST_ROUNDS = 3, 9


def minimise(
    errors_px: Callable[[float], Array], low: float, high: float, prior: float, prior_sd: float
) -> tuple[float, float]:
    """Place of least misfit and prior together, and its standard deviation, by a parabola through the best three.

    The misfit of a frame is Cauchy's, log(1 + e^2/s^2) with s the median error at the best place: frames that were
    shaken or half hidden count little.  Near the bottom it is a chi-square of `SPARE_PER_FRAME` residuals a frame.
    """
    tried: dict[float, Array] = {float(place): errors_px(float(place)) for place in np.linspace(low, high, 12)}
    step = (high - low) / 11

    def misfits(scale: float) -> tuple[Array, Array]:
        places = np.array(sorted(tried))
        cauchy = np.array([_misfit(tried[p], scale) for p in places])
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
    """Mean and standard deviation of an unknown that the errors hardly tell, over a grid of 21 places.

    Parameters: spare: residuals a frame.
    Source: misfit as in `minimise`, of which a shallow one has more than one bottom, so none is sought.
    """
    places = np.linspace(low, high, 21)
    tried = [errors_px(float(place)) for place in places]
    scale = min(float(np.median(errors)) for errors in tried) or 1e-9
    cost = np.array([spare * _misfit(errors, scale) for errors in tried]) + ((places - prior) / prior_sd) ** 2
    weight = np.exp(-0.5 * (cost - cost.min()))
    mean = float(np.average(places, weights=weight))
    spread = np.average((places - mean) ** 2, weights=weight) + (places[1] - places[0]) ** 2 / 12
    return mean, float(np.sqrt(spread))


def _misfit(errors_px: Array, scale: float) -> float:
    """Cauchy's misfit of all frames; one whose pose could not be found is very wrong, not endlessly."""
    bounded = np.minimum(np.nan_to_num(errors_px, nan=np.inf), 1e3 * scale)
    return float(np.sum(np.log1p((bounded / scale) ** 2)))


@dataclass(frozen=True)
class Unknown:
    """An unknown: its bounds, its prior, and the step of a first search near its minimum.

    heavy: the prior's tails are Student's t of three degrees and not normal: mostly near, sometimes far.
    """

    low: float
    high: float
    prior: float
    prior_sd: float
    step: float
    heavy: bool = False

    def cost(self, place: Array) -> Array:
        """Twice the negative logarithm of the prior, but for a constant."""
        apart = ((place - self.prior) / self.prior_sd) ** 2
        return 4.0 * np.log1p(apart / 3.0) if self.heavy else apart


def minimise_together(
    errors_px: Callable[[Array], Array], start: Array, unknowns: Sequence[Unknown]
) -> tuple[Array, Array]:
    """Places of least misfit, and their covariance.

    Parameters: errors_px: of all unknowns (N,); start (N,): near the minimum.
    Returns: (N,) and (N, N); the priors' where the misfit has no minimum that a paraboloid describes.
    Source: misfit as in `minimise`.  Focal length, shutter and distortion share a valley, along which seeking one at a
        time stops early, with an error bar for the valley's width instead of its length; so a paraboloid is fitted to
        places around the best one (its middle, two along each axis, four in each plane of two), and again around its
        minimum, ever nearer.
    """
    scale = float(np.median(errors_px(start))) or 1e-9
    low, high, prior_sd, step = (
        np.array([getattr(u, name) for u in unknowns]) for name in ("low", "high", "prior_sd", "step")
    )
    grid = _composite(len(unknowns))
    pairs = [(a, b) for a in range(len(unknowns)) for b in range(a, len(unknowns))]
    terms = np.column_stack([np.ones(len(grid)), grid, *(grid[:, a] * grid[:, b] for a, b in pairs)])
    place, covariance = np.asarray(start, float), np.diag(prior_sd**2)
    fitted = 0
    for _ in range(MOST_ROUNDS):
        if fitted == ROUNDS:
            break
        centre = np.clip(place, low + step, high - step)
        places = centre + grid * step
        misfit = SPARE_PER_FRAME * np.array([_misfit(errors_px(at), scale) for at in places])
        cost = misfit + sum(u.cost(places[:, k]) for k, u in enumerate(unknowns))
        found = np.linalg.lstsq(terms, cost, rcond=None)[0]
        slope, bend = found[1 : 1 + len(unknowns)], np.zeros((len(unknowns), len(unknowns)))
        for (a, b), value in zip(pairs, found[1 + len(unknowns) :], strict=True):
            bend[a, b] += value
            bend[b, a] += value
        if np.linalg.eigvalsh(bend).min() <= 0:
            # Far out the misfit is flat, so the way is taken that leads down; at a bottom the step was too wide for it.
            best = int(np.argmin(cost))
            place, step = places[best], step if best else step / 2
            continue
        fitted += 1
        move = np.clip(-np.linalg.solve(bend, slope), -2.0, 2.0)
        place = np.clip(centre + move * step, low, high)
        covariance = 2 * np.linalg.inv(bend) * np.outer(step, step)
        if np.abs(move).max() < 1:
            step = step / 2
    return place, covariance


def _composite(count: int) -> Array:
    """The middle, two places along each axis, and four in each plane of two axes; enough for every term of degree 2."""
    rows = [np.zeros(count)]
    for a in range(count):
        for sign in (-1.0, 1.0):
            rows.append(sign * np.eye(count)[a])
    for a in range(count):
        for b in range(a + 1, count):
            rows += [u * np.eye(count)[a] + v * np.eye(count)[b] for u in (-1.0, 1.0) for v in (-1.0, 1.0)]
    return np.array(rows)
