"""The published pipeline, kept as a baseline."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from kit.coded_films import first_frames
from kit.places import FILMS
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.verifier import Question
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid_lab.baseline.pipeline import (
    PublishedReader,
    fringe_lean_rad,
    judge,
    upright_region,
    verify_published,
)
from moireid_lab.bench.paper_films import board


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A true film of few frames, for what is no question of accuracy."""
    return first_frames(FILMS / "genuine_1.0m.mp4", tmp_path_factory.mktemp("short") / "short.mp4", 70)


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


@pytest.mark.claim("The published method scores as published")
@pytest.mark.slow
def test_a_true_film_scores_as_published_and_so_does_a_reversed_one(films: Path, prototype: Badge, tmp_path: Path):
    """The baseline must be as good as its paper (0.87), and blind to sign like it; catches a weakened baseline."""
    beginning = first_frames(films / "genuine_1.0m.mp4", tmp_path / "true.mp4", 130)
    true = verify_published(beginning, Question(prototype))
    assert true.verdict == "accept" and true.invariant.correlation > 0.99
    assert true.invariant.window_correlation_mean > 0.95
    reversed_ = first_frames(films / "forged_reversed_1.0m.mp4", tmp_path / "a.mp4", 70)
    false = verify_published(reversed_, Question(prototype))
    assert false.verdict == "accept" and false.invariant.gain_ratio is None


def test_too_short_and_unrelated_series_are_no_accept(rng):
    """Catches: a score from fewer frames than a window, noise taken for agreement."""
    assert judge(np.arange(20.0), np.arange(20.0), 20).verdict == "inconclusive"
    assert judge(rng.normal(size=200), rng.normal(size=200), 200).verdict == "reject"
    place = np.sin(np.arange(200) / 9)
    assert judge(-3 * place, place, 200).score == pytest.approx(1.0)


def test_the_score_is_the_greatest_window_and_0_is_none(rng):
    """Catches: the mean of windows for their greatest, a limit other than the paper's, a film at rest that counts."""
    place = np.sin(np.arange(200) / 9)
    measured = np.where(np.arange(200) < 40, place, rng.normal(size=200))
    found = judge(measured, place, 200)
    assert found.verdict == "accept" and found.score == found.window_correlation_max == pytest.approx(1.0)
    assert found.window_correlation_mean < 0.5 and found.reasons[0].limit == 0.927
    document = found.to_json()
    assert document["window_correlation_min"] < document["window_correlation_mean"] < document["window_correlation_max"]
    assert 0 < document["window_correlation_sd"] < 0.5
    still = judge(np.zeros(200), place, 200)
    assert still.verdict == "inconclusive" and still.score is None


@pytest.mark.slow
def test_the_program_offers_the_baseline(short: Path, films: Path, tmp_path: Path):
    """Catches: options that are passed over, a report that asks for what the baseline has not."""
    film, badge = str(short), str(films / "badge.json")
    ran = CliRunner().invoke(
        moireid,
        ["verify", film, "--badge", badge, "--pipeline", "published", "--json", "--report", str(tmp_path / "r")],
    )
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout)["pipeline"] == "published" and (tmp_path / "r" / "report.html").exists()


@pytest.mark.parametrize("size", [(640, 360), (360, 640)])
def test_the_guessed_focal_length_is_the_longer_side(size: tuple[int, int], prototype: Badge):
    """Catches: the width of a film that was taken upright."""
    assert PublishedReader(prototype, None, size, None)._camera[0, 0] == 640


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_place_is_across_the_fringes_however_the_board_is_turned(axis: str):
    """Catches: the picture's own x or y, on which a board turned by a right angle would not move at all."""
    page = board(axis)
    middle = np.array([101.6, 127.0])
    corners = marker_corners_mm(page.squares) - middle
    reader = PublishedReader(page, None, (1920, 1080), None)
    place = np.linspace(-100, 100, 9)
    luma = np.zeros((1080, 1920), np.uint8)
    for k, moved in enumerate(place):
        # The board is turned by a right angle in the picture, and moves along its own axis.
        own = corners + (np.eye(2)[0 if axis == "x" else 1] * moved)
        seen = np.stack([-own[..., 1], own[..., 0]], axis=-1) * 1920 / 1500 + [959.5, 539.5]
        reader._points = lambda index, luma, seen=seen: (corners + middle, seen)  # type: ignore[method-assign]
        reader.push(k, luma)
    assert np.array(reader.places) == pytest.approx(place / 1500, abs=1e-3)
