"""A page or a sheet that is off its size, on films made of numbers alone.  Next to each test: what it would catch."""

from __future__ import annotations

import pytest

from kit.numeric_films import FOCAL, Building, filmed
from moireid.badge import Badge
from moireid.designer import Order, design_badge, payload_from_hex
from moireid.question import KnownCamera
from moireid.verifier.decision.judge import judge
from moireid.verifier.fringes.signals import measure
from moireid.verifier.identity.decode import Identity, judge_identity


@pytest.fixture(scope="module")
def board() -> Badge:
    return design_badge(Order("Ada", lens="62lpi-27mil"), payload_from_hex("0123456789abcdef"))


def judged(badge: Badge, built: Building) -> tuple[Identity, str]:
    """The identity, and the verdict on the motion."""
    track = filmed(badge, built)
    measurement = measure(track, camera=KnownCamera(FOCAL))
    identity = judge_identity(track, measurement, claimed_id=badge.id)
    return identity, judge(measurement.gratings, page_off=identity.page_off).verdict


def off(identity: Identity) -> float | None:
    """What is measured of the page's size, or of the distance of the fringes."""
    return next((float(one.measured) for one in identity.reasons if one.code == "page_scale"), None)


@pytest.mark.claim("A page printed at a wrong scale is called that, and no forgery")
@pytest.mark.parametrize("scale", [0.96, 0.965, 0.97, 0.975])
def test_a_page_that_mirrors_its_code_is_no_forgery(board, scale):
    """Catches: a page printed at 97 %, whose fringes run backwards, rejected; an identity that is read in a mirror and
    counts."""
    identity, motion = judged(board, Building(scale=scale, offset_rad=0.7, twist_rad_per_mm=0.02))
    assert identity.verdict == "unreadable" and identity.decoded_id is None
    assert off(identity) == pytest.approx(scale, abs=0.002)
    assert motion == "inconclusive"


def test_fringes_that_are_played_backwards_are_rejected(board):
    """Catches: any fringes that run backwards put down to the page."""
    identity, motion = judged(board, Building(gain=-1.0, offset_rad=0.7))
    assert identity.verdict == "match" and off(identity) is None and motion == "reject"


@pytest.mark.parametrize("scale", [1.03, 1.05])
def test_fringes_that_no_badge_of_the_layout_has_are_measured(board, scale):
    """Catches: "something covers the badge" where the page is too large; fringes sought where a right page has them."""
    identity, motion = judged(board, Building(scale=scale))
    front = board.lens.pitch_mm
    beats = [abs(1 / cell.pitch_mm - scale / front) for cell in board.gratings[0].cells]
    assert identity.decoded_id is None and motion != "reject"
    assert min(beats) < 1 / off(identity) < max(beats)
