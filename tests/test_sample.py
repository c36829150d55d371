"""A bounded sample of a film.  Beside each test: the wrong implementation it catches."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.sample import EvenSample


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
