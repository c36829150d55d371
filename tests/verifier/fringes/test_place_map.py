"""Maps of what stays the same in all frames.  Each test's docstring names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.errors import SpecError
from moireid.verifier.fringes.place_map import knots_mm, seen_map, start_maps, still_shift
from moireid.verifier.fringes.strip_law import strip_law
from moireid.verifier.fringes.strip_phase import measure_strip
from moireid.verifier.fringes.strip_shape import strip_shape
from moireid.verifier.tracking.brightness_profiles import ProfileReader

FRAMES = 120
#: Camera centres that sway over some turns of the fringes, page mm.
CAMERA = np.column_stack([150.0 * np.sin(np.arange(FRAMES) / 11.0), np.full(FRAMES, 20.0), np.full(FRAMES, -1000.0)])


def bent_map(knots: np.ndarray, size_rad: float) -> np.ndarray:
    """A map without mean and slope, rad."""
    places = np.linspace(-1, 1, len(knots))
    wave = np.cos(5.0 * places)
    return size_rad * (wave - np.polyval(np.polyfit(places, wave, 1), places)) / wave.std()


def rows_of(badge, true_map: np.ndarray, used: np.ndarray, *, seed: int | None = None, dirt: float = 0.0):
    """What the plain rows of the first grating show: fringes of the true map, measured with the used one."""
    rng = np.random.default_rng(seed)
    grating = badge.gratings[0]
    frequency = 1 / grating.pitch_mm - 1 / badge.lens.pitch_mm
    found = []
    for strip in (strip for strip in ProfileReader(badge).strips if strip.grating == 0 and strip.uniform):
        shown = strip_law(badge, strip, CAMERA, true_map).whole_phase_rad(frequency)
        profiles = 120 + 50 * (np.cos(shown) - 0.15 * np.cos(3 * shown)) + rng.normal(0, 3.0, shown.shape)
        profiles += 50 * dirt * np.sin(strip.along_mm / 3.0)
        law = strip_law(badge, strip, CAMERA, used)
        phase = measure_strip(profiles, law, strip.length_mm, (frequency - 0.004, frequency + 0.004))
        found.append(still_shift(strip, strip_shape(profiles, law, phase), knots_mm(grating)))
    return found


def test_a_map_is_found_within_three_rounds(ada):
    """Catches: a map of the wrong sign or at the wrong places, and rounds that diverge for 0.6 rad."""
    knots = knots_mm(ada.gratings[0])
    true, used = bent_map(knots, 0.6), np.zeros(len(knots))
    for _ in range(3):
        used = seen_map(used, rows_of(ada, true, used, seed=1)).seen_rad
    assert used == pytest.approx(true, abs=0.05)


def test_where_there_is_no_map_none_is_used(ada):
    """Catches: noise or dirt, which stay where they are while fringes pass, taken for lenses off their places."""
    nothing = np.zeros(len(knots_mm(ada.gratings[0])))
    found = seen_map(nothing, rows_of(ada, nothing, nothing, seed=2, dirt=0.2))
    assert found.change_rad is None and np.abs(found.seen_rad).max() < 0.05 and found.sd_rad < 0.05


def test_rows_that_disagree_show_no_map(ada):
    """Catches: one row's dirt or cover taken for the sheet's, which all rows share."""
    knots = knots_mm(ada.gratings[0])
    nothing = np.zeros(len(knots))
    one = rows_of(ada, bent_map(knots, 0.15), nothing, seed=4)[:1]
    other = rows_of(ada, -bent_map(knots, 0.15), nothing, seed=5)[:1]
    assert seen_map(nothing, one * 2).change_rad is not None
    assert seen_map(nothing, one + other).change_rad is None
    assert seen_map(nothing, [*one, None]).sd_rad == np.inf


def test_an_enrolled_map_must_be_of_this_badge(ada):
    """Catches: a map of another layout that is stretched, or read beyond its end."""
    size = len(knots_mm(ada.gratings[0]))
    assert [len(one) for one in start_maps(ada, ())] == [size] * len(ada.gratings)
    wave = bent_map(knots_mm(ada.gratings[0]), 0.2)
    sloping = 0.5 + 0.1 * np.arange(size) + wave
    assert start_maps(ada, [sloping] * len(ada.gratings))[0] == pytest.approx(wave, abs=1e-9)
    with pytest.raises(SpecError, match="enroll the badge"):
        start_maps(ada, [[0.1] * (size + 1)] * len(ada.gratings))
