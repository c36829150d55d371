"""What a refused film shows of the badge's build.  Each test's docstring names what it would catch."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from moireid.verifier.session.refusal import build_findings


def measured(*, twist=0.0, off_rad=0.0, map_sd=0.01, contrast=0.8):
    """A measurement of an ordinary badge, but for what is given."""
    wave = off_rad * math.sqrt(2) * np.cos(2 * np.pi * np.arange(8) / 8)
    return SimpleNamespace(
        camera=SimpleNamespace(twist_per_m=twist),
        maps=[SimpleNamespace(seen_rad=0 * wave, sd_rad=0.01), SimpleNamespace(seen_rad=wave, sd_rad=map_sd)],
        strips=[None, SimpleNamespace(contrast=np.full(9, contrast), level=np.ones(9))],
    )


def test_an_ordinary_badge_has_no_findings(ada):
    """Catches: advice about a badge that has nothing wrong; figures that were not measured taken for bad ones."""
    assert build_findings(measured(twist=0.1, off_rad=0.2), ada, 1.02) == []
    bare = SimpleNamespace(**vars(measured()) | {"strips": [None]})
    assert build_findings(bare, ada, None) == []
    # Noise is no map.
    assert build_findings(measured(off_rad=0.62, map_sd=0.4), ada, 1.0) == []


@pytest.mark.parametrize(
    ("changed", "gain", "words"),
    [
        ({"twist": -1.25}, 1.0, "bent to a radius of 0.4 m"),
        ({"off_rad": 0.62}, 1.0, "0.05 mm off their places"),
        ({"contrast": 0.08}, 1.0, "6% of the contrast"),
        ({}, 0.7, "as under a sheet of 0.70 mm."),
        ({}, -0.63, "run the other way"),
    ],
)
def test_each_cause_is_named_alone(ada, changed, gain, words):
    """Catches: a cause that is never named, one that is named for another, or with another figure."""
    (found,) = build_findings(measured(**changed), ada, gain)
    assert words in found
