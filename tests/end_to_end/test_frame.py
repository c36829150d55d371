"""A badge with a coded frame in place of squares, filmed and verified.  Each test names what it would catch."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from moireid.badge import Badge, CodedFrame
from moireid.designer import Order, design_badge
from moireid.simulate.cameras import Camera
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene
from moireid.verifier import KnownCamera, Question, verify

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")
CAMERA = Camera(width=960, height=720)
FRAMES = 90


@pytest.fixture(scope="module")
def framed() -> Badge:
    return design_badge(Order("Ada", lens="50lpi", markers="frame", range_m=(0.8, 2.0)), PAYLOAD)


@pytest.mark.claim("A coded frame serves as squares do")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("forge", "mirror", "verdict"), [(None, False, "accept"), (None, True, "accept"), ("reversed", False, "reject")]
)
def test_a_framed_badge_is_judged_as_one_with_squares(
    framed: Badge, tmp_path: Path, forge: str | None, mirror: bool, verdict: str
) -> None:
    """Catches: a page of a frame taken the wrong way round, whose fringes would be called forged; a mirrored film whose
    frame is read as a turned one; a forgery that a frame lets pass.
    """
    assert isinstance(framed.markers, CodedFrame)
    scene = Scene(framed, Build(), replace(CAMERA, mirror=mirror))
    course = motion_named("sway", distance_mm=1000.0, seed=4)
    film(scene, course, tmp_path / "film.mp4", frames=FRAMES, fps=30.0, seed=4, forge=forge)
    report = verify(tmp_path / "film.mp4", Question(framed, framed.id, camera=KnownCamera(CAMERA.focal_px)))
    assert report.verdict == verdict
    if forge is None:
        assert report.frames["tracked"] >= 0.98 * FRAMES
        assert report.identity.decoded_id == framed.id
