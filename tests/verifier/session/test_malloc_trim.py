"""Freed memory given back.  Each test states what it would catch."""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

import numpy as np
import pytest

from moireid.verifier.session import threads


def resident_mb() -> float:
    """Of this process."""
    return int(Path("/proc/self/status").read_text().partition("VmRSS:")[2].split()[0]) / 1e3


@pytest.mark.skipif(sys.platform != "linux", reason="glibc alone has it")
def test_freed_memory_goes_back_to_the_system():
    """Catches: a call that gives nothing back, as one with too large a pad."""
    # Pieces too small to be mapped one by one, the last of which keeps the heap from shrinking by itself.
    pieces = [np.ones(8000) for _ in range(1500)]
    last = np.ones(8000)
    held = resident_mb()
    pieces.clear()
    threads.return_freed_memory()
    assert resident_mb() < held - 60 and last.sum() == 8000


def test_a_library_without_it_is_left_alone(monkeypatch):
    """Catches: a verify that ends with an error where the system has another C library."""
    threads._trim.cache_clear()
    monkeypatch.setattr(ctypes, "CDLL", lambda name: object())
    threads.return_freed_memory()
    threads._trim.cache_clear()
