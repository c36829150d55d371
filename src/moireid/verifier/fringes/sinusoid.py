"""Least squares of a sinusoid of known argument, with harmonics, on a smooth background; and phase unwrapping.

The model of a row of samples is

    value = sum_b d_b background_b + Re sum_h c_h exp(i h argument),    h = 1 .. H.

Phases are unwrapped within segments of frames that join (`joined_frames`, `unwrap`).

Shapes: rows are (..., N); each row along N is fitted by itself.  A background is (B, N), the same for all rows. Columns
are (..., K, N): the background first, then cos, sin, cos 2, sin 2, ...  A phase to unwrap has one entry per frame,
(T,); segments are index arrays of frames, in order of time.
Units: arguments and phases in rad; coefficients in those of the values.
Convention: value = contrast cos(argument + phase) has c_1 = contrast exp(i phase), so a phase is positive where the
fringe is ahead.
Source: linear least squares by its normal equations (Golub and Van Loan, Matrix Computations, 5.3).  Itoh's condition:
a phase can be unwrapped where neighbours differ by less than half a turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.camera.smoothing import unbroken
from moireid.verifier.measuring import MAX_GAP_S, MAX_STEP_RAD

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Complex = NDArray[np.complex128]
#: A ridge of this share of the samples keeps the equations solvable if columns alias onto one another.
RIDGE_SHARE = 1e-9
#: Samples whose columns are in memory at a time: 1.4 MB for five harmonics, where a chapter's would be 43 MB.
BLOCK_SAMPLES = 1 << 14


@dataclass(frozen=True)
class Fit:
    """Rows that were fitted one by one.

    background (..., B); harmonics (..., H), complex: c_1 to c_H; left (...): residual sum of squares; gram (..., K, K):
    the normal matrix; samples: N.
    """

    background: Array
    harmonics: Complex
    left: Array
    gram: Array
    samples: int

    def fundamental_variance(self) -> Array:
        """Variance of the fundamental's cosine, (...,), from the residual of the row; for independent samples."""
        first, unknowns = self.background.shape[-1], self.gram.shape[-1]
        noise = self.left / max(self.samples - unknowns, 1)
        return np.asarray(np.maximum(noise * np.linalg.inv(self.gram)[..., first, first], 0.0))


def fit_rows(values: Array, argument_rad: Array, harmonics: int, background: Array) -> Fit:
    """Fit every row by itself.

    Parameters: values, argument_rad (T, ..., N), rad; background (B, N).
    Convention and source: module docstring.
    """
    found, gram, left = _fitted_in_blocks(values, argument_rad, harmonics, background)
    first = len(background)
    turns = found[..., first::2] - 1j * found[..., first + 1 :: 2]
    return Fit(found[..., :first], turns, (left**2).sum(axis=-1), gram, values.shape[-1])


def left_of_rows(values: NDArray[Any], argument_rad: NDArray[Any], harmonics: int, background: Array) -> NDArray[Any]:
    """What the fit of every row by itself leaves, (T, ..., N).  Parameters: as `fit_rows`."""
    return _fitted_in_blocks(values, argument_rad, harmonics, background)[2]


def _fitted_in_blocks(
    values: NDArray[Any], argument_rad: NDArray[Any], harmonics: int, background: Array
) -> tuple[Array, Array, NDArray[Any]]:
    """As `_fitted`, with the columns of some rows in memory at a time."""
    fits = [
        _fitted(some, fit_columns(argument, harmonics, background))
        for some, argument in zip(in_blocks(values), in_blocks(argument_rad), strict=True)
    ]
    found, gram, left = (np.concatenate(parts) for parts in zip(*fits, strict=True))
    return found, gram, left


def in_blocks(rows: NDArray[Any]) -> list[NDArray[Any]]:
    """Rows (T, ..., N) in parts of about `BLOCK_SAMPLES`."""
    return np.array_split(rows, max(rows.size // BLOCK_SAMPLES, 1))


def fitted_rows(values: NDArray[Any], columns: NDArray[Any]) -> tuple[Array, NDArray[Any]]:
    """The fit of every row by itself: coefficients (..., K), and what is left, (..., N); columns: of `fit_columns`."""
    found, _, left = _fitted(values, columns)
    return found, left


def _fitted(values: NDArray[Any], columns: NDArray[Any]) -> tuple[Array, Array, NDArray[Any]]:
    """Coefficients (..., K), normal matrices (..., K, K) and what is left (..., N)."""
    rows = columns.swapaxes(-1, -2)
    gram = (columns @ rows).astype(float)
    solved = _solve(gram, (columns @ values[..., None]).astype(float), values.shape[-1])
    return solved[..., 0], gram, np.asarray(values - (rows @ solved.astype(values.dtype))[..., 0])


def fit_series(
    values: NDArray[Any], argument_rad: Array, harmonics: int, *, harmonic_ridge_share: float = 0.0
) -> Complex:
    """The Fourier series, c_0 to c_H, that fits all samples best (evaluate it with `wave_and_slope`).

    Parameters: values, argument_rad of one shape, any; harmonic_ridge_share: of the samples, holds c_2 and up near 0.
    Convention and source: module docstring; c_0 is real, the mean level.
    """
    flat, argument = values.ravel(), argument_rad.ravel()
    unknowns = 1 + 2 * harmonics
    gram, right = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    for start in range(0, len(flat), BLOCK_SAMPLES):
        block = slice(start, start + BLOCK_SAMPLES)
        columns = fit_columns(argument[block], harmonics, np.ones((1, 1)))
        gram += columns @ columns.T
        right += columns @ flat[block]
    held = range(3, unknowns)
    gram[held, held] += harmonic_ridge_share * len(flat)
    solved = _solve(gram, right[:, None], len(flat))[:, 0]
    return np.concatenate([solved[:1].astype(complex), solved[1::2] - 1j * solved[2::2]])


def wave_and_slope(coefficients: Complex, columns: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """The Fourier series c_0 .. c_H without its level, and its derivative by the argument, per rad, (..., N) each.

    Parameters: columns (..., 2 H, N): of `fit_columns` without a background, in whose precision the sums are.
    """
    parts = np.stack([coefficients, 1j * np.arange(len(coefficients)) * coefficients])[:, 1:]
    turns = np.stack([parts.real, -parts.imag], axis=-1).reshape(2, -1).astype(columns.dtype)
    fringe, slope = np.tensordot(turns, columns, axes=(1, -2))
    return fringe, slope


def fit_columns(argument_rad: NDArray[Any], harmonics: int, background: Array) -> NDArray[Any]:
    """The columns of the fit, (..., B + 2 H, N): the background, then cosine and sine of each harmonic.

    Convention: of the argument's precision; in memory one column lies after another, which is faster to fill.
    Source: angle addition formulas, so that only one cosine and one sine are computed.
    """
    first = len(background)
    columns = np.empty((first + 2 * harmonics, *argument_rad.shape), argument_rad.dtype)
    for column, row in zip(columns, background, strict=False):
        column[:] = row
    cosine, sine = columns[first], columns[first + 1]
    np.cos(argument_rad, out=cosine)
    np.sin(argument_rad, out=sine)
    for k in range(first + 2, len(columns), 2):
        before, across = columns[k - 2], columns[k - 1]
        columns[k] = before * cosine - across * sine
        columns[k + 1] = across * cosine + before * sine
    return np.moveaxis(columns, 0, -2)


def _solve(gram: Array, right: Array, samples: int) -> Array:
    """Solution of the normal equations; the ridge is added to `gram` in place."""
    unknowns = range(gram.shape[-1])
    gram[..., unknowns, unknowns] += RIDGE_SHARE * samples
    return np.asarray(np.linalg.solve(gram, right))


Frames = NDArray[np.int64]


def joined_frames(predicted_rad: Array, times_s: Array, numbers: Frames | None = None) -> list[Frames]:
    """Segments in which each phase can be unwrapped from the one before.

    They end at gaps, and where the predicted phase moves by nearly half a turn or more between two frames;
    and with each stretch, whose numbers (T,) may be given.
    """
    fast = np.abs(np.diff(predicted_rad)) > MAX_STEP_RAD
    return [
        part
        for stretch in unbroken(times_s, MAX_GAP_S, numbers)
        for part in np.split(stretch, np.flatnonzero(fast[stretch[:-1]]) + 1)
    ]


def numbered(segments: Sequence[Frames], count: int) -> Frames:
    """The number of each frame's segment, (T,); a frame of none has that of the segment before."""
    begins = np.zeros(count, np.int64)
    for segment in segments[1:]:
        begins[segment[0]] = 1
    return np.cumsum(begins)


def unwrap(phase_rad: Array, predicted_rad: Array, segments: Sequence[Frames]) -> Array:
    """Phase without jumps of a turn, (T,).

    Within a segment the prediction is not used.  Between segments the number of whole turns is unknown, so the one
    nearest to the prediction is taken.  A forger gains no more than whole turns per gap from that.  Frames outside all
    segments have no phase and get the prediction.
    """
    longest = max(segments, key=len, default=np.zeros(0, int))
    if not len(longest):
        return predicted_rad.copy()
    anchor = float(np.mean(np.unwrap(phase_rad[longest]) - predicted_rad[longest]))
    unwrapped = predicted_rad + anchor
    for segment in segments:
        unwrapped[segment] = np.unwrap(phase_rad[segment])
        if segment is not longest:
            apart = float(np.mean(unwrapped[segment] - predicted_rad[segment])) - anchor
            unwrapped[segment] -= 2 * np.pi * np.round(apart / (2 * np.pi))
    return unwrapped
