"""Every example runs as a person would run it, and leaves what it says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from kit.places import FILMS, ROOT
from moireid.verifier.video import Film

EXAMPLES = ROOT / "examples"
LEAVES = {
    "01_print_a_badge.py": ("badge.json", "badge.pdf", "preview.png", "assembly.pdf"),
    "02_fringes_by_the_law.py": (),
    "03_film_and_verify.py": ("genuine.mp4.truth.csv", "genuine/report.html", "frozen/report.html"),
}
#: Those that are notebooks too: `# %%` begins a cell.
NOTEBOOKS = {
    "07_design_to_verdict.py": ("ada/badge.json", "true.mp4.truth.csv", "true.png", "report/report.html"),
    "08_measure_your_sheet.py": ("pitch_test.pdf", "my_sheet.json"),
}
#: Judges a stream; the film is of a board without an identity.
STREAM = "04_judge_opencv_frames.py"
#: What `make demo` shows two films with; it needs films and reports.
SIDE_BY_SIDE = "side_by_side.py"


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


def run_notebook(name: str, folder: Path) -> str:
    """What a notebook prints, run from its first cell to its last, with keys of its own."""
    own = {"MOIREID_KEYS": str(folder / "keys"), "MOIREID_SEEN": str(folder / "seen.sqlite3")}
    command = [sys.executable, str(EXAMPLES / name), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500, env=os.environ | own, check=False)
    assert done.returncode == 0, done.stderr
    for left in NOTEBOOKS[name]:
        assert (folder / left).stat().st_size > 0
    return done.stdout


@pytest.mark.slow
def test_from_design_to_verdict(tmp_path: Path) -> None:
    """Catches: a call of `import moireid as mo` that is gone, and a verdict that is another."""
    said = run_notebook("07_design_to_verdict.py", tmp_path)
    assert "true: FilmCheck(accept: Genuine, and Ada Lovelace's)" in said
    assert "forged: FilmCheck(reject: The fringes do not follow the law" in said
    assert "found: Ada Lovelace" in said
    true, forged = (float(found) for found in re.findall(r"measured phase is ([\d.]+) times", said))
    assert 0.9 < true < 1.1
    assert forged < 0.7


@pytest.mark.slow
def test_measure_your_own_sheet(tmp_path: Path) -> None:
    """Catches: a sheet that comes out as its label says, in place of what it is."""
    said = run_notebook("08_measure_your_sheet.py", tmp_path)
    pitch, built = map(float, re.findall(r"pitch ([\d.]+) mm.*built ([\d.]+) mm", said)[0])
    assert abs(pitch - built) < 2e-4 < abs(built - 25.4 / 50)


@pytest.mark.slow
def test_a_stream_is_judged_by_a_few_lines() -> None:
    """Catches: an example whose library has moved on, or that judges nothing."""
    for film, verdict in (("genuine_1.0m", "accept"), ("forged_reversed_1.0m", "reject")):
        command = [sys.executable, str(EXAMPLES / STREAM), str(FILMS / f"{film}.mp4"), str(FILMS / "badge.json")]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines()[-1] == verdict


def shown_side_by_side(folder: Path) -> None:
    """Catches: a film that ends before its sources do, or has another size than every player shows."""
    words = [word for name in ("genuine", "frozen") for word in (name, folder / f"{name}.mp4", folder / name)]
    subprocess.run([sys.executable, EXAMPLES / SIDE_BY_SIDE, folder / "both.mp4", *words], check=True, timeout=120)
    both = Film(folder / "both.mp4")
    assert (both.width, both.height, len(list(both.frames()))) == (1280, 720, 120)
    assert (folder / "both.png").stat().st_size > 0
