"""A badge whose lines bend from cell to cell, printed and filmed.  Next to each test: what it would catch."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from moireid.badge import Badge, load_badge
from moireid.cli.main import moireid
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify

PAYLOAD = "0f38c1a2b3d4e5f6"
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def silk(tmp_path_factory: pytest.TempPathFactory) -> Badge:
    out = tmp_path_factory.mktemp("silk") / "ada"
    wish = ["print", "Ada", "--payload", PAYLOAD, "--mount", "none", "--out", str(out), "--json"]
    made = CliRunner().invoke(moireid, wish)
    assert made.exit_code == 0, made.output
    assert json.loads((out / "badge.json").read_text())["format"] == 2
    return load_badge(out / "badge.json")


@pytest.mark.parametrize(("forged", "wanted"), [(None, "accept"), ("gain_low", "inconclusive"), ("reversed", "reject")])
def test_a_silk_badge_is_read_and_a_forged_film_of_it_is_not_accepted(silk, forged, wanted, tmp_path: Path):
    """Catches: cells read where their neighbours bend the lines; a twist and an offset that the blend hides."""
    scene = Scene(silk, Build(lens_offset_mm=0.1, twist_rad=0.003, print_scale=1.002), Camera())
    path = tmp_path / "film.mp4"
    film(scene, motion_named("sway", distance_mm=1200.0, seed=2), path, frames=180, fps=30.0, seed=2, forge=forged)
    report = verify(path, Question(silk, silk.id))
    assert report.verdict == wanted
    assert report.identity.decoded_id == PAYLOAD or forged
