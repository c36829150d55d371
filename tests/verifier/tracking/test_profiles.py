"""Brightness profiles.  Beside each test: the wrong implementation it catches."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.tracking.brightness_profiles import ProfileReader


def test_profiles_are_in_light_not_in_coded_counts(ada):
    """Catches: coded counts averaged as if they were light; a table turned over."""
    to_image = np.diag([3.0, 3.0, 1.0])
    stripes = (np.indices((900, 640))[1] // 2) % 2
    coded = np.where(stripes, 200, 40).astype(np.uint8)
    profiles = ProfileReader(ada).read(coded, to_image)
    light = 255 * (np.array([40.0, 200.0]) / 255) ** 2.2
    assert profiles.min() == pytest.approx(light[0], abs=0.5) and profiles.max() == pytest.approx(light[1], abs=0.5)
    assert profiles.dtype == np.float32
