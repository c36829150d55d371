"""The paper's tables on our films.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from moireid.badge import load_badge
from moireid.cli.main import moireid
from moireid.simulate.motion import motion_named
from moireid_lab.bench import published
from moireid_lab.bench.bench_frame import table_text
from moireid_lab.bench.published import COURSES, DISTANCES_M, FIGURES, SWEEP, _figures, _planned, conditions
from moireid_lab.evaluation.collect import ScoredFilm


def test_the_renderings_are_seven_distances_times_ten_courses():
    """Catches: a distance that is left out, courses that are all one, two films of one name."""
    rows = list(conditions(quick=False))
    films = [one for row in rows for one in _planned(row, COURSES, 0)]
    assert len({one.name for one in films}) == len(films) == (2 * 7 + 4) * 10
    assert len({one.group for one in films}) == len(rows) and DISTANCES_M == (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
    assert {one.wish.seed for one in films} == set(range(1, 11))


def test_a_sweep_goes_one_way_at_constant_speed():
    """Catches: a course that turns back within the film, which is no longer the published one."""
    times = np.arange(SWEEP.frames) / SWEEP.fps
    steps = np.diff(motion_named(SWEEP.motion, distance_mm=1100.0, seed=1)(times).camera_mm[:, 0])
    assert steps == pytest.approx(np.full(len(steps), 500 / 120)) and SWEEP.frames / SWEEP.fps == 2.0


def test_the_boards_are_those_that_were_filmed_outside(films: Path):
    """Catches: a field, a gap or a marker of another size."""
    boards = {row.table: row.badge for row in conditions(quick=True)}
    for table, name in (("rendering 1", "badge_mask.json"), ("A", "badge.json")):
        ours, outside = boards[table], load_badge(films / name)
        assert (ours.page_mm, ours.markers) == (outside.page_mm, outside.markers)
        assert (ours.lens, ours.gratings[0].rect_mm) == (outside.lens, outside.gratings[0].rect_mm)
        assert ours.gratings[0].cells[0].pitch_mm == outside.gratings[0].cells[0].pitch_mm


@pytest.mark.slow
def test_the_command_films_scores_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: films of one row counted in another, a second run that films again, figures of the other pipeline."""
    rows = [replace(row, wish=replace(row.wish, frames=40)) for row in conditions(quick=True)][:2]
    monkeypatch.setattr(published, "conditions", lambda quick: rows)
    command = ["bench", "published", "--clips", "1", "--workers", "1", "--keep", str(tmp_path / "out"), "--json"]
    ran = CliRunner().invoke(moireid, command)
    assert ran.exit_code == 0, ran.output
    found = json.loads(ran.stdout)["rows"]
    assert [(row["table"], row["distance_m"]) for row in found] == [("rendering 1", 1.1), ("rendering 1", 1.7)]
    assert all(row[pipeline]["films"] == 1 for row in found for pipeline in ("moireid", "published"))
    near, far = (row["published"]["score"]["mean"] for row in found)
    assert near == found[0]["published"]["window_correlation_max"]["mean"] != far
    assert found[0]["moireid"]["window_correlation_max"]["mean"] is None
    made = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out" / "films").glob("*.mp4")}
    assert CliRunner().invoke(moireid, command).exit_code == 0 and len(made) == 2
    assert made == {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out" / "films").glob("*.mp4")}


def test_films_without_a_published_score_are_counted_and_in_no_mean():
    """Catches: a film of score 0 averaged in, a line that fails where nothing has a score."""

    def scored(score: float | None, verdict: str) -> ScoredFilm:
        row = dict.fromkeys(FIGURES, score) | {"verdict": verdict}
        return ScoredFilm(None, "published", row)  # type: ignore[arg-type]

    found = _figures([scored(0.9, "reject"), scored(1.0, "accept"), scored(None, "inconclusive")])
    assert found["without_score"] == 1 and found["score"]["mean"] == pytest.approx(0.95)
    nothing = _figures([scored(None, "inconclusive")])
    rows = [
        {"table": "rendering 1", "what": "two layers", "distance_m": 1.1, "paper": "0.72", "published": a, "moireid": b}
        for a, b in ((found, found), (nothing, nothing))
    ]
    text = table_text(published.BENCH, rows)
    assert "0.950 ± 0.071" in text and "1/1/1" in text and "(0 in the paper): 2;" in text and "nan" not in text
