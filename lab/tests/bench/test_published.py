"""The paper's tables on our films.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid_lab.bench import published
from moireid_lab.bench.published import COURSES, DISTANCES_M, _planned, conditions


def test_the_renderings_are_seven_distances_times_ten_courses():
    """Catches: a distance that is left out, courses that are all one, two films of one name."""
    rows = list(conditions(quick=False))
    films = [one for row in rows for one in _planned(row, COURSES, 0)]
    assert len({one.name for one in films}) == len(films) == (2 * 7 + 4) * 10
    assert len({one.group for one in films}) == len(rows) and DISTANCES_M == (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
    assert {one.wish["seed"] for one in films} == set(range(1, 11))


@pytest.mark.slow
def test_the_command_films_scores_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Catches: films of one row counted in another, a second run that films again, figures of the other pipeline."""
    rows = [replace(row, wish=row.wish | {"frames": 40}) for row in conditions(quick=True)][:2]
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
