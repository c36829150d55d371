"""Corners given by hand: read, followed by the published pipeline, and what our own says of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from kit.coded_films import written
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.verifier import Claim, Film, verify
from moireid_lab.baseline.corners import (
    COLUMNS,
    CornerFollower,
    read_corners,
    without_corners,
)
from moireid_lab.evaluation.film_rows import Job, score_film
from moireid_lab.evaluation.manifest import read_manifest

CORNERS = "0,200,150,300,150,300,250,200,250"


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


@pytest.fixture(scope="module")
def mostly_gone(films: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A true film whose badge is in view for its first 100 frames, and then not for 120."""
    pictures = [frame.luma for frame, _ in zip(Film(films / "genuine_1.0m.mp4").frames(), range(100), strict=False)]
    gone = [np.full_like(pictures[0], 128)] * 120
    return written(tmp_path_factory.mktemp("gone") / "film.mp4", pictures + gone, "libx264", "yuv420p")


@pytest.mark.slow
def test_a_row_of_a_collection_says_so_too(films: Path, mostly_gone: Path, prototype: Badge):
    """Catches: an accepted row of a film that the command leaves open."""
    manifest = mostly_gone.with_name("films.csv")
    manifest.with_name("corners.csv").write_text("\n".join([",".join(COLUMNS), CORNERS]))
    manifest.write_text("video,label,claim,group,corners\nfilm.mp4,genuine,,,corners.csv\n")
    entry = read_manifest(manifest, badge=prototype).entries[0]
    row = score_film(Job(entry, "moireid"), str(mostly_gone))
    assert (row["verdict"], row["codes"]) == ("inconclusive", ["cover", "corners"])


@pytest.mark.slow
def test_what_markers_reject_stays_rejected(films: Path, prototype: Badge):
    """Catches: an open finding that takes a rejection back."""
    report = verify(films / "forged_reversed_1.0m.mp4", Claim(prototype))
    printed = without_corners(replace(report, frames={"read": 900, "tracked": report.frames["tracked"]}))
    assert printed.verdict == "reject" and printed.reasons[-1].code == "corners"
