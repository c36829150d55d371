"""The published pipeline, kept as a baseline, and corners followed by hand where markers are lost."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.evaluation.baseline.published import fringe_lean_rad, judge, upright_region, verify_published
from moireid.verifier.corners import COLUMNS, CornerFollower, read_corners
from moireid.verifier.video import Film


@pytest.mark.parametrize("lean_deg", [-25.0, -8.0, 0.0, 12.0, 30.0])
def test_leaning_fringes_are_turned_upright(lean_deg):
    """Catches: an angle of the wrong sign, a side for its neighbour, degrees for radians."""
    y, x = np.mgrid[0:400, 0:500]
    lean = np.radians(lean_deg)
    fringes = 128 + 100 * np.sin(2 * np.pi * (x * np.cos(lean) + y * np.sin(lean)) / 90)
    region = fringes.astype(np.uint8)
    assert np.degrees(fringe_lean_rad(region)) == pytest.approx(lean_deg, abs=2.5)
    page = np.array([[6.0, 0, 0], [0, 6.0, 0], [0, 0, 1]])
    clahe = cv2.createCLAHE(1.0, (1, 1))
    upright = upright_region(region, page, (0, 0, 500 / 6, 400 / 6), True, clahe)[100:300, 150:350].astype(float)
    # Upright fringes differ from column to column, and not from row to row.
    assert upright.mean(axis=0).std() > 5 * upright.mean(axis=1).std()


def test_a_true_film_scores_as_published_and_so_does_a_reversed_one(films: Path, prototype: Badge):
    """The baseline must be as good as its paper (0.87), and blind to sign as it is; catches a baseline made weak."""
    true = verify_published(films / "genuine_1.0m.mp4", prototype, claimed_id=None)
    assert true.verdict == "accept" and true.invariant.correlation > 0.99
    assert true.invariant.window_correlation_mean > 0.95
    false = verify_published(films / "forged_reversed_1.0m.mp4", prototype, claimed_id=None)
    assert false.verdict == "accept" and false.invariant.gain_ratio is None


def test_too_short_and_unrelated_series_are_no_accept(rng):
    """Catches: a score from fewer frames than a window, noise taken for agreement."""
    assert judge(np.arange(20.0), np.arange(20.0), 20).verdict == "inconclusive"
    assert judge(rng.normal(size=200), rng.normal(size=200), 200).verdict == "reject"
    place = np.sin(np.arange(200) / 9)
    assert judge(-3 * place, place, 200).score == pytest.approx(1.0)


def test_a_claim_of_an_identity_stays_open(films: Path, prototype: Badge):
    """Catches: an accept for a person whom nothing was read of."""
    report = verify_published(films / "genuine_1.0m.mp4", prototype, claimed_id="00" * 8)
    assert report.verdict == "inconclusive" and report.identity.verdict == "unreadable"


def test_corners_are_followed_until_they_are_set_right(films: Path):
    """Catches: corners that stay behind, x for y, a correction that is passed over."""
    frames = [frame.luma for frame, _ in zip(Film(films / "genuine_1.0m.mp4").frames(), range(6), strict=False)]
    truth = np.array([[700.0, 400.0], [1200.0, 380.0], [1180.0, 800.0], [720.0, 820.0]])
    picture, shift = frames[0], np.array([5.0, -3.0])
    moved = cv2.warpAffine(picture, np.float32([[1, 0, shift[0]], [0, 1, shift[1]]]), picture.shape[::-1])
    corners = cv2.goodFeaturesToTrack(picture[300:900, 600:1300], 60, 0.01, 30).reshape(-1, 2) + np.array([600, 300])
    quad = corners[[int(np.argmin(np.linalg.norm(corners - want, axis=1))) for want in truth]]
    follower = CornerFollower({0: quad, 2: quad + 40.0})
    assert np.array_equal(follower.follow(0, picture), quad)
    assert follower.follow(1, moved) == pytest.approx(quad + shift, abs=0.3)
    assert np.array_equal(follower.follow(2, moved), quad + 40.0)
    assert follower.follow(3, np.full_like(picture, 128)) is None


def test_corner_files_are_read_or_refused(tmp_path: Path):
    """Catches: a bow-tie, a missing first frame, words for numbers, a missing column."""
    path = tmp_path / "corners.csv"

    def written(*rows: str) -> Path:
        path.write_text("\n".join([",".join(COLUMNS), *rows]) + "\n")
        return path

    good = "0,10,10,90,12,92,80,11,85"
    assert list(read_corners(written(good, "30,20,20,95,22,96,88,21,90"))) == [0, 30]
    assert read_corners(written(good))[0][1] == pytest.approx([90, 12])
    for rows in ([], [good.replace("0,", "5,", 1)], ["0,10,10,92,80,90,12,11,85"], ["0,a,b,c,d,e,f,g,h"], ["0,1,2"]):
        with pytest.raises(SpecError):
            read_corners(written(*rows))


def test_the_program_offers_the_baseline(films: Path, tmp_path: Path):
    """Catches: options that are passed over, a report that asks for what the baseline has not."""
    film, badge = str(films / "genuine_1.0m.mp4"), str(films / "badge.json")
    ran = CliRunner().invoke(
        moireid,
        ["verify", film, "--badge", badge, "--pipeline", "published", "--json", "--report", str(tmp_path / "r")],
    )
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout)["pipeline"] == "published" and (tmp_path / "r" / "report.html").exists()
    ran = CliRunner().invoke(moireid, ["verify", film, "--badge", badge, "--corners", "none.csv"])
    assert ran.exit_code == 2 and "none.csv" in ran.output
