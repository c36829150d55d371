"""Several badges in one film: which markers belong together, which track is judged, and what of a cut.

Both badges are filmed by one camera: each film shows its badge beside the camera's axis, and halves of their frames
are put side by side, so that perspective is true in both halves.
"""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from kit.coded_films import written
from kit.drawn_pages import MARKERS, seen_from
from kit.payloads import payload_for_name
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.question import Question
from moireid.simulate.filming import film
from moireid.simulate.motion import Poses, motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import verify
from moireid.verifier.picture import Frame
from moireid.verifier.reasons import worst
from moireid.verifier.session.badge_session import reasons_of
from moireid.verifier.session.streaming import Verifier
from moireid.verifier.tracking.finding.page_groups import MOST_PAGES, pages_of, same_page
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.video import Film

WIDTH, HEIGHT, FPS, FRAMES = 960, 540, 30.0, 80
CAMERA = Camera(width=WIDTH, height=HEIGHT, focal_px=725.0)
CORNERS = marker_corners_mm(MARKERS)


def shot(badge: Badge, path: Path, *, aside_mm: float, distance_mm: float, seed: int, forge: str | None = None):
    """Frames of a badge that is held so far to the right of the camera's axis."""
    course = motion_named("circle", distance_mm=distance_mm, seed=seed)

    def motion(times_s):
        poses = course(times_s)
        # To the camera's right, whichever way it looks.
        return Poses(poses.camera_mm - aside_mm * poses.rotation[:, 0], poses.rotation)

    film(Scene(badge, Build(lens_offset_mm=0.11), CAMERA), motion, path, frames=FRAMES, fps=FPS, forge=forge, seed=seed)
    return [frame.luma for frame in Film(path).frames()]


def beside(left, right):
    """Pictures with the left half of one film and the right half of another."""
    half = WIDTH // 2
    return [np.hstack([a[:, :half], b[:, half:]]) for a, b in zip(left, right, strict=True)]


def frames_of(pictures, first: int = 0):
    return [Frame(first + k, (first + k) / FPS, picture) for k, picture in enumerate(pictures)]


@pytest.fixture(scope="module")
def bob() -> Badge:
    return design_badge(Order("Bob Noyce", lens="50lpi"), payload_for_name("Bob Noyce"))


@pytest.fixture(scope="module")
def shots(ada, bob, tmp_path_factory):
    """By person and side; those on the right are nearer."""
    out = tmp_path_factory.mktemp("shots")
    left, right = {"aside_mm": -160.0, "distance_mm": 900.0}, {"aside_mm": 160.0, "distance_mm": 800.0}
    return {
        "ada left": shot(ada, out / "a.mp4", **left, seed=7),
        "bob right": shot(bob, out / "b.mp4", **right, seed=8),
        "ada right": shot(ada, out / "c.mp4", **right, seed=9),
        "forged left": shot(ada, out / "f.mp4", **left, seed=10, forge="reversed"),
        "print right": shot(ada, out / "p.mp4", **right, seed=11, forge="frozen"),
    }


@pytest.fixture(scope="module")
def both(shots, tmp_path_factory) -> Path:
    pictures = beside(shots["ada left"], shots["bob right"])
    return written(tmp_path_factory.mktemp("both") / "both.mp4", pictures, "libx264", "yuv420p")


# Which badge is judged.


@pytest.mark.slow
def test_each_of_two_badges_bears_out_its_own_claim(both, ada, bob):
    """Catches: the first badge judged whatever is claimed; two badges read as one; a neighbour that rejects."""
    for badge, left in ((ada, True), (bob, False)):
        report = verify(both, Question(badge, badge.id))
        assert report.verdict == "accept" and report.identity.decoded_id == badge.id
        assert report.frames == {"read": FRAMES, "tracked": FRAMES, "unsearched": 0, "damaged": 0}
        document = report.to_json()
        corners = np.array(document["region"]["corners_px"])
        assert np.all((corners[:, 0] < WIDTH / 2) == left) and document["region"]["frame"] == 0
        # Top left, top right, bottom right, bottom left.
        assert corners[1, 0] - corners[0, 0] > 60 and corners[3, 1] - corners[0, 1] > 60
        (note,) = [reason for reason in document["reasons"] if reason["code"] == "others"]
        assert note["level"] == "note" and note["measured"] == 1.0
        assert (bob if left else ada).id in note["text"] and badge.id not in note["text"]


def judged(pictures, badge: Badge, claimed: str | None):
    verifier = Verifier(Question(badge, claimed))
    running = [told for frame in frames_of(pictures) if (told := verifier.push(frame)) is not None]
    reasons = reasons_of(verifier.finish()) + verifier.others
    return worst(list(reasons)), running[-1].verdict, verifier


@pytest.mark.claim("Of two badges in view, neither excuses nor rejects the other")
@pytest.mark.slow
@pytest.mark.parametrize("claimed", [True, False], ids=["claim", "no claim"])
def test_a_true_badge_excuses_no_forged_one_and_a_copy_rejects_no_true_one(shots, ada, claimed):
    """Catches: the best of several tracks taken; a wearer who is rejected for the print that a bystander moves."""
    for other in ("forged left", "print right"):
        is_left = other.endswith("left")
        sides = (shots[other], shots["ada right"]) if is_left else (shots["ada left"], shots[other])
        verdict, running, verifier = judged(beside(*sides), ada, ada.id if claimed else None)
        assert verdict == running == "inconclusive"
        (found,) = [reason for reason in verifier.others if reason.code == "others_break"]
        # Both places, the rejected one first, and the true one is that of the report.
        places = [float(x) > WIDTH / 2 for x in re.findall(r"near \((\d+), ", found.text)]
        assert places == [not is_left, is_left]
        assert (verifier.judged.region["corners_px"][0][0] > WIDTH / 2) == is_left
    verdict, running, _ = judged(beside(shots["forged left"], shots["print right"]), ada, ada.id if claimed else None)
    assert verdict == running == "reject"


# Cuts.


@pytest.mark.slow
def test_a_badge_that_leaves_and_comes_back_elsewhere_is_followed_again(shots, ada):
    """Catches: a track that ends at a cut; a second track for the one badge of a film."""
    view = SceneTracker(ada)
    grey = np.full((HEIGHT, WIDTH), 120, np.uint8)
    there = shots["ada left"][:20]
    elsewhere = [np.roll(picture, 300, axis=1) for picture in shots["ada left"][20:40]]
    for frame in frames_of([*there, *[grey] * 8, *elsewhere]):
        view.push(frame)
    (tracker,) = view.trackers
    assert tracker.tracked == 40 and tracker.frames_read == 48 and not view.given_up


@pytest.fixture(scope="module")
def with_cuts(shots):
    """Six frames of two badges, three times, the second time in each other's place."""
    pair = beside(shots["ada left"], shots["bob right"])[:6]
    swapped = [np.roll(picture, WIDTH // 2 + 40, axis=1) for picture in pair]
    grey = [np.full((HEIGHT, WIDTH), 120, np.uint8)] * 35
    return frames_of([*pair, *grey, *swapped, *grey, *pair])


@pytest.mark.slow
def test_after_a_cut_no_track_is_made_of_two_badges(with_cuts, ada):
    """Catches: badges that have changed places taken for each other; tracks without bound in a film of many cuts."""
    view, given_up = SceneTracker(ada), []
    for frame in with_cuts:
        view.push(frame)
        assert len(view.trackers) <= MOST_PAGES
        given_up += view.given_up
        view.given_up.clear()
    tracks = [tracker.take() for tracker in (*given_up, *view.trackers)]
    assert [track.tracked for track in tracks] == [6] * 6
    assert all(np.ptp(track.frame_numbers) == 5 for track in tracks)


@pytest.mark.slow
def test_a_badge_that_comes_in_later_is_taken_up_within_two_seconds(shots, ada):
    """Catches: others looked for in the first frame alone, or never while a badge is seen."""
    view, empty = SceneTracker(ada), np.full((HEIGHT, WIDTH), 200, np.uint8)
    alone = beside(shots["ada left"], [empty] * FRAMES)
    for frame in frames_of([*alone[:10], *beside(shots["ada left"], shots["bob right"])[10:]]):
        view.push(frame)
    first, second = view.trackers
    assert first.tracked == FRAMES and second.ends.first.frame == 60 and second.tracked == FRAMES - 60


# Which markers belong together.


def quads_of(homography) -> np.ndarray:
    return cv2.perspectiveTransform(CORNERS.reshape(-1, 1, 2), homography).reshape(4, 4, 2)


@pytest.mark.slow
def test_markers_are_grouped_by_geometry(rng):
    """Catches: one page through the markers of two; a page of a marker twice; another's marker in the place of one."""
    one, other = seen_from(at=(330.0, 300.0)), seen_from(px_per_mm=1.3, turn_deg=-10.0, at=(820.0, 330.0))
    quads = np.concatenate([quads_of(one), quads_of(other)])
    for hidden in [(), (0,), (5,), (1, 6), (0, 3, 6), (0, 2, 4, 6)]:
        kept = [k for k in rng.permutation(8) if k not in hidden]
        noisy = quads[kept] + 0.15 * rng.standard_normal((len(kept), 4, 2))
        pages = pages_of(noisy, [k % 4 for k in kept], CORNERS)
        assert len(pages) == 2, hidden
        for page in pages:
            assert sum(same_page(page, truth, CORNERS) for truth in (one, other)) == 1, hidden
        assert not same_page(*pages, CORNERS)
