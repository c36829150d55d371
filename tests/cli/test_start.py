"""What a verify of a short film loads: never more than it needs, as loading took longer than judging.

Seconds are not tested, as they are those of the machine.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from kit.coded_films import first_frames

FILMS = Path(__file__).parents[1] / "data" / "films"
#: Packages for plots, pages, registries, signatures, clusters and numbers that a plain verify does without.
SPARED = {
    *("PIL", "c2pa", "cadquery", "cryptography", "dask", "distributed", "dlib", "fastapi", "fontTools", "jinja2"),
    *("matplotlib", "mitsuba", "numba", "platformdirs", "reportlab", "rich", "scipy", "securesystemslib"),
    *("sqlalchemy", "uvicorn"),
}


@pytest.mark.parametrize(
    ("name", "how", "exit_code"), [("genuine_1.0m", "--unsealed", 0), ("forged_reversed_1.0m", "", 1)]
)
def test_a_verify_loads_no_package_that_it_does_not_need(tmp_path: Path, name: str, how: str, exit_code: int) -> None:
    """Catches: one import of SciPy on the way to a verdict, which costs as much as two seconds of film; a decoder in
    the process that gives the verdict."""
    film = first_frames(FILMS / f"{name}.mp4", tmp_path / "film.mp4", 100)
    arguments = ["moireid", "verify", str(film), "--badge", str(FILMS / "badge.json"), "--json", *how.split()]
    code = (
        "import sys\n"
        "from moireid.cli.main import main\n"
        f"sys.argv = {arguments!r}\n"
        "try:\n    main()\nfinally:\n"
        "    print('LOADED', *{name.split('.')[0] for name in sys.modules}, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == exit_code, done.stderr
    assert json.loads(done.stdout)["frames"]["read"] == 100
    loaded = set(done.stderr.splitlines()[-1].split())
    assert {"LOADED", "click"} <= loaded
    # The sealed process alone has the decoder, reads pictures and computes.
    own, reading = how == "--unsealed" or sys.platform != "linux", {"av", "cv2", "numpy"}
    assert loaded & reading == (reading if own else set())
    assert loaded & SPARED <= {"platformdirs"}
