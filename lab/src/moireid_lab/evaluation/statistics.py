"""How well scores separate genuine films from forged ones: plain functions over arrays.

Convention: a greater score is more genuine; a film is accepted if its score is at least the threshold.  A film without
    a score has -inf: no threshold accepts it.  All intervals are of 95 % for independent films; with many films of one
    scene they are too narrow.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, isotonic_regression
from scipy.stats import binomtest, bootstrap, norm

Array = NDArray[np.float64]
LEVEL = 0.95
RESAMPLES = 2000
#: Least number of films of each kind for resampling.
LEAST_RESAMPLED = 5


@dataclass(frozen=True)
class Roc:
    """Rates at every threshold that changes them, from the one that accepts nothing downwards.

    false_accept, true_accept (K,): shares of forged and of genuine films accepted; threshold (K,), the first is inf.
    """

    false_accept: Array
    true_accept: Array
    threshold: Array


@dataclass(frozen=True)
class Threshold:
    """The threshold of greatest accuracy, with the rates there."""

    threshold: float
    accuracy: float
    balanced_accuracy: float
    false_accept: float
    false_reject: float


def roc(genuine: Array, forged: Array) -> Roc:
    """The receiver operating characteristic of scores (M,) against scores (N,), neither empty and none of them NaN.

    Convention: films of equal score share one step, and so do films without a score; the last step accepts all.
    """
    values, place = np.unique(np.concatenate([genuine, forged]), return_inverse=True)
    shares = []
    for some in (place[len(genuine) :], place[: len(genuine)]):
        counts = np.bincount(some, minlength=len(values))[::-1]
        shares.append(np.concatenate([[0.0], np.cumsum(counts) / len(some)]))
    return Roc(shares[0], shares[1], np.concatenate([[np.inf], values[::-1]]))


def area(curve: Roc) -> float:
    """Area under the curve: the probability that a genuine film scores higher than a forged one; ties count half."""
    return float(np.trapezoid(curve.true_accept, curve.false_accept))


def area_interval(auc: float, genuine: int, forged: int) -> tuple[float, float]:
    """Interval of an AUC from the numbers of films of each kind; it has a width even if the AUC is 0 or 1.

    Source: Newcombe, Statistics in Medicine 25 (2006) 559, method 5: a score interval with Hanley and McNeil's
        variance, in which both numbers of films are replaced by their mean.
    """
    z, both = float(norm.ppf(0.5 + LEVEL / 2)), (genuine + forged) / 2 - 1

    def low(at: float) -> float:
        if at <= 0:
            return 0.0

        def short(x: float) -> float:
            inner = 1 + both * ((1 - x) / (2 - x) + x / (1 + x))
            return at - x - z * math.sqrt(x * (1 - x) * inner / (genuine * forged))

        # At 1 the variance is 0 and 1 is a root too; the wanted root lies below.
        return float(brentq(short, 0.0, min(at, 1 - 1e-9)))

    return low(auc), 1 - low(1 - auc)


def equal_error(curve: Roc) -> float:
    """The rate at which false accepts and false rejects are equal, interpolated between two thresholds."""
    return float(np.interp(0.0, curve.false_accept - (1 - curve.true_accept), curve.false_accept))


def equal_error_interval(genuine: Array, forged: Array, seed: int) -> tuple[float, float] | None:
    """Interval of the equal error rate, by resampling; None if there are too few films.

    If no film is misclassified, no resample has an error either; then the bound is that of no error among the films of
    the rarer kind.
    """
    if equal_error(roc(genuine, forged)) == 0.0:
        return interval(0, min(len(genuine), len(forged)))
    return resampled_interval(lambda a, b: equal_error(roc(a, b)), genuine, forged, seed)


def best_threshold(genuine: Array, forged: Array) -> Threshold:
    """The threshold with the most correct films, for finite scores (M,) and (N,).

    Convention: ties are broken by balanced accuracy, and then by the highest threshold, which accepts least.  It lies
        half-way between two scores, or at the least score if all films are accepted, or just above the greatest if none
        is.
    """
    curve = roc(genuine, forged)
    accuracy, balanced = accuracies(curve, len(genuine), len(forged))
    # Round to whole films, so that ties are exact.
    right = np.rint(accuracy * (len(genuine) + len(forged)))
    tied = np.flatnonzero(right == right.max())
    k = int(tied[np.argmax(np.round(balanced[tied], 12))])
    scores = curve.threshold[1:]
    if k == 0:
        limit = float(np.nextafter(scores[0], np.inf))
    elif k == len(scores):
        limit = float(scores[-1])
    else:
        # There is no float between two neighbouring ones.
        limit = max(float(scores[k - 1] / 2 + scores[k] / 2), float(np.nextafter(scores[k], np.inf)))
    return Threshold(
        limit,
        float(right[k]) / (len(genuine) + len(forged)),
        float(balanced[k]),
        float(curve.false_accept[k]),
        float(1 - curve.true_accept[k]),
    )


def accuracies(curve: Roc, genuine: int, forged: int) -> tuple[Array, Array]:
    """Accuracy and balanced accuracy (K,) at every threshold of a curve of so many films of either kind."""
    right = curve.true_accept * genuine + (1 - curve.false_accept) * forged
    return right / (genuine + forged), (curve.true_accept + 1 - curve.false_accept) / 2


def cllr(genuine: Array, forged: Array) -> float:
    """Cost of the likelihood ratios whose decadic logarithms are these scores, neither side empty, in bits.

    Convention: 0 if every ratio is right and infinite; 1 if all ratios are 1, which carries no information; more than 1
        misleads.
    Source: Brümmer and du Preez, Computer Speech and Language 20 (2006) 230.
    """
    true, false = -math.log(10) * genuine, math.log(10) * forged
    return float(np.logaddexp(0, true).mean() + np.logaddexp(0, false).mean()) / (2 * math.log(2))


def least_cllr(genuine: Array, forged: Array) -> float:
    """The least `cllr` that scores in this order can have: what is left where they are calibrated on these very films.

    Convention: films of equal score share one ratio.
    Source: Brümmer and du Preez 2006; isotonic regression by pool adjacent violators, as SciPy has it.
    """
    values, place = np.unique(np.concatenate([genuine, forged]), return_inverse=True)
    true = np.bincount(place[: len(genuine)], minlength=len(values))
    films = np.bincount(place, minlength=len(values))
    share = isotonic_regression(true / films, weights=films).x
    with np.errstate(divide="ignore"):
        ratio = np.log10(share) - np.log10(1 - share) - math.log10(len(genuine) / len(forged))
    return cllr(ratio[place[: len(genuine)]], ratio[place[len(genuine) :]])


def resampled_interval(
    statistic: Callable[[Array, Array], float | None], genuine: Array, forged: Array, seed: int
) -> tuple[float, float] | None:
    """Percentile interval of a statistic; genuine and forged films are resampled separately; None if there are too few.

    Source: Efron's bootstrap, by SciPy.
    """
    if min(len(genuine), len(forged)) < LEAST_RESAMPLED:
        return None

    def number(a: Array, b: Array) -> float:
        found = statistic(a, b)
        return math.nan if found is None else found

    found = bootstrap(
        (genuine, forged),
        number,
        n_resamples=RESAMPLES,
        confidence_level=LEVEL,
        method="percentile",
        vectorized=False,
        rng=np.random.default_rng(seed),
    ).confidence_interval
    low, high = float(found.low), float(found.high)
    return (low, high) if math.isfinite(low) and math.isfinite(high) else None


def interval(hits: int, trials: int) -> tuple[float, float]:
    """Clopper-Pearson interval of a rate; (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    found = binomtest(hits, trials).proportion_ci(LEVEL, method="exact")
    return float(found.low), float(found.high)


def upper_bound(hits: int, trials: int) -> float:
    """The rate that is not exceeded, at `LEVEL`, one-sided: of 0 in 100 it is 3 %."""
    if trials == 0:
        return 1.0
    return float(binomtest(hits, trials, alternative="less").proportion_ci(LEVEL, method="exact").high)
