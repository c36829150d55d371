"""The kernel under figures of every kind, compiled so that it ends where C is undefined."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kit.places import ROOT

SOURCES = sorted((ROOT / "src" / "moireid" / "verifier" / "kernel").glob("*.c"))
FLAGS = ("-O1", "-std=c11", "-fno-math-errno", "-fsanitize=undefined,float-cast-overflow", "-fsanitize-trap=all")


def trapping_library(folder: Path, *sources: Path) -> Path:
    """The kernel with a trap at each operation that C leaves undefined."""
    out = folder / "trapping.so"
    command = [sys.executable, "-m", "ziglang", "cc", *FLAGS, "-shared", "-fPIC", "-o", str(out), *map(str, sources)]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return out


def fuzzed(library: Path, seed: int, calls: int) -> int:
    command = [sys.executable, "-m", "kit.kernel_fuzz", str(library), str(seed), str(calls)]
    done = subprocess.run(command, cwd=ROOT / "tests", capture_output=True, text=True, timeout=500, check=False)
    return done.returncode


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_no_figures_make_the_kernel_read_outside_or_do_what_is_undefined(tmp_path, seed):
    """Catches: a place, an index or a shift out of range, a number turned into an integer that cannot hold it."""
    assert fuzzed(trapping_library(tmp_path, *SOURCES), seed, 3000) == 0
