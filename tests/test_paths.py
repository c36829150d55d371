"""Public functions take a path as text or as `Path`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from kit.places import FILMS
from moireid.artwork.content import content_of
from moireid.artwork.pictures import load_picture
from moireid.badge import load_badge
from moireid.calibration.camera_fit import camera_from_film
from moireid.calibration.still import load_pictures
from moireid.calibration.thickness import thickness_from_film
from moireid.designer import Order, design_badge
from moireid.errors import MoireIdError, SpecError
from moireid.files import as_path
from moireid.profiles import (
    load_lens_profile,
    load_printer_profile,
)
from moireid.simulate import Build, Camera, Scene, film, motion_named, truth_path
from moireid.simulate.motion import from_csv
from moireid.verifier import Film, Question, identify, verify, write_report
from moireid.verifier.camera.known_camera import load_camera
from moireid.verifier.session.capture import capture_as_built

BADGE = load_badge(FILMS / "badge.json")
ISSUED = design_badge(Order("Ada Lovelace", lens="50lpi"), bytes(range(8)))


READERS: dict[str, Callable[[Any], object]] = {
    "load_badge": load_badge,
    "Film": Film,
    "verify": lambda path: verify(path, Question(BADGE)),
    "identify": lambda path: identify(path, [BADGE], lambda badge_id: False),
    "capture_as_built": lambda path: capture_as_built([path], ISSUED),
    "load_camera": load_camera,
    "load_pictures": load_pictures,
    "camera_from_film": camera_from_film,
    "thickness_from_film": lambda path: thickness_from_film(path, BADGE),
    "content_of": content_of,
    "load_picture": lambda path: load_picture(path, "logo"),
    "load_lens_profile": load_lens_profile,
    "load_printer_profile": load_printer_profile,
    "from_csv": lambda path: from_csv(path, 1000.0),
    "motion_named": lambda path: motion_named(path, distance_mm=1000.0, seed=0),
}


@pytest.mark.parametrize("kind", [str, Path])
@pytest.mark.parametrize("name", READERS)
def test_a_reader_takes_text_and_path_and_names_the_file(name: str, kind: type, tmp_path: Path) -> None:
    """Catches: `'str' object has no attribute 'is_file'` in place of the sentence on a file that is absent."""
    with pytest.raises(MoireIdError, match=r"absent\.csv"):
        READERS[name](kind(tmp_path / "absent.csv"))


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
