"""The tests' own rule for CI."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from kit.places import ROOT, TESTS


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
