"""Frames smeared by motion, followed on pictures whose homography and smear are known."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from kit.drawn_pages import MARKERS, apart_px, draw, filmed, nudged, seen_from
from moireid.verifier.tracking.registration import FOLLOWED_CORRELATION, KeptTemplate, PageRegistrar, Registration
from moireid.verifier.tracking.smeared_frames import ShakenFollower
from moireid.verifier.tracking.track import FrameSighting, TrackEnds

FPS, EXPOSURE_S, NO_ROWS = 30.0, 1 / 60, np.empty((0, 0), np.float32)
#: A marker's module in these pictures, px.
MODULE_PX = 26.0 / 6 * 1.45


def smeared(homography: np.ndarray, way: np.ndarray) -> np.ndarray:
    """The page in light, exposed over a way in the picture, px, coded as a camera does."""
    steps = max(1, round(np.hypot(*way)))
    sharp = (draw(homography) / 255.0) ** 2.2
    total = np.zeros_like(sharp)
    for share in (np.arange(steps) + 0.5) / steps - 0.5:
        shift = np.array([[1, 0, share * way[0]], [0, 1, share * way[1]]], float)
        total += cv2.warpAffine(sharp, shift, sharp.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
    return 255.0 * (total / steps) ** (1 / 2.2)


def follower_on(course: TrackEnds) -> ShakenFollower:
    registrar = PageRegistrar(MARKERS)
    return ShakenFollower(registrar, KeptTemplate(registrar.printer), course)


def follower_at(*places: np.ndarray) -> ShakenFollower:
    """A follower of a badge that was at places of the frames before."""
    return follower_on(course_of(*places))


def course_of(*places: np.ndarray) -> TrackEnds:
    course = TrackEnds()
    for number, place in enumerate(places):
        course.follow(FrameSighting(number, number / FPS, Registration(place, 1.0), NO_ROWS))
    return course


@pytest.mark.parametrize("way_deg", [0.0, 90.0, 35.0])
@pytest.mark.parametrize("modules", [1.2, 2.0])
def test_a_smeared_page_is_found_in_the_middle_of_its_smear(rng, modules, way_deg):
    """Catches: a page pulled to one end of its smear; a smear across its way; x for y; a sharp template, which is lost
    or errs by a module.
    """
    way = modules * MODULE_PX * np.array([np.cos(np.radians(way_deg)), np.sin(np.radians(way_deg))])
    moved = way / EXPOSURE_S / FPS
    truth = seen_from(at=(120.0, 60.0))
    # It accelerated, so the last motion predicts neither its place nor its smear exactly.
    course = [nudged(truth, *(-1.7 * moved)), nudged(truth, *(-0.9 * moved))]
    found = follower_at(*course).find(filmed(smeared(truth, way), rng, noise=2.0), 2 / FPS)
    assert found is not None and found.correlation > FOLLOWED_CORRELATION
    assert apart_px(found.homography, truth) < 0.15


def test_the_exposure_is_learnt(rng):
    """Catches: an exposure that is forgotten, or counted in frames; the first try kept in place of the best fit."""
    way = np.array([1.5 * MODULE_PX, 0.0])
    moved = way / EXPOSURE_S / FPS
    places = [nudged(seen_from(at=(90.0, 60.0)), *(k * moved)) for k in range(4)]
    course = course_of(*places[:2])
    follower = follower_on(course)
    for number in (2, 3):
        found = follower.find(filmed(smeared(places[number], way), rng, noise=1.0), number / FPS)
        assert found is not None
        course.follow(FrameSighting(number, number / FPS, found, NO_ROWS))
    assert follower.exposure_s == pytest.approx(EXPOSURE_S, rel=0.15)


def test_nothing_is_followed_without_a_course_or_after_a_while(rng):
    """Catches: a page followed from one frame alone; a place of long ago taken for where the page must be; motion that
    goes on for ever; a division by no time at all.
    """
    truth = seen_from()
    luma = filmed(draw(truth), rng, noise=1.0)
    assert follower_at(truth).find(luma, 1 / FPS) is None
    assert follower_at(truth, truth).find(luma, 2 / FPS) is not None
    assert follower_at(truth, truth).find(luma, 1 / FPS + 1.0) is None
    assert follower_at(truth, truth).find(luma, 1 / FPS) is None
    # Lost for three frames at a gallop that then ended: it is still within reach.
    assert follower_at(nudged(truth, -8.0, 0.0), truth).find(luma, 4 / FPS) is not None


def test_something_else_is_not_followed(rng):
    """Catches: a smear so long that any dark spot passes for a marker."""
    truth = seen_from()
    spots = draw(truth, MARKERS)
    for cx, cy in MARKERS.centers_mm:
        corner = np.array([[cx - 13, cy - 13], [cx + 13, cy - 13], [cx + 13, cy + 13], [cx - 13, cy + 13]])
        cv2.fillConvexPoly(
            spots, np.round(cv2.perspectiveTransform(corner.reshape(1, 4, 2), truth)).astype(int)[0], 100.0
        )
    noise = rng.uniform(0, 255, spots.shape)
    for other in (spots, noise, np.full(spots.shape, 200.0)):
        for moved in (0.0, 12.0):
            found = follower_at(nudged(truth, -2 * moved, 0.0), nudged(truth, -moved, 0.0)).find(
                filmed(other, rng, noise=1.0), 2 / FPS
            )
            assert found is None or found.correlation < FOLLOWED_CORRELATION
