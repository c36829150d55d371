"""Crops, tiles, zooms and stabilisers on a dot whose place is known.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.takes import SIZE, a_take, dot_of, dotted
from moireid.simulate.effects.effect import Take
from moireid.simulate.effects.table import STRENGTHS, effect_named

MOVING = (
    "zoom",
    "zoom-step",
    "autoframe",
    "autoframe-zoom",
    "breathing",
    "crop",
    "tile",
    "stretch",
    "anamorphic",
    "eis",
)


def behind(name: str, take: Take) -> Take:
    """What is known behind an effect."""
    begin = effect_named(name).begin
    assert begin is not None
    return begin(take)[1]


@pytest.mark.parametrize("strength", STRENGTHS)
@pytest.mark.parametrize("name", MOVING)
def test_the_picture_shows_the_page_where_the_effect_says(name, strength):
    """Catches: maps turned round, half a pixel lost at a change of size, another frame's map, another size."""
    take = a_take()
    begin = effect_named(f"{name}:{strength}").begin
    assert begin is not None
    step, after = begin(take)
    assert after.size[0] % 2 == after.size[1] % 2 == 0
    for number in range(0, len(take), 13):
        shown = step(number, dotted(take, number))
        assert shown.shape == after.size[::-1] and shown.dtype == np.uint8
        place = after.centres_px[number]
        # A dot that is half out of the picture has its middle elsewhere.
        if np.all(place > 25) and np.all(place < np.array(after.size) - 25):
            assert dot_of(shown, place) == pytest.approx(place, abs=0.15)


@pytest.mark.parametrize(("strength", "px"), [("light", 15), ("ordinary", 25), ("strong", 40)])
def test_a_stabiliser_calms_the_picture_within_its_margin(strength, px):
    """Catches: shake that is doubled; shifts beyond the margin, which show the rim; one that shifts by far less."""
    take = a_take()
    margin = px * SIZE[0] / 1280
    after = behind(f"eis:{strength}", take)
    maps = after.pages @ np.linalg.inv(take.pages)
    maps /= maps[:, 2:, 2:]
    scale = SIZE[0] / (SIZE[0] - 2 * margin)
    assert np.hypot(maps[:, 0, 0], maps[:, 1, 0]) == pytest.approx(scale)
    middle = np.array([(SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2, 1])
    shift = ((maps @ middle)[:, :2] - middle[:2]) / scale
    assert np.abs(shift).max() <= margin + 1e-6 and np.abs(shift[:, 0]).max() > 0.6 * margin
    turn = np.degrees(np.arctan2(maps[:, 1, 0], maps[:, 0, 0]))
    assert 0.5 * px / 25 < np.abs(turn).max() <= px / 25 + 1e-9
    # The far end of the mean view shakes less than before, apart from the magnification.
    far = take.poses.rotation @ take.poses.rotation[:, 2].mean(axis=0)
    path = 480 * far[:, :2] / far[:, 2:]
    calmed = path + shift
    assert np.abs(np.diff(calmed, axis=0)).mean() < 0.9 * np.abs(np.diff(path, axis=0)).mean()
