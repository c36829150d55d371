"""What modules load, and the maps of folders; who may import whom is checked by `make lint` (pyproject.toml).

Next to each test: what it catches.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

import moireid
import moireid_lab
import moireid_studio

ROOTS = [Path(package.__file__).parent for package in (moireid, moireid_studio, moireid_lab) if package.__file__]
#: `build123d` alone takes 5 s to import, so no module of ours may import these where it is merely loaded.
HEAVY = {
    "OCP",
    "build123d",
    "cadquery",
    "dask",
    "distributed",
    "drjit",
    "fsspec",
    "manifold3d",
    "mitsuba",
    "pyarrow",
    "trimesh",
}
#: Imports that only a type checker sees.
CHECKER_ONLY = {"TYPE_CHECKING", "typing.TYPE_CHECKING"}


def at_loading(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run when a module is loaded: not those in functions, nor those for type checkers."""
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        if isinstance(node, ast.If) and ast.unparse(node.test) in CHECKER_ONLY:
            yield from at_loading(node.orelse)
            continue
        yield node
        for part in ("body", "orelse", "finalbody"):
            yield from at_loading(getattr(node, part, []))
        for handler in getattr(node, "handlers", []):
            yield from at_loading(handler.body)


def loaded_packages(tree: ast.Module) -> set[str]:
    """Top-level packages that are imported by merely loading a module."""
    found = set()
    for node in at_loading(tree.body):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add((node.module or "").split(".")[0])
    return found


def modules() -> list[Path]:
    """Every module of the project."""
    return [path for root in ROOTS for path in sorted(root.rglob("*.py"))]


def parse(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def test_the_map_of_each_folder_names_its_files() -> None:
    """Catches: a map that forgets a file or a folder."""
    for folder in [path.parent for path in modules() if path.name == "__init__.py" and path.parent not in ROOTS]:
        text = (folder / "__init__.py").read_text(encoding="utf-8")
        parts = {path.name for path in folder.glob("*.py")} - {"__init__.py"}
        parts |= {f"{path.parent.name}/" for path in folder.glob("*/__init__.py")}
        assert {part for part in parts if part not in text} == set(), folder


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Catches: a circle that an import in a function, or one for type checkers, hides from Python."""
    graph = grimp.build_graph("moireid", "moireid_studio", "moireid_lab", cache_dir=None)
    needs = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert len(list(TopologicalSorter(needs).static_order())) == len(needs)


def test_heavy_packages_are_imported_within_functions_only() -> None:
    """Catches: `import build123d` at the top of a module that a verify or a --help loads."""
    broken = {str(path): sorted(loaded_packages(parse(path)) & HEAVY) for path in modules()}
    assert {name: found for name, found in broken.items() if found} == {}


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
