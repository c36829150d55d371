"""The studio under load, by the benchmark that prints its figures, made small.  Each test names the wrong
implementation it catches."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from kit.places import ROOT

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
