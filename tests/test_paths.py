"""Public functions take a path as text or as `Path`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from kit.places import FILMS
from moireid.badge import load_badge
from moireid.errors import SpecError
from moireid.files import as_path
from moireid.simulate import Build, Camera, Scene, film, motion_named, truth_path
from moireid.verifier import Question, verify, write_report

BADGE = load_badge(FILMS / "badge.json")


def test_a_film_is_written_by_its_name(tmp_path: Path) -> None:
    """Catches: a simulator that needs a `Path`, for the film or for its truth; a report that does."""
    video = str(tmp_path / "film.mp4")
    scene = Scene(BADGE, Build.typical(seed=1), Camera(width=320, height=240, focal_px=240.0))
    made = film(scene, motion_named("static", distance_mm=800.0, seed=1), video, frames=2, fps=30)
    assert (made.video, made.truth, truth_path(video)) == (Path(video), Path(f"{video}.truth.csv"), made.truth)
    report = verify(str(FILMS / "genuine_1.0m.mp4"), Question(BADGE))
    assert write_report(report, str(tmp_path / "pages"))[0] == tmp_path / "pages" / "report.html"


@pytest.mark.parametrize("given", [None, 3, b"film.mp4", ["film.mp4"]])
def test_what_is_no_path_is_refused_in_a_sentence(given: Any) -> None:
    """Catches: a file descriptor taken for a path (`open(3)`), and an error about an attribute."""
    with pytest.raises(SpecError, match=r"is no path; give a str or a pathlib\.Path"):
        as_path(given)
