"""What a badge wears leaves phase and identity as they were, by the benchmark that prints its figures."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kit.programs import needs

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.parametrize(("form", "number"), [("cr80", 10), ("a6 (stripes|gala|campus)", 3)])
def test_artwork_leaves_phase_and_identity_as_they_were(form: str, number: int) -> None:
    """Catches: artwork that shifts the page's registration, or that the search takes for the badge.

    Of A6, those with most on the page: a row of it takes a minute.
    """
    needs("pdftoppm")
    command = [str(Path(sys.executable).with_name("moireid")), "lab", "bench", "artwork", "--only", form]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    rows = [line.split(maxsplit=6) for line in done.stdout.splitlines()[1:]]
    assert len(rows) == number
    for _, _, _, dots, strip_rad, frame_rad, output in rows:
        assert int(dots) == 0 and float(strip_rad) <= 0.002 and float(frame_rad) <= 0.002
        assert output == "both read"
