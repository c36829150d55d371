"""Every example runs as a person would run it, and leaves what it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kit.places import ROOT
from moireid.verifier.video import Film

EXAMPLES = ROOT / "examples"
LEAVES = {
    "01_print_a_badge.py": ("badge.json", "badge.pdf", "preview.png", "assembly.pdf"),
    "02_fringes_by_the_law.py": (),
    "03_film_and_verify.py": ("genuine.mp4.truth.csv", "genuine/report.html", "frozen/report.html"),
}
#: What `make demo` shows two films with; it needs films and reports.
SIDE_BY_SIDE = "side_by_side.py"


def test_every_example_is_listed_here() -> None:
    assert {path.name for path in EXAMPLES.glob("*.py")} == {*LEAVES, SIDE_BY_SIDE}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name.startswith("03") else []) for name in LEAVES]
)
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
        shown_side_by_side(tmp_path)


def shown_side_by_side(folder: Path) -> None:
    """Catches: a film that ends before its sources do, or has another size than every player shows."""
    words = [word for name in ("genuine", "frozen") for word in (name, folder / f"{name}.mp4", folder / name)]
    subprocess.run([sys.executable, EXAMPLES / SIDE_BY_SIDE, folder / "both.mp4", *words], check=True, timeout=120)
    both = Film(folder / "both.mp4")
    assert (both.width, both.height, len(list(both.frames()))) == (1280, 720, 120)
    assert (folder / "both.png").stat().st_size > 0
