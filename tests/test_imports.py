"""What modules load, and the maps of folders; who may import whom is checked by `make lint` (pyproject.toml).

Next to each test: what it catches.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import moireid
import moireid_lab
import moireid_studio

ROOTS = [Path(package.__file__).parent for package in (moireid, moireid_studio, moireid_lab) if package.__file__]


def modules() -> list[Path]:
    """Every module of the project."""
    return [path for root in ROOTS for path in sorted(root.rglob("*.py"))]


def test_the_map_of_each_folder_names_its_files() -> None:
    """Catches: a map that forgets a file or a folder."""
    for folder in [path.parent for path in modules() if path.name == "__init__.py" and path.parent not in ROOTS]:
        text = (folder / "__init__.py").read_text(encoding="utf-8")
        parts = {path.name for path in folder.glob("*.py")} - {"__init__.py"}
        parts |= {f"{path.parent.name}/" for path in folder.glob("*/__init__.py")}
        assert {part for part in parts if part not in text} == set(), folder


@pytest.mark.claim("The verifier never loads simulator or fabrication")
def test_the_verifier_at_work_loads_neither_simulator_nor_workshop() -> None:
    """Catches: an import by way of a third module, which the rules for single files let through."""
    code = (
        "import sys\n"
        "import moireid.registry, moireid.verifier\n"
        "import moireid.verifier.session.identify, moireid.verifier.report.report_page\n"
        "print(*sorted(m for m in sys.modules if m.startswith(('moireid.simulate', 'moireid.fabrication', "
        "'build123d', 'mitsuba', 'cadquery', 'trimesh', 'numba', 'matplotlib'))))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
