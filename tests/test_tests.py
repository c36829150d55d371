"""The rules of the tests' own tree.  Beside each: what it catches."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import kit
from kit.places import ROOT, TESTS

#: Each folder of tests, and the package whose tree it mirrors.
MIRRORS = {
    TESTS: ROOT / "src" / "moireid",
    ROOT / "studio" / "tests": ROOT / "studio" / "src" / "moireid_studio",
    ROOT / "lab" / "tests": ROOT / "lab" / "src" / "moireid_lab",
}
#: What stands beside the mirrored tree: whole ways through several rooms, pages in a browser, helpers, files.
OWN = {"browser", "data", "end_to_end", "kit"}
FILES = [path for tests in MIRRORS for path in tests.rglob("*.py") if "__pycache__" not in path.parts]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_test_imports_another(path: Path) -> None:
    """Catches: a helper that lives in a test file, so that neither can be moved or run alone."""
    modules = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            modules |= {node.module or "."} | {f"{node.module}.{alias.name}" for alias in node.names}
            assert node.level == 0, f"line {node.lineno}: import helpers as kit.NAME"
    assert [name for name in modules if re.search(r"(^|\.)(test_\w+|conftest)$", name)] == []


def test_every_folder_mirrors_one_of_the_source() -> None:
    """Catches: tests of a room that stay behind when the room moves."""
    for tests, source in MIRRORS.items():
        folders = {path.parent.relative_to(tests) for path in FILES if path.is_relative_to(tests)} - {Path()}
        assert [str(one) for one in folders if one.parts[0] not in OWN and not (source / one).is_dir()] == []


def test_the_map_of_the_kit_names_its_files() -> None:
    """Catches: a helper that nobody finds, and a name of one that is gone."""
    named = set(re.findall(r"(\w+\.py)", kit.__doc__ or ""))
    assert named == {path.name for path in (TESTS / "kit").glob("*.py")} - {"__init__.py"}


@pytest.mark.parametrize(("environment", "code"), [({}, 0), ({"CI": "1"}, 1)])
def test_a_skip_fails_the_run_where_ci_is_set(environment: dict[str, str], code: int, tmp_path: Path) -> None:
    """Catches: PostgreSQL or a browser that CI silently does not test; a bare machine on which nothing passes."""
    (tmp_path / "conftest.py").write_text((ROOT / "conftest.py").read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "test_it.py").write_text("import pytest\ndef test(): pytest.skip('none')\n")
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "--rootdir",
        str(tmp_path),
        str(tmp_path),
    ]
    told = subprocess.run(
        command, env={"PYTHONPATH": str(TESTS)} | environment, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert told.returncode == code, told.stdout
    assert "skipped" in told.stdout
