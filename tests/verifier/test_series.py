"""Windows over a series, against SciPy's filters.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, gaussian_filter1d, maximum_filter1d, median_filter, uniform_filter1d

from moireid.verifier.series import gaussian_mean, greatest_near, median_near, moving_mean


@pytest.fixture(params=[1, 3, 40, 500])
def series(request: pytest.FixtureRequest, rng: np.random.Generator) -> np.ndarray:
    """Shorter and longer than the windows, (T, 5)."""
    return rng.normal(size=(request.param, 5)).cumsum(axis=0)


def test_medians_are_those_of_centred_windows(series: np.ndarray) -> None:
    """Catches: a window that is off by a frame, ends that are left out, columns that are mixed."""
    assert np.array_equal(median_near(series, 31), median_filter(series, (31, 1), mode="nearest"))
    assert np.array_equal(median_near(series[:, 0], 11), median_filter(series[:, 0], 11, mode="nearest"))


def test_the_greatest_is_that_of_a_centred_window(series: np.ndarray) -> None:
    """Catches: likewise; and booleans that grow over fewer or more frames."""
    assert np.array_equal(greatest_near(series[:, 0], 5), maximum_filter1d(series[:, 0], 5, mode="nearest"))
    seen = series[:, 0] > np.quantile(series[:, 0], 0.8)
    assert np.array_equal(greatest_near(seen, 5), binary_dilation(seen, iterations=2))


@pytest.mark.parametrize("frames", [1, 2, 3, 8, 31])
def test_a_moving_mean_is_centred(series: np.ndarray, frames: int) -> None:
    """Catches: an even window that reaches to the other side, a single frame whose axis is lost."""
    expected = uniform_filter1d(series, frames, axis=0, mode="nearest")
    assert moving_mean(series, frames) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("sd_frames", [0.0, 0.01, 0.7, 3.3, 200.0])
def test_a_gaussian_mean_keeps_its_width(series: np.ndarray, sd_frames: float) -> None:
    """Catches: a window cut elsewhere, weights that do not add up to 1, a division by no width."""
    expected = gaussian_filter1d(series, max(sd_frames, 1e-9), axis=0, mode="nearest")
    assert gaussian_mean(series, sd_frames) == pytest.approx(expected, abs=1e-11)
    assert gaussian_mean(series[:, 0], sd_frames) == pytest.approx(expected[:, 0], abs=1e-11)
