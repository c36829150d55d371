"""The studio under load and under loss, by the benchmarks that print its figures, made small.  Each test names the
wrong implementation it catches."""

from __future__ import annotations

import ast
import json
import subprocess
import sys

import pytest

from kit.places import ROOT
from kit.registries import running_server

pytestmark = pytest.mark.slow


def figures(name: str, *options: str) -> dict[str, str]:
    """What a benchmark prints, each figure by its name."""
    command = [sys.executable, str(ROOT / "benchmarks" / name), *options, "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=580)
    assert done.returncode == 0, done.stderr[-2000:]
    return {row["figure"]: row["value"] for row in json.loads(done.stdout)}


def test_silent_and_slow_ones_keep_nobody_waiting() -> None:
    """Catches: connections or places that are held by a visitor who sends nothing, and a log that grows with them."""
    found = figures("studio_flood.py", "--true", "8", "--before", "5", "--after", "0")
    assert found["true uploads"] == "{200: 8}", found
    assert int(found["bytes of the server's log"]) < 20_000


def test_no_film_is_lost_with_a_studio_or_a_worker() -> None:
    """Catches: the compose file's commands that do not work together; a job that is lost, or in the record twice."""
    with running_server():
        # Skipped here, and not within, where there is no PostgreSQL.
        pass
    found = figures("studio_cluster.py", "--films", "15")
    assert found["in the record"] == "15 of 15 jobs once, 0 more than once, 0 never", found


def test_uploads_outlast_a_database_that_is_away() -> None:
    """Catches: probes that fail with the database, so that every studio is restarted; an upload that ends in another
    answer than 503; a film that was accepted before, and is never judged or twice.

    The full figure, 200 uploads and a minute, is printed by `benchmarks/studio_cluster.py --no-kills --away 60`.
    """
    with running_server():
        # Skipped here, and not within, where there is no PostgreSQL.
        pass
    found = figures("studio_cluster.py", "--no-kills", "--films", "20", "--away", "8")
    health, missing, answers = (
        ast.literal_eval(found[name])
        for name in ("healthz while the database was away", "missing, by readyz", "answers to uploads")
    )
    assert set(health) == {200} and health[200] >= 10 and float(found["its longest answer, s"]) < 3.0, found
    assert missing["database and registry"] >= 10 and set(missing) <= {"database and registry", "nothing"}, found
    assert set(answers) == {202, 503} and answers[202] == 20, found
    assert found["in the record"] == "20 of 20 jobs once, 0 more than once, 0 never", found
    assert found["states"] == "{'done': 20}" and found["films in the record"] == "20, 0 twice", found
