"""Findings on photographs.  At each test: the wrong implementation it catches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kit.photographed import LAW, signal
from moireid.asbuilt import AsBuilt, as_built_from_json, merge
from moireid.verifier.decision.photographs import photographs, softest


def test_what_cannot_be_told_has_no_finding() -> None:
    """Catches: a film without harmonics counted against photographs."""
    for film in (replace(signal(), beyond=None), replace(signal(), phase_sd_rad=np.full(len(LAW), np.inf))):
        assert photographs(None, [film], softest([film])) == []


def test_figures_of_several_films_keep_the_least_third_harmonic() -> None:
    """Catches: a figure of a soft film, or of none, that is lost on its way to the registry."""
    built = AsBuilt("0f", -0.05, 1e-5, 0.0, 0.01, 0.0, 1e-4, 1.0, 0.007, third_harmonic=0.024)
    merged = merge([built, replace(built, third_harmonic=0.02), replace(built, third_harmonic=None)])
    assert merged.third_harmonic == 0.02 and as_built_from_json(merged.to_json()).third_harmonic == 0.02
