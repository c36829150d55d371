"""Does the waveform change from place to place?  Beside each test: what it would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kit.photographed import (
    FRAMES,
    LAW,
    NEAR,
    TIMES,
    TYPICAL,
    faded,
    found_in,
    noise_of,
    signal,
)
from moireid.verifier.explanations.photographs.ripple import WaveformModel
from moireid.verifier.explanations.photographs.waveform import waveform_of
from moireid.verifier.limits import MAX_RIPPLE_CONTRASTS

SWEEP = np.linspace(-3, 3, FRAMES)


def ripple_of(overtone: np.ndarray, **how) -> tuple[float, float]:
    """Ripple and limit."""
    found = waveform_of(signal(overtone, **how))
    assert found is not None
    return found.ripple, found.limit


@pytest.mark.parametrize("count", [8, 10, 12, 14])
def test_the_ripple_of_cross_faded_photographs_is_found_and_of_its_size(count):
    """Catches: a ripple that the slow part takes up, one part of the complex number alone."""
    # Evenly over the course, so that the shares of a cross-fade are all as frequent: the closed form of its dip.
    law = np.linspace(-4, 4, FRAMES)[np.random.default_rng(2).permutation(FRAMES)]
    share, step = np.linspace(0, 1, 1001), 8 / (count - 1)
    first, third = ((1 - share) + share * np.exp(1j * h * step) for h in (1, 3))
    own = third * np.exp(-3j * np.angle(first)) / np.abs(first)
    expected = abs(TYPICAL) * math.sqrt(np.mean(np.abs(own - own.mean()) ** 2))
    found, limit = ripple_of(faded(count, law), law=law)
    assert found == pytest.approx(expected, rel=0.1)
    assert ripple_of(faded(count, law) + noise_of(0.01, 3), law=law)[0] == pytest.approx(expected, rel=0.3)
    assert found > limit


@pytest.mark.slow
@pytest.mark.parametrize("lasting", [0.0, 0.6, 0.8])
@pytest.mark.parametrize("size", [0.003, 0.03])
def test_noise_is_no_ripple(size, lasting):
    """Catches: the fine regression's share of any noise taken for ripple, and of noise that lasts even more."""
    found = [ripple_of(TYPICAL + noise_of(size, seed, lasting)) for seed in range(50)]
    assert sum(ripple > limit for ripple, limit in found) <= 1
    # A limit that grows with the noise alone would find nothing: in little noise it is that of a still waveform.
    assert size > 0.01 or np.median([limit for _, limit in found]) < 1.5 * MAX_RIPPLE_CONTRASTS


@pytest.mark.parametrize("share", [0.5, 0.8])
def test_rests_thin_no_ripple_out(share):
    """Catches: a mean over frames, so that photographs held for long hide what lies between them."""
    moving = LAW[:: round(1 / (1 - share))]
    law = np.r_[moving, np.full(FRAMES - len(moving), LAW.max())]
    alone = waveform_of(signal(faded(8)).part(slice(0, FRAMES, round(1 / (1 - share)))))
    held = waveform_of(signal(faded(8, law), law=law))
    assert held.ripple > held.limit and held.ripple == pytest.approx(alone.ripple, rel=0.25)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.5, 0.8])
@pytest.mark.parametrize("lasting", [0.0, 0.8])
def test_noise_is_no_ripple_where_a_badge_rests(share, lasting):
    """Catches: weights without the noise that they change: few views of many frames each, many of one."""
    moving = LAW[:: round(1 / (1 - share))]
    law = np.r_[moving, np.full(FRAMES - len(moving), LAW.max())]
    found = [ripple_of(TYPICAL + noise_of(0.01, seed, lasting), law=law) for seed in range(50)]
    assert sum(ripple > limit for ripple, limit in found) <= 2


#: One sweep that halts five times, and one on which the camera comes nearer again and again: there time and distance
#: change within a little way of parallax.
HALTING = SWEEP - 0.19 * np.sin(np.pi * TIMES)
WAVING = 1e-3 * (1 + 0.03 * np.sin(2 * np.pi * 0.9 * TIMES))


@pytest.mark.parametrize(
    ("law", "near", "change"),
    [
        (LAW, NEAR, lambda place, near, time: place**4 / 4 - place**3 / 2 + place),
        (SWEEP, WAVING, lambda place, near, time: near),
        (SWEEP, WAVING, lambda place, near, time: near**2),
        (SWEEP, WAVING, lambda place, near, time: near * place),
        (HALTING, NEAR, lambda place, near, time: time - time**3 / 2),
    ],
    ids=["parallax", "distance", "its square", "distance by parallax", "time"],
)
def test_a_waveform_that_changes_slowly_is_no_ripple(law, near, change):
    """Catches: a lens out of focus at an angle, a camera that comes nearer, a light that is dimmed, called forged."""
    slow = change(*((series - series.mean()) / series.std() for series in (law, near, TIMES)))
    found, limit = ripple_of(TYPICAL * (1 + 0.3 * slow) + noise_of(0.001, 1), law=law, near=near)
    assert found < 0.5 * MAX_RIPPLE_CONTRASTS < limit


def test_dots_that_stand_still_are_no_ripple():
    """Catches: a badge of fine lines left open, whose printed dots beat at a third of its fringe's length."""
    still = signal().phase_rad
    found, limit = ripple_of(TYPICAL + 0.02 * np.exp(1j * (0.4 - 3 * still)) + noise_of(0.001, 1))
    assert found < 0.5 * MAX_RIPPLE_CONTRASTS < limit


#: A hand's course in the picture, px: quick by turns, up to 30 px a frame.
QUICK_PX = np.column_stack([200 * np.sin(2 * np.pi * 0.7 * TIMES), 30 * np.cos(2 * np.pi * 0.5 * TIMES)])


def test_a_long_exposure_is_no_ripple():
    """Catches: a quick hand in a dim room left open, as its finest fringes are smeared."""
    # On one sweep each place is passed once, at its own speed.
    speed = np.sqrt(np.sum(np.gradient(QUICK_PX, axis=0) ** 2, axis=1))
    # The third harmonic turns by up to 4.5 rad while the shutter is open, so that a good half of it is lost.
    lost = np.sinc(0.15 * speed / (2 * np.pi))
    assert lost.min() < 0.5
    found, limit = ripple_of(TYPICAL * lost + noise_of(0.001, 1), law=SWEEP, place_px=QUICK_PX)
    assert found < limit


@pytest.mark.parametrize("count", [4, 5, 6, 8, 10])
def test_a_quick_hand_hides_no_photographs(count):
    """Catches: causes that take up whatever a film shows."""
    found, limit = ripple_of(faded(count) + noise_of(0.001, 1), place_px=QUICK_PX)
    assert found > limit


def test_ripple_is_by_place_and_not_by_time():
    """Catches: a shadow's flicker taken for photographs, though it has no place."""
    flicker = 0.02 * np.sign(np.sin(2 * np.pi * 3.7 * TIMES))
    found, limit = ripple_of(TYPICAL + flicker)
    assert found < limit


def test_a_short_film_is_told_by_what_it_has():
    """Catches: a grid too fine for the frames, so that a few seconds are never held against a badge's waveform."""
    short = signal(faded(8) + noise_of(0.002, 1)).part(slice(0, 120))
    found = waveform_of(short)
    assert found is not None and found.ripple > found.limit


def test_a_film_of_few_frames_tells_no_waveform():
    """Catches: a regression with more unknowns than frames, which leaves no noise to compare with."""
    short = signal().part(slice(0, 12))
    assert waveform_of(short) is None
    blank = replace(signal(), phase_sd_rad=np.full(FRAMES, np.inf))
    assert waveform_of(blank) is None
    assert waveform_of(replace(signal(), beyond=None)) is None
    found = found_in(short)
    assert "waveform" not in found and "photographs" not in found and "spacing" in found


def test_a_course_leaves_out_frames_that_cannot_be_read():
    """Catches: the noise of unread frames in the waveform."""
    overtone = np.full(FRAMES, TYPICAL)
    overtone[100:130] = noise_of(5.0, 1)[:30]
    sd = np.full(FRAMES, 0.01)
    sd[100:130] = np.inf
    unread = replace(signal(overtone), phase_sd_rad=sd)
    found = waveform_of(unread)
    assert found is not None and found.ripple < MAX_RIPPLE_CONTRASTS
    assert WaveformModel(unread).used.sum() == FRAMES - 30
