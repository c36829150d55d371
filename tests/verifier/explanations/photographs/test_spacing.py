"""Does the fringes' spacing follow the distance?  Beside each test: what it would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kit.photographed import (
    CHANGE_RAD,
    FRAMES,
    NEAR,
    TIMES,
    depth_of,
    found_in,
    signal,
)
from moireid.verifier.explanations.photographs.fringe_spacing import Spacing, spacing_of
from moireid.verifier.fringes.grating_signal import DepthLaw
from moireid.verifier.limits import SPACING_FLOOR_RAD


@pytest.mark.claim("Photographs from one distance are found where the distance changes")
@pytest.mark.parametrize("sd", [0.0, 0.02, 0.1, 0.3, 0.36, 0.6, 3.0])
def test_where_the_spacing_is_tested_a_table_of_photographs_is_wrong_and_nowhere_else(sd):
    """Catches: a film called tested whose error bar lets a table pass; a table called wrong by a vague figure."""
    table, badge = Spacing(0.0, sd), Spacing(1.0, sd)
    assert table.tested == table.wrong == (sd <= 0.3)
    assert not badge.wrong and badge.tested == table.tested


@pytest.mark.parametrize(("gain", "frames", "wrong"), [(1.9, 66, False), (1.9, FRAMES, True), (0.0, 66, True)])
def test_few_times_leave_doubt_where_no_photograph_would_be(gain, frames, wrong):
    """Catches: an honest film of two seconds left open for a spacing that changes too much by chance, as happened with
    1.86 ± 0.25; and a doubt that lets a photograph pass.
    """
    slow = np.tile(np.repeat([1.0, -1.0], 15), FRAMES)[:FRAMES]
    clear = depth_of(gain, change_rad=0.02)
    depth = clear._replace(score=clear.score + 0.5 * clear.information * slow)
    depth = DepthLaw(*(series[:frames] for series in depth))
    one = signal(depth=depth)
    found = spacing_of([replace(one, times_s=one.times_s[:frames])])
    assert found is not None and found.wrong == wrong and found.tested


def test_the_gain_is_of_all_gratings_together():
    """Catches: a mean of gains, in which a grating without evidence counts as much as one with."""
    clear, vague = signal(depth=depth_of(1.0, information=20.0)), signal(depth=depth_of(0.0, seed=1))
    both = spacing_of([clear, vague])
    assert both is not None and both.gain == pytest.approx(20 / 21, abs=0.01)
    alone = spacing_of([clear])
    assert alone is not None and alone.gain == pytest.approx(1.0)
    assert spacing_of([replace(clear, beyond=None)]) is None
    nothing = DepthLaw(*np.zeros((3, FRAMES)))
    assert spacing_of([signal(depth=nothing)]) is None


def test_the_error_bar_is_honest_where_errors_last():
    """Catches: frames counted as independent where the errors of a hand's poses last for a second."""
    off, bars = [], []
    for seed in range(60):
        slow = np.repeat(np.random.default_rng(seed).standard_normal(FRAMES // 15), 15)
        clear = depth_of(1.0, seed=seed)
        known = clear._replace(score=clear.score + 0.5 * clear.information * slow)
        found = spacing_of([signal(depth=known)])
        assert found is not None
        off.append(found.gain - 1)
        bars.append(math.sqrt(max(found.sd**2 - (SPACING_FLOOR_RAD / CHANGE_RAD) ** 2, 0.0)))
    # 20 pieces of half a second: their mean is known to 0.5 / sqrt(20), the bar by 60 films to 10 %.
    assert np.std(off) == pytest.approx(0.5 / math.sqrt(20), rel=0.35)
    assert 0.7 < np.std(off) / np.sqrt(np.mean(np.square(bars))) < 1.4


def test_a_long_pause_takes_no_memory_and_tells_nothing():
    """Catches: sums over each half second of a thousand years, which took all memory or a minute."""
    told = signal(depth=depth_of(1.0, noise=0.3))
    late = np.where(np.arange(FRAMES) < FRAMES // 2, 0.0, 1.0)
    near, far = (spacing_of([replace(told, times_s=TIMES + pause_s * late)]) for pause_s in (100.0, 3e10))
    assert near is not None and far is not None
    assert (far.gain, far.sd, far.pieces) == pytest.approx((near.gain, near.sd, near.pieces), rel=1e-6)


def test_a_zoom_that_the_picture_shows_makes_the_spacing_vague():
    """Catches: a true badge under a zoom taken for photographs from one distance; a zoom that excuses any spacing."""
    of_photographs = signal(depth=depth_of(0.0, change_rad=0.02))
    assert found_in(of_photographs)["spacing"].level == "undecided"
    zoomed = replace(of_photographs, zoom=1.3)
    # Distance changes by 2 %, and a zoom by 1.3 leaves it uncertain by 1.5 %.
    assert found_in(zoomed)["spacing"].level == "note"
    far = 1e-3 * (1 + 10 * (1e3 * NEAR - 1))
    walked = replace(zoomed, covariates=np.column_stack([np.zeros(len(far)), far]))
    assert found_in(walked)["spacing"].level == "undecided"
    assert math.isinf(spacing_of([replace(zoomed, covariates=None)]).sd)
