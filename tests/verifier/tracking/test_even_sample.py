"""A bounded sample of a film.  Beside each test: the wrong implementation it catches."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.tracking.sampling import EvenSample


def sampled(count: int, limit: int) -> EvenSample:
    sample = EvenSample(limit)
    for k in range(count):
        sample.offer(np.full(3, k, np.float32))
    return sample


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 16, 17, 33, 1000, 4097])
def test_holds_what_places_say_and_never_more_than_its_limit(count):
    """Catches: places that lag behind the dropping; a limit passed by one; an end of the film never sampled."""
    sample = sampled(count, 8)
    assert len(sample.items) <= 8 and len(sample.items) >= min(count, 5)
    assert [int(item[0]) for item in sample.items] == list(sample.places)
    if count:
        assert sample.places[0] == 0 and count - 1 - sample.places[-1] < sample.stride


def test_is_evenly_spread():
    """Catches: a reservoir that keeps the beginning dense, or draws by chance."""
    assert set(np.diff(sampled(5000, 64).places)) == {128}


def test_what_is_dropped_is_gone_and_the_rest_counts_anew():
    """Catches: places that still count what is gone, items shifted against them."""
    sample = sampled(1000, 64)
    sample.drop(700)
    assert [int(item[0]) - 700 for item in sample.items] == list(sample.places) and sample.places[0] >= 0
    for k in range(1000, 1400):
        sample.offer(np.full(3, k, np.float32))
    assert [int(item[0]) - 700 for item in sample.items] == list(sample.places)
    assert len(set(np.diff(sample.places))) == 1 and 32 < len(sample.items) <= 64
