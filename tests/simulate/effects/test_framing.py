"""Crops, tiles, zooms and stabilisers on a dot whose place is known.  Each test names what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.takes import SIZE, a_take, dot_of, dotted
from moireid.simulate.effects.effect import Take
from moireid.simulate.effects.framing import FRAMED_ROWS, followed
from moireid.simulate.effects.table import KINDS, STRENGTHS, effect_named

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


def scales(take: Take, name: str) -> tuple[np.ndarray, np.ndarray]:
    """How many times wider and higher each picture's content is behind an effect, (T,) each."""
    maps = behind(name, take).pages @ np.linalg.inv(take.pages)
    maps /= maps[:, 2:, 2:]
    return np.hypot(maps[:, 0, 0], maps[:, 1, 0]), np.hypot(maps[:, 0, 1], maps[:, 1, 1])


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


@pytest.mark.parametrize("name", ["zoom", "zoom-step"])
def test_a_zoom_ends_at_its_figure_about_the_middle(name):
    """Catches: a zoom that begins or ends elsewhere; one about a corner; one that takes the whole film to jump."""
    take = a_take()
    for strength, figure in zip(STRENGTHS, KINDS[name].figures, strict=True):
        across, down = scales(take, f"{name}:{strength}")
        assert across == pytest.approx(down) and np.all(np.diff(across) >= -1e-9)
        assert across[0] == pytest.approx(1) and across[-1] == pytest.approx(figure)
        changing = np.count_nonzero(np.diff(across) > 1e-6)
        assert changing == 1 if name == "zoom-step" else 40 <= changing <= 46
        maps = behind(f"{name}:{strength}", take).pages @ np.linalg.inv(take.pages)
        middle = np.array([(SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2, 1])
        assert (maps[-1] @ middle)[:2] / (maps[-1] @ middle)[2] == pytest.approx(middle[:2])


def test_breathing_stays_within_its_share_and_moves():
    """Catches: a focal length that shrinks below the camera's, so that borders show; one that never changes."""
    across, _ = scales(a_take(300), "breathing:strong")
    assert across.min() >= 1 - 1e-9 and 1.01 < across.max() <= 1.03 + 1e-9


@pytest.mark.parametrize(("strength", "share"), [("light", 0.85), ("ordinary", 0.667), ("strong", 0.5)])
def test_autoframing_follows_the_badge_smoothly_with_a_window_of_its_width(strength, share):
    """Catches: a window that stays in the middle; one that has no lag; one of another width."""
    take = a_take()
    after = behind(f"autoframe:{strength}", take)
    assert after.size == (854, FRAMED_ROWS) or after.size == (852, FRAMED_ROWS)
    across, _ = scales(take, f"autoframe:{strength}")
    assert across == pytest.approx(after.size[0] / (share * SIZE[0]), rel=1e-6)
    # The badge moves less in the window than it does in the picture at the window's scale.
    still, seen = take.centres_px[:, 0].std() * across[0], after.centres_px[:, 0].std()
    assert seen < still and (strength == "light" or seen > 0.05 * still)


def test_what_follows_lags_by_two_time_constants():
    """Catches: a filter that knows what comes; a time constant in seconds taken for frames."""
    ramp = np.column_stack([np.arange(200.0), np.zeros(200)])
    assert ramp[-1, 0] - followed(ramp, 10.0)[-1, 0] == pytest.approx(20.0, abs=1.5)


def test_an_auto_frame_zooms_there_and_back():
    """Catches: a zoom that stays; a figure taken for a share."""
    across, _ = scales(a_take(), "autoframe-zoom:strong")
    assert across.max() / across[0] == pytest.approx(1.6, rel=0.01)
    assert across[-1] == pytest.approx(across[0], rel=0.01)


@pytest.mark.parametrize(("strength", "kept"), [("light", 0.9), ("ordinary", 0.78), ("strong", 0.65)])
def test_a_crop_cuts_off_the_right_alone(strength, kept):
    """Catches: a crop about the middle, whose axis stays; one of the left; pixels that are scaled."""
    take = a_take()
    begin = effect_named(f"crop:{strength}").begin
    assert begin is not None
    step, after = begin(take)
    picture = np.random.default_rng(1).integers(0, 256, SIZE[::-1]).astype(np.uint8)
    assert after.size[0] == pytest.approx(kept * SIZE[0], abs=1) and after.size[1] == SIZE[1]
    assert np.array_equal(step(0, picture), picture[:, : after.size[0]])


def test_a_tile_is_the_picture_itself_off_the_recording_s_middle():
    """Catches: a tile in the middle, whose axis hardly moves; a tile that is scaled; a recording of another size."""
    take = a_take()
    begin = effect_named("tile").begin
    assert begin is not None
    step, after = begin(take)
    picture = np.random.default_rng(1).integers(0, 256, SIZE[::-1]).astype(np.uint8)
    whole = step(0, picture)
    assert after.size == (960, 540)
    x, y = np.rint(after.centres_px[0] - take.centres_px[0]).astype(int)
    assert np.array_equal(whole[y : y + SIZE[1], x : x + SIZE[0]], picture)
    off = np.array([x, y]) + np.array(SIZE) / 2 - np.array(after.size) / 2
    assert np.all(off < -60)


def test_stretching_widens_and_anamorphic_pixels_are_told():
    """Catches: heights that are stretched; a flag turned round; a stretch that is stated, which undoes it."""
    across, down = scales(a_take(), "stretch:ordinary")
    assert across == pytest.approx(1.03, abs=0.002) and down == pytest.approx(1)
    assert effect_named("stretch").recipe is None
    across, down = scales(a_take(), "anamorphic:strong")
    assert across == pytest.approx(0.5) and down == pytest.approx(1)


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
