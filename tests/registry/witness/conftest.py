"""Logs and witnesses for these tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from kit.witnesses import Log
from moireid.registry.witness.state import Witness


@pytest.fixture
def log() -> Log:
    return Log("example.com/log")


@pytest.fixture
def witness(tmp_path: Path, log: Log) -> Witness:
    return Witness(tmp_path / "witness.sqlite3", "witness.example/w1", [log.public])
