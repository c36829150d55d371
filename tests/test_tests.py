"""The rules of the tests' own tree.  Each names what it catches."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import kit
from kit.places import ROOT, TESTS

#: Each folder of tests, and the package whose tree it mirrors.
MIRRORS = {
    TESTS: ROOT / "src" / "moireid",
    ROOT / "studio" / "tests": ROOT / "studio" / "src" / "moireid_studio",
    ROOT / "lab" / "tests": ROOT / "lab" / "src" / "moireid_lab",
}
#: What is next to the mirrored tree: whole ways through several rooms, pages in a browser, helpers, files.
OWN = {"browser", "data", "end_to_end", "kit"}
FILES = [path for tests in MIRRORS for path in tests.rglob("*.py") if "__pycache__" not in path.parts]


def test_no_test_imports_another() -> None:
    """Catches: a helper that lives in a test file, so that neither can be moved or run alone."""
    wrong = re.compile(r" *(from \.|(from|import) ([\w.]+\.)?(test_\w+|conftest)\b|from .* import .*\btest_\w+)")
    lines = [(path, line) for path in FILES for line in path.read_text(encoding="utf-8").splitlines()]
    assert [(path, line) for path, line in lines if wrong.match(line)] == []


def test_every_folder_mirrors_one_of_the_source() -> None:
    """Catches: tests of a room that stay behind when the room moves."""
    for tests, source in MIRRORS.items():
        folders = {path.parent.relative_to(tests) for path in FILES if path.is_relative_to(tests)} - {Path()}
        assert [str(one) for one in folders if one.parts[0] not in OWN and not (source / one).is_dir()] == []


def test_the_map_of_the_kit_names_its_files() -> None:
    """Catches: a helper that nobody finds, and a name of one that is gone."""
    named = set(re.findall(r"(\w+\.py)", kit.__doc__ or ""))
    assert named == {path.name for path in (TESTS / "kit").glob("*.py")} - {"__init__.py"}


def test_a_skip_fails_the_run_where_ci_is_set(tmp_path: Path) -> None:
    """Catches: PostgreSQL or a browser that CI silently does not test; a bare machine on which nothing passes."""
    (tmp_path / "conftest.py").write_text((ROOT / "conftest.py").read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "test_it.py").write_text("import pytest\ndef test(): pytest.skip('none')\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", str(tmp_path)]
    bare = {"PYTHONPATH": str(TESTS), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    for environment, code in (({}, 0), ({"CI": "1"}, 1)):
        done = subprocess.run(
            command, env=bare | environment, cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert (done.returncode, "skipped" in done.stdout) == (code, True), done.stdout
