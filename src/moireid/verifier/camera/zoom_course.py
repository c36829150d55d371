"""The course of a zoom within a film, from the page's corners alone.

A program or a hand that zooms changes the focal length from frame to frame, and one focal length for the whole film
makes distances and parallaxes wrong.  Where the badge is seen at a slant, its perspective tells the focal length of
each frame; where it is seen from the front it does not.  So the zoom's logarithm is a Gaussian process: smooth, and
known only where frames tell it.  It is believed only where the film is far likelier with it than without.

Convention: logarithm of the zoom over its mean, (T,); pictures are zoomed about their middle.
Source: regression by a Gaussian process with a Matern covariance of order 3/2 (Rasmussen and Williams, Gaussian
    Processes for Machine Learning, 2006, 2.2 and 4.2), linearised again at each solution.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
#: Standard deviations of a zoom's logarithm that are tried, and the time over which it changes, s.
SPREADS, CHANGES_S = (0.05, 0.2), 2.0
#: The mean over a film, which the focal length takes up, and from one cut to the next.
MEAN_SD, AFTER_CUT_SD = 0.15, 0.2
#: Errors of registration that go on over some frames: their share of the noise of one, and their time, s.
LASTING_SHARE, LASTING_S = 0.25, 0.4
#: The film must be so many times likelier with the course, as a natural logarithm.
CLEAR = 12.0
#: What a frame tells beyond so many standard deviations is bounded.
FAR_SDS = 6.0
#: A solution has settled if the course moves by less than this.
SETTLED, MOST_STEPS, LONGEST_STEP = 0.003, 8, 0.15


class Film(Protocol):
    """What is needed of a film's camera, `self_calibration.FilmWide`."""

    def zoom_told(self) -> tuple[Array, Array]:
        """As `FilmWide.zoom_told`."""


def unzoomed(points_px: Array, log_zoom: Array, middle_px: tuple[float, float]) -> Array:
    """Points (T, N, 2) as if the picture had not been zoomed."""
    return np.asarray(middle_px + (points_px - np.array(middle_px)) * np.exp(-log_zoom)[:, None, None])


def zoom_course(
    film_of: Callable[[Array], Film], frames: Numbers, times_s: Array, cuts: NDArray[np.bool_], noise_px: float
) -> Array | None:
    """The course, or None where the film does not clearly tell one.

    Parameters: film_of: the film of unzoomed points, from the course (T,); frames: those in which `Film.zoom_told`
        measures; cuts (T,): frames before which the picture jumps; noise_px: of what a frame tells, standard deviation.
    """
    numbers = np.asarray(np.cumsum(cuts), np.int64)
    likely, course = _likeliest(film_of, frames, times_s, numbers, 0.0, noise_px, -np.inf)
    least = likely + CLEAR
    for spread in SPREADS:
        found, its_course = _likeliest(film_of, frames, times_s, numbers, spread, noise_px, least)
        if found > max(likely, least):
            likely, course = found, its_course
    return np.asarray(course - course.mean()) if likely > least else None


def _likeliest(
    film_of: Callable[[Array], Film],
    frames: Numbers,
    times_s: Array,
    numbers: Numbers,
    spread: float,
    noise_px: float,
    least: float,
) -> tuple[float, Array]:
    """Logarithm of the film's probability with zooms of this spread, and the likeliest course (T,).

    Convention: the search ends at once where a step leaves the film less likely than `least`.
    """
    clock, count = times_s[frames], len(frames)
    prior = _prior(times_s, clock, numbers, numbers[frames], spread)
    own = prior[frames]
    noise = noise_px**2 * (np.eye(count) + LASTING_SHARE**2 * _alike(clock, clock, LASTING_S))
    course, value = np.zeros(len(times_s)), -np.inf
    for _ in range(MOST_STEPS):
        told, slope = film_of(course).zoom_told()
        # A frame that lies far off, as one that is shaken, is pulled in.
        told = slope * course[frames] + np.clip(told, -FAR_SDS * noise_px, FAR_SDS * noise_px)
        factor = np.linalg.cholesky(slope[:, None] * own * slope + noise)
        solved = np.linalg.solve(factor.T, np.linalg.solve(factor, told))
        value = -0.5 * float(told @ solved) - float(np.log(np.diag(factor)).sum())
        step = prior @ (slope * solved) - course
        size = float(np.abs(step).max())
        course = course + step * min(1.0, LONGEST_STEP / max(size, 1e-12))
        if size < SETTLED or value < least:
            break
    return value, course


def _prior(times_s: Array, clock: Array, numbers: Numbers, own: Numbers, spread: float) -> Array:
    """Covariance of the course in all frames with that in the measured ones."""
    smooth = spread**2 * _alike(times_s, clock, CHANGES_S)
    jumps = np.where(numbers[:, None] == own[None], AFTER_CUT_SD**2, 0.0) if spread and numbers[-1] else 0.0
    return np.asarray(smooth + jumps + MEAN_SD**2)


def _alike(a: Array, b: Array, scale: float) -> Array:
    """Matern correlation of order 3/2."""
    apart = np.sqrt(3.0) * np.abs(a[:, None] - b[None]) / scale
    return np.asarray((1 + apart) * np.exp(-apart))
