"""Film-wide unknowns by least misfit.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.camera.map_search import SPARE_PER_FRAME, Unknown, repeated, step_together

FRAMES, POINTS = 400, 16


def unknown(prior_sd: float = 1e3, *, heavy: bool = False) -> Unknown:
    return Unknown(-50.0, 50.0, 0.0, prior_sd, 0.1, heavy)


def linear(rng, truth: np.ndarray, noise: float = 0.01):
    """Residuals linear in two unknowns that nearly stand in for one another, and their table."""
    table = rng.standard_normal((FRAMES, 2 * POINTS, 1)) * np.array([1.0, 0.98]) * 0.01
    table = table + 0.0003 * rng.standard_normal((FRAMES, 2 * POINTS, 2))
    seen = table @ truth + noise * rng.standard_normal((FRAMES, 2 * POINTS))
    return (lambda at: table @ at - seen), table


def searched(residuals, table: np.ndarray, start: np.ndarray, unknowns: list[Unknown], scale: float):
    """Steps until they are short; table (T, 2 P, N): slopes of the residuals."""
    for _ in range(30):
        before = start
        start, covariance = step_together(residuals, np.moveaxis(table, 2, 0), start, unknowns, scale)
        if np.all(np.abs(start - before) < 1e-4):
            break
    return start, covariance


def test_a_long_narrow_valley_is_gone_along_to_its_end(rng):
    """Catches: a search that stops on its way; an error bar for the valley's width in place of its length."""
    truth = np.array([7.0, -4.0])
    residuals, table = linear(rng, truth)
    scale = 0.01 * np.sqrt(2)
    place, covariance = searched(residuals, table, np.zeros(2), [unknown(), unknown()], scale)
    # At the bottom a usual frame weighs half of what it would without Cauchy's logarithm.
    normal = np.einsum("tmi,tmj->ij", table, table) * SPARE_PER_FRAME / 2 / (2 * POINTS) * 2 / scale**2
    assert covariance == pytest.approx(np.linalg.inv(normal), rel=0.1)
    assert np.all(np.abs(place - truth) < 4 * np.sqrt(np.diag(covariance)))
    assert np.sqrt(covariance[0, 0]) > 10 / np.sqrt(normal[0, 0])


def test_priors_hold_what_nothing_tells(rng):
    """Catches: a prior that is left out, counted twice, or that has no say in the error bar."""
    for heavy, weight in ((False, 1.0), (True, 4 / 3)):
        flat = np.zeros((9, 4, 1))
        place, covariance = searched(
            lambda at: np.full((9, 4), 0.3) + 0 * at[0], flat, np.array([1.0]), [unknown(2.0, heavy=heavy)], 1.0
        )
        assert place == pytest.approx([0.0], abs=0.05)
        assert covariance[0, 0] == pytest.approx(4.0 / weight, rel=0.05)


def test_errors_that_last_are_counted_once(rng):
    """Catches: noise that a coder keeps for some frames counted anew in each; independent noise counted less; a film
    without errors, or of a few frames, divided by nothing.

    Source: means of n independent samples in a row correlate by 1 - k / n at a distance of k, which sums up to n.
    """
    white = rng.standard_normal((600, 8))
    assert repeated(white) == pytest.approx(1.0, abs=0.2)
    kept = np.stack([np.convolve(column, np.ones(6), "valid") for column in white.T], axis=1)
    assert repeated(kept) == pytest.approx(6.0, rel=0.3)
    assert repeated(np.zeros((600, 8))) == 1.0 and repeated(white[:10]) == 1.0
