"""Badges whose markers are garbled, followed from corners that a person gave.  Beside each test: what it would catch.

The films are those made outside, with every marker painted over by a plain dark square, as generated films make of one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kit.coded_films import written
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.verifier import Claim, Frame, Verifier, verify
from moireid.verifier.camera.page_warp import page_warps
from moireid.verifier.corners import CornerFollower, corners_from
from moireid.verifier.motion.judge import Invariant
from moireid.verifier.reasons import Reason
from moireid.verifier.session.by_corners import never_accepted
from moireid.verifier.session.chapters import invariant_of
from moireid.verifier.tracking.markers import marker_corners_mm
from moireid.verifier.tracking.own_page import OwnPage
from moireid.verifier.tracking.scene_tracker import BadgesInView
from moireid.verifier.video import Film

#: What a person's corners are wrong by, px, standard deviation.
GIVEN_PX = 1.5
IMAGE_PX = (1920, 1080)


@dataclass
class Painted:
    """Every second frame of a film, its markers painted over; the page's homographies by the markers that were there.

    given: corners in the first frame, wrong by `GIVEN_PX`; wrong (3, 3): the page warp that this makes.
    """

    frames: list[Frame]
    pages: np.ndarray
    given: np.ndarray
    wrong: np.ndarray


def region_of(badge: Badge) -> np.ndarray:
    x0, y0, x1, y1 = badge.gratings[0].rect_mm
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def seen(page: np.ndarray, places_mm: np.ndarray) -> np.ndarray:
    return cv2.perspectiveTransform(places_mm[:, None].astype(float), page)[:, 0]


def painted(film: Path, badge: Badge) -> Painted:
    view, frames = BadgesInView(badge), []
    for frame in Film(film).frames():
        if frame.index % 2 == 0:
            view.push(frame)
            frames.append(frame)
    pages = view.trackers[0].look().homographies
    assert len(pages) == len(frames)
    for frame, page in zip(frames, pages, strict=True):
        for square in marker_corners_mm(badge.markers):
            cv2.fillConvexPoly(frame.luma, np.round(seen(page, square) * 16).astype(np.int32), 45, cv2.LINE_AA, 4)
    true = seen(pages[0], region_of(badge))
    given = true + GIVEN_PX * np.random.default_rng(3).standard_normal((4, 2))
    believed = cv2.getPerspectiveTransform(region_of(badge).astype(np.float32), given.astype(np.float32))
    return Painted(frames, pages, given, np.linalg.inv(pages[0]) @ believed)


@pytest.fixture(scope="module")
def genuine(films: Path, prototype: Badge) -> Painted:
    return painted(films / "genuine_1.0m.mp4", prototype)


def judged(film: Painted, badge: Badge) -> Verifier:
    verifier = Verifier(Claim(badge), running=False, corners={0: film.given})
    for frame in film.frames:
        verifier.push(frame)
    verifier.finish()
    return verifier


def test_the_page_is_followed_and_fringes_do_not_drag_it(genuine: Painted, prototype: Badge):
    """Measured: 0.03 px in the middle, 0.13 px at most.  Catches: features on the fringes, a page that drifts."""
    ours, plain = OwnPage(prototype, {0: genuine.given}), CornerFollower({0: genuine.given})
    errors, dragged = [], []
    for frame, page in zip(genuine.frames, genuine.pages, strict=True):
        found = ours.find(frame.index, frame.luma)
        assert found is not None
        true = seen(page @ genuine.wrong, region_of(prototype))
        errors.append(np.linalg.norm(seen(found.homography, region_of(prototype)) - true, axis=1).max())
        corners = plain.follow(frame.index, frame.luma)
        dragged.append(np.inf if corners is None else np.linalg.norm(corners - true, axis=1).max())
    assert np.median(errors) < 0.1 and np.max(errors) < 0.3
    assert np.max(dragged) > 3.0


def test_a_true_film_fails_nothing_and_is_not_accepted(genuine: Painted, prototype: Badge):
    """Catches: tilts that are wrong by what a person's pixel makes of them; an accept on somebody's word."""
    verifier = judged(genuine, prototype)
    invariant = invariant_of(verifier.chapters)
    assert verifier.chapters[0].tracked == len(genuine.frames)
    assert invariant.verdict == "inconclusive" and verifier.chapters[0].invariant.verdict == "accept"
    assert [reason.code for reason in invariant.reasons if reason.level != "pass"] == ["corners"]
    assert invariant.gain_ratio == pytest.approx(1.0, abs=0.03) and invariant.score > 1.5
    assert {segment.verdict for segment in verifier.chapters[0].segments} == {"inconclusive"}
    camera = verifier.chapters[0].measurement.camera
    assert abs(camera.focal_px - 1450) < 4 * camera.focal_sd_px < 100


def test_a_forged_film_is_rejected(films: Path, prototype: Badge):
    """Catches: a warp of the page that makes any film true."""
    verifier = judged(painted(films / "forged_gain_low_1.0m.mp4", prototype), prototype)
    invariant = invariant_of(verifier.chapters)
    assert invariant.verdict == "reject"
    assert "gain" in {reason.code for reason in invariant.reasons if reason.level == "fail"}
    assert invariant.gain_ratio == pytest.approx(0.53, abs=0.05)


@pytest.mark.parametrize(
    ("failed", "focal_told", "verdict"),
    [("gain", True, "reject"), ("likelihood", True, "inconclusive"), ("gain", False, "inconclusive")],
)
def test_what_corners_can_tell_is_what_has_error_bars(failed: str, focal_told: bool, verdict: str):
    """Catches: a true film rejected for rows read beside their place, or for a focal length that it does not tell."""
    reasons = (Reason("motion", "pass", 1.0, 0.25, "rad", "Enough."), Reason(failed, "fail", 2.0, 1.0, "", "Wrong."))
    told = never_accepted(Invariant("reject", reasons, score=-2.0), 90, focal_told=focal_told)
    assert told.verdict == verdict and told.score == -2.0
    last = told.reasons[-1]
    assert (last.code, last.measured, "--focal-px" in last.text) == ("corners", 90.0, not focal_told)
    whole = never_accepted(Invariant("accept", reasons[:1]), 90, focal_told=True)
    assert whole.verdict == "inconclusive"


def test_a_badge_that_is_gone_is_lost_until_it_is_set_right(genuine: Painted, prototype: Badge):
    """Catches: a page followed where none is; a correction that begins another page, wrong in another way."""
    frames, later = genuine.frames[:20], genuine.frames[60]
    again = seen(genuine.pages[60], region_of(prototype)) + np.array([[2.0, 1], [-1, 2], [1, -1], [0, 2]])
    page = OwnPage(prototype, {0: genuine.given, later.index: again})
    assert all(page.find(frame.index, frame.luma) is not None for frame in frames)
    gone = replace(frames[-1], index=50, luma=np.full_like(frames[-1].luma, 128))
    assert page.find(gone.index, gone.luma) is None
    found = page.find(later.index, later.luma)
    assert found is not None
    true = seen(genuine.pages[60] @ genuine.wrong, region_of(prototype))
    assert np.abs(seen(found.homography, region_of(prototype)) - true).max() < 0.3


def test_a_film_cut_away_is_left_open_and_says_where(genuine: Painted, prototype: Badge):
    """Catches: a verdict on too few frames, a reason without advice, markers asked for that the film has not."""
    grey = np.full_like(genuine.frames[0].luma, 128)
    frames = [frame if k < 40 else replace(frame, luma=grey) for k, frame in enumerate(genuine.frames)]
    short = replace(genuine, frames=frames)
    invariant = invariant_of(judged(short, prototype).chapters)
    absent = next(reason for reason in invariant.reasons if reason.code == "badge_absent")
    assert invariant.verdict == "inconclusive" and absent.measured == 40.0
    assert f"lost after frame {genuine.frames[39].index}" in absent.text and "marker" not in absent.text


def test_a_page_s_warp_is_told_by_the_tilts_that_it_makes(prototype: Badge):
    """Catches: a wrong sign or order in taking the warp out, ways that lead the other way than the prior says."""
    rng = np.random.default_rng(5)
    camera = np.array([[1500.0, 0, 959.5], [0, 1500, 539.5], [0, 0, 1]])
    x0, y0, x1, y1 = prototype.gratings[0].rect_mm
    pages = []
    for _ in range(60):
        turn = Rotation.from_rotvec(rng.normal(0, 0.15, 3)).as_matrix()
        place = np.array([rng.uniform(-100, 100), rng.uniform(-60, 60), 1000.0])
        rigid = np.column_stack([turn[:, 0], turn[:, 1], place])
        pages.append(camera @ rigid @ np.array([[1, 0, -(x0 + x1) / 2], [0, 1, -(y0 + y1) / 2], [0, 0, 1.0]]))
    true = np.array(pages) / np.array(pages)[:, 2:, 2:]
    corners = seen(true[0], region_of(prototype))
    believed = cv2.getPerspectiveTransform(
        region_of(prototype).astype(np.float32), (corners + rng.normal(0, GIVEN_PX, (4, 2))).astype(np.float32)
    )
    wrong = true @ np.linalg.inv(true[0]) @ believed
    warps = page_warps(wrong, prototype.gratings[0].rect_mm, IMAGE_PX, 1500.0)

    def misfit(homographies: np.ndarray) -> np.ndarray:
        columns = np.linalg.inv(camera) @ homographies
        first, second = columns[..., 0], columns[..., 1]
        return np.abs((first * second).sum(axis=1)) / (first**2).sum(axis=1)

    assert np.median(misfit(warps.homographies)) < 0.05 * np.median(misfit(wrong)) < 0.05
    # Gone back by the prior, the points are where the page was believed to be, but for what is second order.
    places = marker_corners_mm(prototype.markers).reshape(-1, 2)
    moved = np.tensordot(warps.prior, warps.points_px(places), 1)
    apart = np.array(
        [seen(old, places) - seen(new, places) for old, new in zip(wrong, warps.homographies, strict=True)]
    )
    assert np.abs(apart).max() > 1.0 and np.abs(moved - apart).max() < 0.2 * np.abs(apart).max()


def test_markers_come_before_corners(films: Path):
    """Catches: a film whose markers are seen left open because somebody gave corners too."""
    from moireid.badge import load_badge

    board = load_badge(films / "badge_mask.json")
    nonsense = {0: np.array([[10.0, 10], [60, 10], [60, 60], [10, 60]])}
    report = verify(films / "rendered_path_1.4m.mp4", board, claimed_id=None, corners=nonsense)
    assert report.verdict == "accept" and "corners" not in {reason.code for reason in report.reasons}


def test_a_film_of_nothing_is_open_by_its_corners(prototype: Badge, tmp_path: Path):
    """Catches: corners that verify passes over, and a board that is followed on an even grey."""
    film = written(tmp_path / "nothing.mp4", [np.full((480, 640), 90, np.uint8)] * 70, "libx264", "yuv420p")
    report = verify(
        film, prototype, claimed_id=None, corners={0: np.array([[200.0, 150], [300, 150], [300, 250], [200, 250]])}
    )
    assert report.verdict == "inconclusive" and report.frames == {"read": 70, "tracked": 0}
    assert "From the corners given" in report.reasons[0].text


def test_corners_are_read_as_people_write_them(tmp_path: Path):
    """Catches: a correction read as the first frame, a bow-tie, a word, a path taken for numbers."""
    first, later = "10,10,90.5,12,92,80,11,85", "20,20,95,22,96,88,21,90"
    found = corners_from(f"{first} 30:{later}; 45:{first}")
    assert list(found) == [0, 30, 45] and found[30][1] == pytest.approx([95, 22]) and found[0][1, 0] == 90.5
    assert list(corners_from(f"0:{first}")) == [0]
    (tmp_path / "a.csv").write_text(f"frame,x1,y1,x2,y2,x3,y3,x4,y4\n0,{first}\n")
    assert list(corners_from("a.csv", tmp_path)) == [0]
    for wrong in ("10,10", f"{first} {later}", f"7:{first}", "10,10,92,80,90,12,11,85", f"1.5:{first}", "none.csv", ""):
        with pytest.raises(SpecError):
            corners_from(wrong, tmp_path)
