"""Intervals of rates."""

from __future__ import annotations

from scipy.stats import beta


def interval(hits: int, trials: int) -> tuple[float, float]:
    """Clopper-Pearson interval of a rate, 95 %."""
    low = float(beta.ppf(0.025, hits, trials - hits + 1)) if hits else 0.0
    high = float(beta.ppf(0.975, hits + 1, trials - hits)) if hits < trials else 1.0
    return low, high
