"""The paper's experiments on our films.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

from moireid.cli.main import moireid
from moireid.result_cache import kept_rows
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid_lab.bench.paper import given_corners
from moireid_lab.bench.paper_films import DISTANCES_M, every_film
from moireid_lab.bench.paper_tables import GENERATED, REAL, rates, roc_figure, statistics


def test_the_sets_are_the_papers():
    """Catches: a distance or a profile left out, films of one name, a set of another size than in the paper."""
    films = every_film()
    counts = Counter(film.set for film in films.values())
    assert counts["rendering 1"] == 70 and counts[REAL] == 87 and counts[GENERATED] == 92
    assert DISTANCES_M == (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
    assert len([name for name in films if name.startswith("rendering 1, 1.4 m")]) == 10


@pytest.mark.parametrize("profile", range(10))
def test_rendering_1_sweeps_from_half_a_metre_to_straight_in_front_with_all_markers_in_view(profile: int):
    """Catches: a trajectory from -0.25 to 0.25 m, a camera that looks at the board, a marker out of the picture."""
    film = every_film()[f"rendering 1, 1.1 m, profile {profile}"]
    times = np.arange(film.how["frames"]) / film.how["fps"]
    poses = film.motion(times)
    assert poses.camera_mm[[0, -1]] == pytest.approx(np.array([[500, 0, -1100], [0, 0, -1100]]), abs=1e-6)
    assert np.ptp(np.diff(poses.camera_mm[:, 0])) < 1e-6
    assert 0.1 < np.degrees(Rotation.from_matrix(poses.rotation).magnitude()).max() < 4
    corners = marker_corners_mm(film.scene.badge.squares).reshape(-1, 2) - film.scene.board_centre_mm
    seen = np.column_stack([corners, np.zeros(16)]) - poses.camera_mm[:, None]
    camera = film.scene.camera
    pixels = camera.project(np.einsum("tij,tkj->tki", poses.rotation, seen))
    assert np.all((pixels > 0) & (pixels < (camera.width, camera.height)))


def test_fields_and_turns_are_as_stated():
    """Catches: one field where two are stated, another length, C seen from aside in place of turned in its plane."""
    films = every_film()
    assert {name: [g.axis for g in films[name].scene.badge.gratings] for name in "ACD"} == {
        "A": ["x", "y"],
        "C": ["x"],
        "D": ["x", "y"],
    }
    assert [films[name].how["frames"] for name in ("A", "B1", "B2", "C", "D")] == [180, 120, 120, 120, 240]
    assert [films[name].compensated for name in ("A", "B1", "C", "D")] == [False, True, True, True]
    turned = Rotation.from_matrix(films["C"].motion(np.array([0.5])).rotation).as_rotvec(degrees=True)
    assert turned == pytest.approx(np.array([[0, 0, 45]]))


def test_given_corners_are_where_the_field_is_seen():
    """Catches: corners of the page for the field's, of another frame, mirrored."""
    film = next(film for film in every_film().values() if film.marked)
    corners = given_corners(film)
    assert list(corners)[:2] == [0, 24]
    (a, b, c, d), camera = corners[0], film.scene.camera
    assert a[0] < b[0] and a[1] < d[1] and b[1] < c[1]
    assert b[0] - a[0] == pytest.approx(camera.focal_px * 83.2 / 1100, rel=0.03)


@pytest.mark.slow
def test_the_command_films_scores_and_goes_on(tmp_path: Path):
    """Catches: rotation compensated where it must not be, figures of the other field, a run that films again."""
    command = ["lab", "paper", "--only", "(A|rendering 2, 1.1 m)$", "--out", str(tmp_path)]
    ran = CliRunner().invoke(moireid, command)
    assert ran.exit_code == 0, ran.output
    kept = (tmp_path / "rows.jsonl").read_text()
    rows = kept_rows(tmp_path / "rows.jsonl")
    first, second = (rows[f"paper {name}"]["fields"] for name in ("rendering 2, 1.1 m", "A"))
    assert rows["paper A"]["metres"] == 1.2
    assert first["x"]["greatest"] > 0.98 and first["x"]["ours"]["mean"] > 0.99
    # Without rotation the picture's place is the camera's, so nothing but the phase can differ from the law.
    assert first["x"]["place"] > 0.9999 and second["y"]["place"] > 0.99
    assert second["x"] != second["y"]
    assert "| A, y, 1.2 m | 1 |" in (tmp_path / "paper.md").read_text()
    assert CliRunner().invoke(moireid, command).exit_code == 0
    assert (tmp_path / "rows.jsonl").read_text() == kept


def test_rates_and_statistics_are_of_the_scored_films():
    """Catches: a film without a score counted as 0, accuracy of one kind alone, sides exchanged."""
    true, false = [0.95, 0.99, 0.8, None], [0.6, 0.94, 0.5, 0.4]
    scores = [(name, one) for name, some in ((REAL, true), (GENERATED, false)) for one in some]
    rows = [{"kind": name, "score": one, "fields": {"x": {"greatest": one, "mean": one}}} for name, one in scores]
    lines = {cells[0]: cells[1:] for cells in rates(rows)}
    assert lines["0.927"] == ("0.667", "0.250", f"{5 / 7:.3f}")
    ours, greatest = list(statistics(rows))[1:3]
    assert ours[1:] == greatest[1:] and greatest[1].endswith("(3)") and greatest[2].endswith("(4)")
    (axes,) = roc_figure(rows).axes
    assert greatest[5] == "0.917" and axes.lines[1].get_label().endswith(": 0.917")
