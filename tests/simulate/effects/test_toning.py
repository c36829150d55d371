"""Tone, halos and exposure on pictures made up.  Each test names what it would catch."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from kit.takes import SIZE, a_take, step_of
from moireid.simulate.effects.table import effect_named
from moireid.simulate.light import light_named
from moireid.simulate.scene import Build, Camera, Scene


def test_exposure_follows_what_it_meters_in_steps():
    """Catches: exposure that runs away or goes with the light; one without steps; a share that is not used."""
    shown = {}
    for strength in ("light", "strong"):
        step = step_of(f"exposure:{strength}")
        shown[strength] = [step(k, np.full(SIZE[::-1], 120 if k < 10 else 60, np.uint8)).mean() for k in range(60)]
    assert shown["strong"][9] == pytest.approx(120) and shown["strong"][10] == pytest.approx(60)
    assert shown["strong"][-1] == pytest.approx(120, rel=0.05)
    assert shown["light"][-1] == pytest.approx(60 * np.sqrt(2**0.5), rel=0.05)
    assert len(set(np.round(shown["strong"][10:]))) < 20


def halves(left: float, right: float) -> np.ndarray:
    """A picture of two even halves."""
    return np.where(np.arange(SIZE[0]) < SIZE[0] / 2, left, right)[None].repeat(SIZE[1], axis=0).astype(np.uint8)


@pytest.mark.parametrize(("strength", "kept"), [("light", 0.8), ("ordinary", 0.6), ("strong", 0.4)])
def test_tone_mapping_lowers_the_base_and_keeps_detail(strength, kept):
    """Catches: detail that is lost with the base; a share taken for what is kept."""
    stripes = 6 * (np.arange(SIZE[0]) % 4 < 2)
    shown = step_of(f"tone-map:{strength}")(0, halves(60, 180) + stripes.astype(np.uint8)).astype(float)
    left, right = shown[:, 100:200], shown[:, 440:540]
    assert right.mean() - left.mean() == pytest.approx(120 * kept, rel=0.05)
    assert np.ptp(left.mean(axis=0)) == pytest.approx(6, abs=1.5)


@pytest.mark.parametrize(("strength", "most_mm"), [("light", 2.0), ("ordinary", 5.0), ("strong", 10.0)])
def test_a_backdrop_bites_the_outline_no_deeper_than_told(strength, most_mm):
    """Catches: bites in the middle; a mask next to the badge; bites that never change."""
    take = a_take()
    begin = effect_named(f"backdrop:{strength}").begin
    assert begin is not None
    step = begin(take)[0]
    scale = 480 / 800
    kept = []
    for number in (0, 30, 60):
        shown = step(number, np.full(SIZE[::-1], 30, np.uint8)).astype(float)
        x0, y0, x1, y1 = take.outline_mm
        corners = np.array([[[x0, y0]], [[x1, y0]], [[x1, y1]], [[x0, y1]]])
        board = np.zeros(SIZE[::-1], np.uint8)
        cv2.fillPoly(board, [np.rint(cv2.perspectiveTransform(corners, take.pages[number])).astype(np.int32)], 1)
        depth = cv2.distanceTransform(board, cv2.DIST_L2, 5)
        assert np.all(shown[depth > scale * most_mm + 6] < 31) and np.all(
            shown[cv2.dilate(board, np.ones((15, 15))) == 0] == 150
        )
        kept.append((shown < 90)[board > 0].mean())
    assert max(kept) < 0.99 and np.ptp(kept) > 1e-4


def test_glare_is_a_light_in_the_scene(prototype):
    """Catches: the strengths' lights exchanged."""
    for strength, name in (("light", "lamp"), ("ordinary", "window"), ("strong", "sun")):
        change = effect_named(f"glare:{strength}").scene
        assert change is not None and change(Scene(prototype, Build(), Camera())).light == light_named(name)
