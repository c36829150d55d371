"""Readers of files that strangers give, on contents that a fuzzer found.  Each test names the fault that it catches."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from kit.places import TESTS
from kit.untrusted_readers import READERS, kept_corpus

#: Seconds for which each reader is fuzzed.
FUZZ_S = 4


@pytest.mark.claim("Every reader of untrusted files takes or refuses what it is given")
@pytest.mark.parametrize("name", READERS)
def test_kept_contents_are_taken_or_refused(name: str) -> None:
    """Catches: an error that is none of the reader's own; a corpus without a sound content."""
    contents = kept_corpus(name)
    assert len(contents) > 10 and any(READERS[name].takes(content) for content in contents.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_fuzzing_finds_no_fault(name: str, tmp_path: Path) -> None:
    """Catches: a content on which a reader raises an error of another kind, hangs, or takes 1 GB."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        pytest.skip("the fuzzer has wheels for Linux on x86-64 alone")
    command = [sys.executable, "-m", "kit.fuzzing", name, str(FUZZ_S), str(tmp_path / "corpus")]
    done = subprocess.run(command, env={**os.environ, "PYTHONPATH": str(TESTS)}, capture_output=True, text=True)
    faults = [path.read_bytes()[:2000] for path in tmp_path.glob("corpus.fault-*")]
    assert done.returncode == 0 and not faults, (faults, done.stderr[-3000:])
    assert "DONE" in done.stderr
