"""How large a residual is, how many independent samples it holds, and odds of explanations.

A motion of its own on top of the law fits at least as well as the law, so it is judged by how large the deviation is
that it explains.  On honest films the logarithm of that, over what known errors explain, is normally distributed; a
forged deviation adds in squares and is `FORGED_MIN_SHARE` to `FORGED_MAX_SHARE` of the motion, each octave equally
likely.

Convention: decadic logarithm of the law's odds, above 0 where the law is likelier.
Source: Bayes; mean and standard deviation by `moireid lab bench priors`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import limits

Array = NDArray[np.float64]
#: Where the autocorrelation of a residual has fallen below this, it is taken as noise.  Set by hand.
CORRELATED = 0.2


def spread_rad(residual_rad: Array) -> Array:
    """Size of residuals (N, D): the mean of a robust and a plain standard deviation, (D,), rad.

    Notes
    -----
    Source: 1.4826 times the median absolute deviation is the standard deviation of a normal distribution.  The plain
    one alone would rest on a few bad poses, the robust one alone would overlook a short forged part.
    """
    middle = np.median(residual_rad, axis=0)
    robust = 1.4826 * np.median(np.abs(residual_rad - middle), axis=0)
    return np.asarray(0.5 * robust + 0.5 * residual_rad.std(axis=0))


def deviation_rad(residual_rad: Array, step_s: float, within_rad: float = 0.0) -> float:
    """How far a film leaves the law: by what lasts for `LASTING_S`, or by a part of what changes faster, rad.

    Parameters: residual_rad (N,): of one film; step_s: time between two blocks; within_rad: spread within a block.

    Notes
    -----
    Convention: noise from frame to frame counts by one over `POSSIBLE_RESIDUAL_RATIO`.  Fringes that are no badge's
        differ from the law for longer; so short a deviation comes from codecs, mixed frames and single bad poses.
    """
    width = max(1, round(limits.LASTING_S / step_s))
    window = np.ones(min(width, len(residual_rad)))
    frames = np.convolve(np.ones(len(residual_rad)), window, "same")
    lasting = np.convolve(residual_rad, window, "same") / frames
    whole = math.hypot(float(spread_rad(residual_rad[:, None])[0]), within_rad)
    return max(float(spread_rad(lasting[:, None])[0]), whole / limits.POSSIBLE_RESIDUAL_RATIO)


def independent_samples(residual_rad: Array) -> float:
    """Number of independent samples in a residual (N,), from its autocorrelation.

    Notes
    -----
    Source: N over one plus twice the sum of the autocorrelations (Bartlett 1935), up to the first below `CORRELATED`.
    """
    left, count = residual_rad - residual_rad.mean(), len(residual_rad)
    power = np.abs(np.fft.rfft(left, 2 * count)) ** 2
    together = np.fft.irfft(power)[:count]
    if together[0] <= 0:
        return limits.LEAST_SAMPLES
    together = together / together[0]
    end = int(np.argmax(together < CORRELATED)) or count
    return float(max(count / (1 + 2 * together[1:end].sum()), limits.LEAST_SAMPLES))


def log10_odds(own: float, other: float, blocks: float, samples: float) -> float:
    """Decadic logarithm of the odds of one explanation over another, from their residuals' sums of squares.

    Parameters: own, other: sums over the blocks, rad^2; blocks: number of them; samples: independent ones.

    Notes
    -----
    Source: ratio of normal likelihoods whose standard deviation is fitted; each block has `UNMODELLED_RAD` of error
    that no explanation models.
    """
    floor = blocks * limits.UNMODELLED_RAD**2
    return float(samples / 2 * np.log10((other + floor) / (own + floor)))


def residual_limit_rad(expected_error_rad: float, sds: float = limits.USUAL_SDS) -> float:
    """What honest films leave of the phase, but for few, with that expected error of a frame.

    Parameters: sds: standard deviations beyond the mean; those of `limits.PROOF_SDS` no honest film has.
    """
    one = limits.OWN_MOTION
    return one.quantile(sds, one.unit_rad(0.0, expected_error_rad))


def credible_error_rad(excitation_rad: float, expected_error_rad: float) -> float:
    """The expected error as far as it may excuse a deviation: a film that is made noisy must not buy room for a lie."""
    return min(expected_error_rad, limits.MAX_ERROR_SHARE * excitation_rad)


def own_motion_odds(deviation_rad: float, excitation_rad: float, error_rad: float) -> float:
    """The odds of the law over the law with a motion of its own on top.

    Parameters: deviation_rad: from the law, root mean square; excitation_rad: spread of the predicted phase; error_rad:
        expected error of one frame.
    """
    one = limits.OWN_MOTION
    unit = one.unit_rad(0.0, error_rad)
    shares = np.geomspace(limits.FORGED_MIN_SHARE, limits.FORGED_MAX_SHARE, 24)
    forged = np.log(np.hypot(shares * excitation_rad / unit, math.exp(one.mean_log)))
    # A deviation below the mean is not suspicious; both densities are then taken at the mean.
    place = max(math.log(max(deviation_rad / unit, 1e-6)), one.mean_log)
    true = -0.5 * ((place - one.mean_log) / one.sd_log) ** 2
    apart = -0.5 * ((place - forged) / one.sd_log) ** 2
    most = float(apart.max())
    return float(true - most - math.log(float(np.mean(np.exp(apart - most))))) / math.log(10)
