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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "safe", "unsafe"),
    [
        ("rows.c", "last_y = picture->height - 2 - top", "last_y = picture->height - 1 - top"),
        ("registration.c", "corner = picture->rows + top", "corner = picture->rows + picture->stride + top"),
        ("smear.c", "y = y > 0 ? y : 0;", ""),
        ("matching.c", "y = y < most_y ? y : most_y;", ""),
        ("squares.c", "y < picture->height ? y : picture->height - 1", "y"),
        ("squares.c", "TAKE(unused, 2 * runs)", "TAKE(unused, runs / 4)"),
    ],
)
def test_the_fence_ends_a_kernel_that_reads_outside(tmp_path, file, safe, unsafe):
    """Catches: a fuzzer that would find nothing."""
    sources = []
    for source in SOURCES:
        text = source.read_text()
        assert source.name != file or safe in text
        sources.append(tmp_path / source.name)
        sources[-1].write_text(text.replace(safe, unsafe) if source.name == file else text)
    (tmp_path / "kernel.h").write_text((SOURCES[0].parent / "kernel.h").read_text())
    assert fuzzed(trapping_library(tmp_path, *sources), 1, 1500) < 0
