"""Compiled functions that are kept on disk.  Each test names what it would catch."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from moireid.simulate import compiled

KERNEL = """
from typing import NamedTuple
from moireid.simulate.compiled import njit
from {module} import Pair

@njit(cache=True)
def total(pair):
    return pair.one + pair.other
"""
PAIR = "from typing import NamedTuple\nclass Pair(NamedTuple):\n    one: float\n    other: float\n"


def compiled_anew(folder: Path, module: str) -> int:
    """How often the kernel is compiled by a new process, its argument's type in the module."""
    (folder / f"{module}.py").write_text(PAIR, encoding="utf-8")
    source = folder / "kernel_of_test.py"
    if not source.exists() or f"from {module} " not in source.read_text(encoding="utf-8"):
        source.write_text(KERNEL.format(module=module), encoding="utf-8")
    code = (
        f"import kernel_of_test as k, {module} as m\n"
        "assert k.total(m.Pair(1.0, 2.0)) == 3.0\nprint(len(k.total.stats.cache_misses))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True)
    return int(done.stdout)


def test_what_names_a_module_that_is_gone_is_compiled_anew(tmp_path: Path) -> None:
    """Catches: a cache that raises ImportError after a module was renamed; one that is never used."""
    assert compiled_anew(tmp_path, "before") == 1
    assert compiled_anew(tmp_path, "before") == 0
    (tmp_path / "before.py").unlink()
    assert compiled_anew(tmp_path, "after") == 1


def test_a_change_of_any_compiled_file_counts(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Catches: a cache that looks for changes in the outermost function's file alone."""
    for name in ("compiled", "inner", "other"):
        (tmp_path / f"{name}.py").write_text("@njit()\n" if name == "inner" else "", encoding="utf-8")
    monkeypatch.setattr(compiled, "__file__", str(tmp_path / "compiled.py"))
    digest = compiled.kernel_digest.__wrapped__
    before = digest()
    (tmp_path / "other.py").write_text("x = 1\n", encoding="utf-8")
    assert digest() == before
    (tmp_path / "inner.py").write_text("@njit()\n# changed\n", encoding="utf-8")
    assert digest() != before
