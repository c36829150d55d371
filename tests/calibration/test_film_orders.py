"""Charts are read by a sealed process, and its answers are checked.  Each test names the fault that it catches."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from kit.film_taken_over import HostileOrder
from moireid.cli.main import moireid


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such means")
@pytest.mark.parametrize("chart", ["sheet", "camera"])
def test_a_film_of_a_chart_reaches_no_other_file(chart: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a chart's film that is decoded in the process of the command, with the user's files open to it."""
    (tmp_path / "secret").write_text("a key")
    (tmp_path / "film.mp4").write_bytes(b"a film")
    monkeypatch.chdir(tmp_path)

    order = HostileOrder("steal", str(tmp_path / "secret"))
    monkeypatch.setattr("moireid.cli.pitch_cmd.partial", lambda *_, **__: order)
    words = ["calibrate", "film.mp4", "--camera", "--out", "camera.yaml"]
    if chart == "sheet":
        assert CliRunner().invoke(moireid, ["pitch-test", "--out", "chart"]).exit_code == 0
        words = ["calibrate", "film.mp4", "--chart", "chart/pitch-test.json", "--out", "lens.json"]
    done = CliRunner().invoke(moireid, words)
    assert done.exit_code == 2 and "Permission denied" in done.stderr and "a key" not in done.stderr, done.output
    assert "--unsealed" in CliRunner().invoke(moireid, ["calibrate", "--help"]).output
