"""What is drawn beneath a film that is played.  Each test names the wrong implementation it would catch."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from moireid.verifier.report.seconds import Seconds
from moireid_studio import reports
from moireid_studio.jobs.queue import Job
from moireid_studio.pages import verify
from moireid_studio.pages.verify import course_of
from moireid_studio.problems import Refusal

HEAD = "frame,time_s,measured_rad_0,predicted_rad_0,phase_sd_rad_0\n"
SECONDS = Seconds((), "1 s", (), "")


def job(folder: Path, lines: str, **result: Any) -> Job:
    """A job that left these signals."""
    (folder / "signals.csv").write_text(lines, encoding="utf-8")
    output = {"cover": {"film_s": [2.0, 3.0]}, "input": {"sha256": "of another film"}} | result
    return Job("1", "verify", "me", folder, result=output, kept={"files": []}, film_sha256="ab")


def test_a_course_is_in_widths_and_breaks_where_nobody_saw(tmp_path: Path) -> None:
    """Catches: radians drawn as widths, law and fringes exchanged, a line across frames that are missing; a film known
    by what the process that decoded it says of it.
    """
    lines = HEAD + "0,2.0,3.14159265,6.28318531,0.1\n1,2.1,0,0,inf\n2,2.2,0,0,0.1\n30,2.9,0,0,0.1\n"
    course = course_of(job(tmp_path, lines), SECONDS)
    assert course is not None and (course.sha256, course.from_s, course.to_s) == ("ab", 2.0, 3.0)
    assert course.frames[0] == [2.0, 1.0, 0.5] and course.frames[1] == [2.1, 0.0, None]
    assert course.frames[3:] == [[None, None, None], [2.9, 0.0, 0.0]]
    json.dumps(course.to_json(), allow_nan=False)


@pytest.mark.parametrize(
    "lines",
    ["", HEAD, HEAD + "0,2.0,0,0,0.1\n", HEAD + "0,nan,0,0,1\n1,2,0,0,1\n", HEAD + "0,2\n1,2\n", "a,b\n1,2\n3,4\n"],
)
def test_what_a_taken_over_process_left_is_no_page_s_end(lines: str, tmp_path: Path) -> None:
    """Catches: an error, or a NaN that no browser reads, from files that a film's process wrote."""
    assert course_of(job(tmp_path, lines), SECONDS) is None


def test_nothing_is_drawn_without_seconds_or_signals(tmp_path: Path) -> None:
    """Catches: a player on the page of a film of which nothing is known."""
    lines = HEAD + "0,2.0,0,0,0.1\n1,2.1,0,0,0.1\n"
    assert course_of(job(tmp_path, lines), None) is None and course_of(job(tmp_path, lines), SECONDS) is not None
    assert course_of(job(tmp_path, lines, cover=None), SECONDS) is None
    (tmp_path / "signals.csv").unlink()
    assert course_of(Job("1", "verify", "me", tmp_path, result={}, kept={"files": []}), SECONDS) is None


def test_a_huge_file_is_not_read_into_the_server_s_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a film's process that fills the server's memory by what it leaves."""
    monkeypatch.setattr(reports, "KEPT_BYTES", 1000)
    lines = HEAD + "0,2.0,0,0,0.1\n1,2.1,0,0,0.1\n"
    made = job(tmp_path, lines + " " * (1000 - len(lines)))
    assert len(reports.kept_file(made, "signals.csv")) == 1000
    with pytest.raises(Refusal):
        reports.kept_file(job(tmp_path, lines + " " * (1001 - len(lines))), "signals.csv")


def test_rows_beyond_the_drawn_ones_are_not_even_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: all rows of a long file made objects before most of them are dropped; the last one here is no row."""
    monkeypatch.setattr(verify, "MOST_FRAMES", 2)
    assert course_of(job(tmp_path, HEAD + "0,2.0,0,0,0.1\n1,2.1,0,0,0.1\nno,row\n"), SECONDS) is not None
