"""Every example runs as a person would run it, and leaves what it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kit.places import ROOT

EXAMPLES = ROOT / "examples"
LEAVES = {
    "01_print_a_badge.py": ("badge.json", "badge.pdf", "preview.png", "assembly.pdf"),
    "02_fringes_by_the_law.py": (),
    "03_film_and_verify.py": ("genuine.mp4.truth.csv", "genuine/report.html", "frozen/report.html"),
}


def test_every_example_is_listed_here() -> None:
    assert {path.name for path in EXAMPLES.glob("*.py")} == set(LEAVES)


@pytest.mark.parametrize("name", LEAVES)
def test_example_runs(name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), str(tmp_path)], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    for left in LEAVES[name]:
        assert (tmp_path / left).stat().st_size > 0
    if name.startswith("03"):
        verdicts = dict(line.split(":")[:2] for line in done.stdout.splitlines())
        assert verdicts["genuine"].split(",")[0].strip() == "accept"
        assert verdicts["frozen"].split(",")[0].strip() == "reject"
